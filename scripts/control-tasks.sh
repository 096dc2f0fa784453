#!/usr/bin/env bash
# Computes what is published of control tasks, one run after the other, each going on from what is committed under
# results/NAME, and packs it so that it can be committed again. On one core, without SUMO.
#
#   scripts/control-tasks.sh                                    all runs, in their order
#   scripts/control-tasks.sh cartpole/carl control-tasks/quad   these only
#   scripts/control-tasks.sh --list                             their names
#
# Ctrl-C stops it, and the same command continues. JOBS is the number of workers, BINARY a program to
# use instead of building one.
set -euo pipefail
cd "$(dirname "$0")/.."

# Name, then the arguments of `tsc-family run`.
runs=(
    "cartpole/carl cartpole --methods ppo,dqn"
    "cartpole/gymnasium-start cartpole --set environment.start=0.05 --methods ppo,dqn"
    "cartpole/physical cartpole --set environment.dynamics=physical --methods ppo,dqn"
    "cartpole/tuned cartpole --preset tuned --methods ppo"
    "cartpole/trpo-ars cartpole --methods trpo,ars"
    "control-tasks/quad quad --methods ppo,trpo"
    "control-tasks/pendulum-swing-up pendulum-swing-up --methods ppo,trpo"
    "control-tasks/pendulum pendulum --budget 20 --methods ppo,trpo,sac,td3 --set sac.total_steps=10000 --set td3.total_steps=10000"
    "control-tasks/mountain-car mountain-car --methods ppo,trpo"
    "control-tasks/swimmer swimmer --preset tuned --methods ppo,trpo"
    "control-tasks/half-cheetah half-cheetah --budget 20 --methods ppo,trpo"
)

if [ "${1:-}" = --list ]; then
    printf '%s\n' "${runs[@]}"
    exit
fi
if [ -z "${BINARY:-}" ]; then
    cargo build --release --quiet
    BINARY=${CARGO_TARGET_DIR:-target}/release/tsc-family
fi

for run in "${runs[@]}"; do
    name=${run%% *}
    if [ $# -gt 0 ] && [[ " $* " != *" $name "* ]]; then
        continue
    fi
    out=results/$name
    if [ ! -d "$out/done" ] && [ -e "$out/records.tar.xz" ]; then
        tar -xJf "$out/records.tar.xz" -C "$out"
        gunzip -kf "$out/plan.jsonl.gz"
    fi
    code=0
    # shellcheck disable=SC2086 # the arguments of a run are words
    "$BINARY" run ${run#* } --eval-seeds 20 --jobs "${JOBS:-1}" --out "$out" || code=$?
    tar -C "$out" --sort=name --mtime=@0 --owner=0 --group=0 -cJf "$out/records.tar.xz" done
    gzip -nkf "$out/plan.jsonl"
    echo "$out: $(find "$out/done" -name '*.jsonl' | wc -l) of $(wc -l <"$out/plan.jsonl") tasks" >&2
    # Failed tasks are results too; a run that was stopped is not.
    if [ "$code" -ne 0 ] && [ "$code" -ne 3 ]; then
        exit "$code"
    fi
done
