#!/usr/bin/env bash
# Runs the smoke scenario with learners through real batch systems and compares every record with those of this machine
# alone: Slurm with two nodes (one dies, a limit of time strikes, a run is cancelled and resumed), GNU parallel over two
# logins. As root on Debian, where missing packages are installed; elsewhere it says that it was skipped.
#
#   scripts/cluster.sh PROGRAM
#   scripts/cluster.sh PROGRAM --script   only the jobs of --executor script, which a loop starts
#   scripts/cluster.sh --prepare          only installs what it needs
set -euo pipefail
binary=$(realpath -m -- "$1")
scripts=$(realpath "$(dirname "$0")")

if [ "${2:-}" = --script ]; then
    folder=$(mktemp -d)
    trap 'rm -rf "$folder"' EXIT
    mkdir "$folder/my work"
    cd "$folder/my work"
    short=(smoke --methods max-pressure,idqn --episodes 4 --eval-seeds 2)
    "$binary" run "${short[@]}" --out out/here --quiet
    "$binary" run "${short[@]}" --out out/script --executor script --job-minutes 0.02
    last=$(($(wc -l <out/script/jobs/000/packs.jsonl) - 1))
    [ "$last" -gt 0 ] || { echo "FAILED: one job has all tasks" >&2; exit 1; }
    seq 0 "$last" | xargs -P 2 -n 1 "$PWD/out/script/jobs/000/job.sh"
    "$binary" status out/script
    python3 "$scripts/same-records.py" out/here out/script
    exit
fi

packages=(slurm-wlm munge parallel openssh-server)
if [ "$(id -u)" -ne 0 ] || ! command -v apt-get >/dev/null; then
    echo "SKIPPED: batch systems are tried as root on Debian only"
    exit 0
fi
if ! command -v slurmctld munged parallel sshd >/dev/null; then
    export DEBIAN_FRONTEND=noninteractive
    { apt-get update && apt-get install -y --no-install-recommends "${packages[@]}"; } >/dev/null
fi
[ "$1" != --prepare ] || exit 0

folder=$(mktemp -d)
# The programs of batch systems look at what is above what they work in.
chmod 755 "$folder"
slurm=$folder/slurm
sshd_pid=
cleanup() {
    [ -z "$sshd_pid" ] || kill "$sshd_pid" 2>/dev/null || true
    scancel --quiet --me 2>/dev/null || true
    "$scripts/slurm.sh" down "$slurm" || true
    rm -rf "$folder"
}
trap cleanup EXIT
# What a user's folder may be called.
mkdir "$folder/my work"
cd "$folder/my work"

failed() {
    echo "FAILED: $*" >&2
    for run in out/*/; do
        "$binary" status "$run" >&2 || true
        tail -n 20 "$run"/jobs/*/out/* >&2 2>/dev/null || true
    done
    tail -n 40 "$slurm"/log/* >&2 2>/dev/null || true
    exit 1
}
# Waits until a command succeeds, so many seconds at most.
wait_for() {
    local most=$1
    shift
    local end=$((SECONDS + most))
    until "$@" >/dev/null 2>&1; do
        [ "$SECONDS" -lt "$end" ] || failed "not within $most s: $*"
        sleep 0.5
    done
}
is_done() { "$binary" status "$1"; }
# The same; Slurm lets two minutes pass before a job that has put itself back into the queue starts again. Ten seconds do:
# one that starts while its last turn is still being cleared away is refused by its node ("credential revoked") and lost.
is_done_soon() {
    local job start
    while read -r job start; do
        [ "$(date -d "$start" +%s)" -le "$(($(date +%s) + 15))" ] || scontrol update "JobId=$job" StartTime=now+10 || true
    done < <(squeue --noheader --states=pending --format='%i %S' | grep -v 'N/A$')
    is_done "$1"
}
# Compares two runs, wall-clock values aside.
same() {
    echo "$2 and $1:"
    python3 "$scripts/same-records.py" "$1" "$2" || failed "$2 differs from $1"
}
field() { "$binary" status --json "$1" | sed "s/.*\"$2\":\([^,}]*\).*/\1/"; }
has_worker() { ls "$1"/tmp/*/.lock; }
has_done() { [ "$(field "$1" done)" -ge "$2" ]; }

short=(smoke --methods max-pressure,idqn,ippo --episodes 30 --eval-seeds 2)
long=(smoke --methods idqn --episodes 400 --eval-seeds 2)
"$binary" run "${short[@]}" --out out/here --quiet

with_slurm() {
    export SLURM_CONF=$slurm/slurm.conf
    "$binary" run "${short[@]}" --out out/slurm --executor slurm --job-minutes 0.02
    wait_for 600 is_done out/slurm
    same out/here out/slurm
    "$binary" resume out/slurm >/dev/null
    test -s out/slurm/report/index.html || failed "no report"

    echo "--- Slurm, cancelled and resumed"
    "$binary" run "${short[@]}" --out out/cancelled --executor slurm --job-minutes 0.02
    wait_for 300 has_done out/cancelled 1
    "$binary" cancel out/cancelled
    wait_for 300 sh -c '[ -z "$(squeue --noheader)" ]'
    "$binary" status out/cancelled && failed "it was cancelled and is done all the same"
    before=$(sha256sum out/cancelled/done/000/*)
    "$binary" resume out/cancelled
    wait_for 600 is_done out/cancelled
    echo "$before" | sha256sum --quiet --check || failed "a finished record was written again"
    same out/here out/cancelled

    echo "--- Slurm, a limit of time and a node that dies"
    "$binary" run "${long[@]}" --out out/long --quiet &
    echo '#SBATCH --time=2' >lines
    "$binary" run "${long[@]}" --out out/limit --executor slurm --sbatch lines --job-minutes 0.02
    "$binary" resume out/limit && failed "it was resumed without its lines"
    wait_for 300 has_worker out/limit
    node=$(squeue --noheader --states=running --format=%N | tail -n 1)
    echo "node $node dies; its jobs do not"
    kill -KILL "$(cat "$slurm/run/slurmd.$node.pid")"
    wait_for 600 sh -c "sinfo --noheader --nodes=$node --format=%T | grep -q down"
    rm -f "$slurm/run/slurmd.$node.pid"
    "$scripts/slurm.sh" node "$slurm" "${node#n}"
    wait_for 1800 is_done_soon out/limit
    wait
    same out/long out/limit
    grep -q "stopped with . task" out/limit/jobs/000/out/* || failed "no limit of time was met"
    grep -rq "training continues after episode" out/limit/logs || failed "no training went on from its checkpoint"
    "$binary" check out/limit
}
echo "--- Slurm"
if "$scripts/slurm.sh" up "$slurm" 2; then
    with_slurm
else
    echo "SKIPPED: no Slurm can be started here, see above; its jobs were not tried"
fi

echo "--- GNU parallel over two logins"
mkdir -m 700 ssh
ssh-keygen -q -t ed25519 -N '' -f ssh/host
ssh-keygen -q -t ed25519 -N '' -f ssh/own
cp ssh/own.pub ssh/authorized
port=$((40000 + RANDOM % 20000))
mkdir -p /run/sshd
printf '%s\n' "Port $port" "ListenAddress 127.0.0.1" "HostKey \"$PWD/ssh/host\"" "PidFile none" "StrictModes no" \
    "AuthorizedKeysFile \"$PWD/ssh/authorized\"" "UsePAM no" "PermitRootLogin yes" >ssh/sshd_config
"$(command -v sshd)" -D -f "$PWD/ssh/sshd_config" -E "$PWD/ssh/log" &
sshd_pid=$!
printf '%s\n' "Host one two" "  HostName 127.0.0.1" "  Port $port" "  IdentityFile \"$PWD/ssh/own\"" \
    "  StrictHostKeyChecking no" "  UserKnownHostsFile /dev/null" "  LogLevel ERROR" >ssh/config
cp ssh/config "$folder/ssh_config"
wait_for 20 ssh -F "$folder/ssh_config" one true
"$binary" run "${short[@]}" --out out/script --executor script --job-minutes 0.02
last=$(($(wc -l <out/script/jobs/000/packs.jsonl) - 1))
seq 0 "$last" | parallel --will-cite --ssh "ssh -F $folder/ssh_config" --sshlogin 1/one,1/two --retries 3 \
    --joblog joblog "'$PWD/out/script/jobs/000/job.sh'" || failed "parallel: $(cat joblog)"
[ "$(tail -n +2 joblog | cut -f2 | sort -u | wc -l)" -eq 2 ] || failed "one login did everything: $(cat joblog)"
is_done out/script || failed "tasks are missing"
same out/here out/script
echo "every record is the same, whoever did the task"
