#!/usr/bin/env bash
# A Slurm for trying: munge, a controller and nodes of one processor each, all on this machine, in one folder.
#
#   scripts/slurm.sh up DIR [NODES]   starts it; then export SLURM_CONF=DIR/slurm.conf
#   scripts/slurm.sh node DIR K       starts node K again, which somebody has killed
#   scripts/slurm.sh down DIR         ends it
#
# As root, from Debian's packages slurm-wlm and munge (22.05 is tested). No systemd, no cgroups, no accounting.
set -euo pipefail

usage() {
    sed -n '2,9s/^# \{0,1\}//p' "$0" >&2
    exit 2
}
[ $# -ge 2 ] || usage
what=$1
mkdir -p "$2"
dir=$(realpath "$2")

# Starts a daemon of Slurm's, node K.
node() {
    mkdir -p "$dir/spool/n$1"
    slurmd -N "n$1" -f "$dir/slurm.conf"
}

case $what in
up)
    nodes=${3:-2}
    host=$(hostname -s)
    mkdir -p "$dir/state" "$dir/log" "$dir/run"
    chmod 755 "$dir" "$dir/run"
    sum=$(printf %s "$dir" | cksum | cut -d' ' -f1)
    port=$((20000 + sum % 20000))
    cat >"$dir/slurm.conf" <<CONF
ClusterName=trial
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket=$dir/run/munge.sock
StateSaveLocation=$dir/state
SlurmdSpoolDir=$dir/spool/%n
SlurmctldPidFile=$dir/run/slurmctld.pid
SlurmdPidFile=$dir/run/slurmd.%n.pid
SlurmctldLogFile=$dir/log/slurmctld
SlurmdLogFile=$dir/log/slurmd.%n
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
# As many processors as are said, not as there are.
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=2,bf_interval=2,requeue_delay=1
JobRequeue=1
ReturnToService=2
SlurmctldTimeout=10
SlurmdTimeout=10
InactiveLimit=0
KillWait=5
AccountingStorageType=accounting_storage/none
NodeName=n[1-$nodes] NodeHostname=$host NodeAddr=127.0.0.1 Port=[$((port + 1))-$((port + nodes))] CPUs=1 RealMemory=8000
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
CONF
    # What of cgroups this Slurm looks for even where it is told to use none.
    printf 'CgroupPlugin=autodetect\nIgnoreSystemd=yes\nConstrainCores=no\nConstrainRAMSpace=no\n' >"$dir/cgroup.conf"
    export SLURM_CONF=$dir/slurm.conf
    (umask 077 && head -c 1024 /dev/urandom >"$dir/munge.key")
    munged --force --key-file="$dir/munge.key" --socket="$dir/run/munge.sock" --pid-file="$dir/run/munged.pid" \
        --log-file="$dir/log/munged" --seed-file="$dir/run/munged.seed"
    slurmctld -f "$dir/slurm.conf"
    for k in $(seq "$nodes"); do node "$k"; done
    for _ in $(seq 100); do
        [ "$(sinfo -h -t idle -o %D 2>/dev/null)" = "$nodes" ] && exit 0
        sleep 0.2
    done
    sinfo -N -l >&2 || true
    tail -n 20 "$dir"/log/* >&2
    exit 1
    ;;
node)
    node "${3:?which node}"
    ;;
down)
    for file in "$dir"/run/slurmd.*.pid "$dir/run/slurmctld.pid" "$dir/run/munged.pid"; do
        [ -e "$file" ] || continue
        pid=$(cat "$file")
        kill "$pid" 2>/dev/null || true
        for _ in $(seq 50); do kill -0 "$pid" 2>/dev/null || break; sleep 0.1; done
        kill -KILL "$pid" 2>/dev/null || true
        rm -f "$file"
    done
    ;;
*)
    usage
    ;;
esac
