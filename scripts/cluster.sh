#!/usr/bin/env bash
# Runs the smoke scenario with a learner through batch systems and compares every record with those of this machine alone.
#
#   scripts/cluster.sh PROGRAM --script   the jobs of --executor script, which xargs starts
#   scripts/cluster.sh PROGRAM            these, and on Debian as root a Slurm of one node whose jobs meet a limit of time
#   scripts/cluster.sh --prepare          only installs what Slurm needs
set -euo pipefail
binary=$(realpath -m -- "$1")
scripts=$(realpath "$(dirname "$0")")

prepare() {
    command -v slurmctld munged >/dev/null ||
        { apt-get update && DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends slurm-wlm munge; } >/dev/null
}
[ "$1" != --prepare ] || { prepare; exit 0; }

folder=$(mktemp -d)
chmod 755 "$folder"
trap 'rm -rf "$folder"' EXIT
# What a user's folder may be called.
mkdir "$folder/my work"
cd "$folder/my work"
short=(smoke --methods max-pressure,idqn --episodes 30 --eval-seeds 2)
"$binary" run "${short[@]}" --out here --quiet
"$binary" run "${short[@]}" --out script --executor script --job-minutes 0.02
last=$(($(wc -l <script/jobs/000/packs.jsonl) - 1))
[ "$last" -gt 0 ] || { echo "FAILED: one job has all tasks" >&2; exit 1; }
seq 0 "$last" | xargs -P 2 -n 1 "$PWD/script/jobs/000/job.sh"
"$binary" status script
python3 "$scripts/same-records.py" here script
[ "${2:-}" != --script ] || exit 0

[ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null || { echo "SKIPPED: Slurm is tried as root on Debian only"; exit 0; }
prepare
slurm=$folder/slurm
mkdir -p "$slurm"/{state,log,run,spool}
chmod 755 "$slurm" "$slurm/run"
host=$(hostname -s)
# No systemd, no cgroups, no accounting.
cat >"$slurm/slurm.conf" <<CONF
ClusterName=trial
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=27817
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket=$slurm/run/munge.sock
StateSaveLocation=$slurm/state
SlurmdSpoolDir=$slurm/spool/%n
SlurmctldPidFile=$slurm/run/slurmctld.pid
SlurmdPidFile=$slurm/run/slurmd.pid
SlurmctldLogFile=$slurm/log/slurmctld
SlurmdLogFile=$slurm/log/slurmd
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=2,bf_interval=2,requeue_delay=1
JobRequeue=1
ReturnToService=2
KillWait=5
AccountingStorageType=accounting_storage/none
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=27818 CPUs=2 RealMemory=8000
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
printf 'CgroupPlugin=autodetect\nIgnoreSystemd=yes\nConstrainCores=no\nConstrainRAMSpace=no\n' >"$slurm/cgroup.conf"
export SLURM_CONF=$slurm/slurm.conf
trap 'for f in "$slurm"/run/*.pid; do kill "$(cat "$f")" || true; done 2>/dev/null; sleep 1; rm -rf "$folder"' EXIT
(umask 077 && head -c 1024 /dev/urandom >"$slurm/munge.key")
munged --force --key-file="$slurm/munge.key" --socket="$slurm/run/munge.sock" --pid-file="$slurm/run/munged.pid" \
    --log-file="$slurm/log/munged" --seed-file="$slurm/run/munged.seed"
slurmctld -f "$SLURM_CONF"
slurmd -N n1 -f "$SLURM_CONF"
for _ in $(seq 100); do [ "$(sinfo -h -t idle -o %D 2>/dev/null)" = 1 ] && break || sleep 0.2; done
echo '#SBATCH --time=2' >lines
long=(smoke --methods idqn --episodes 400 --eval-seeds 2)
"$binary" run "${long[@]}" --out alone --quiet &
"$binary" run "${long[@]}" --out slurm --executor slurm --sbatch lines --job-minutes 0.02
end=$((SECONDS + 1800)) before=
until "$binary" status slurm >/dev/null; do
    [ "$SECONDS" -lt "$end" ] || { tail -n 30 "$slurm"/log/* slurm/jobs/*/out/* >&2; exit 1; }
    # Slurm lets two minutes pass before a job that has put itself back into the queue starts again. One that was not there
    # at the last look may still be ending.
    now=$(squeue -h -t pending -o '%i %r' | sed -n 's/ BeginTime$//p' | sort)
    comm -12 - <(printf '%s\n' "$now") <<<"$before" | xargs -rI{} scontrol update JobId={} StartTime=now || true
    before=$now
    sleep 5
done
wait %1
python3 "$scripts/same-records.py" alone slurm
grep -rq "training continues after episode" slurm/logs || { echo "FAILED: no limit of time was met" >&2; exit 1; }
