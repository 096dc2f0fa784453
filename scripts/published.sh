#!/usr/bin/env bash
# Computes what is published under results/, one run after the other, each going on from what is committed under
# results/NAME, and packs it so that it can be committed again. Control tasks need no SUMO. All runs make their reports;
# --reports makes those of what is committed, and computes nothing.
#
#   scripts/published.sh                                           all runs, in their order
#   scripts/published.sh cartpole salt-lake-city/resco             those of a folder, and one run
#   scripts/published.sh --reports [...]                           reports of these
#   scripts/published.sh --list                                    their names
#
# Ctrl-C stops it, and the same command continues. JOBS is the number of workers, BINARY a program to
# use instead of building one: a copy that later builds leave alone.
set -euo pipefail
cd "$(dirname "$0")/.."

untrained=baseline,fixed-time,max-pressure,max-pressure-resco,actuated
learners=baseline,idqn,ippo,mplight,mplight-star
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
    "salt-lake-city/resco salt-lake-city --preset resco --methods $untrained"
    "salt-lake-city/field-0.2.0 salt-lake-city --preset field --methods $untrained"
    "salt-lake-city/resco-all-pairs salt-lake-city --preset resco --set signal.actions=all-pairs --methods $untrained"
    "salt-lake-city/field-all-pairs-0.2.1 salt-lake-city --preset field --set signal.actions=all-pairs --methods $untrained,nema"
    "salt-lake-city/intersections-resco salt-lake-city --preset resco --set family.detail=per-approach --methods $untrained"
    "salt-lake-city/nema-resco salt-lake-city --preset resco --methods baseline,nema"
    "salt-lake-city/nema-field-0.2.0 salt-lake-city --preset field --methods baseline,nema"
    "salt-lake-city/nema-intersections-resco salt-lake-city --preset resco --set family.detail=per-approach --methods baseline,nema"
    "salt-lake-city/intersections-field-0.2.1 salt-lake-city --preset field --set family.detail=per-approach --methods baseline,nema,fixed-time,max-pressure,max-pressure-resco,actuated"
    "salt-lake-city/learners-validated-field-20 salt-lake-city --preset field --budget 20 --assist results/salt-lake-city/field-0.2.0 --methods baseline,fixed-time,max-pressure,max-pressure-resco,actuated,nema,idqn,mplight,mplight-star"
    "salt-lake-city/learners-validated salt-lake-city --preset resco --methods baseline,idqn,mplight,mplight-star"
    "salt-lake-city/ten-methods-resco salt-lake-city --preset resco --budget 80 --looks 10,20,40,80 --sampling bayesian-quadrature --until-decided --within 0 --set training.patience=6 --methods fixed-time,max-pressure,max-pressure-resco,actuated,nema,idqn,ippo,mplight,mplight-star"
    "salt-lake-city/tuned-resco-20 salt-lake-city --preset resco --budget 20 --tune max-pressure,nema,actuated --methods fixed-time"
    "salt-lake-city/ippo-validated-20 salt-lake-city --preset resco --budget 20 --sampling balanced --episodes 400 --methods baseline,ippo"
)

if [ "${1:-}" = --list ]; then
    printf '%s\n' "${runs[@]}"
    exit
fi
reports=
if [ "${1:-}" = --reports ]; then
    reports=yes
    shift
fi
if [ -z "${BINARY:-}" ]; then
    cargo build --release --quiet
    BINARY=${CARGO_TARGET_DIR:-target}/release/tsc-family
fi

for run in "${runs[@]}"; do
    name=${run%% *}
    if [ $# -gt 0 ] && [[ " $* " != *" $name "* && " $* " != *" ${name%/*} "* ]]; then
        continue
    fi
    out=results/$name
    if [ -n "$reports" ]; then
        "$BINARY" report "$out"
        continue
    fi
    more="--eval-seeds 20"
    if [[ $name == salt-lake-city/* ]]; then
        more="--eval-seeds 5 --networks networks/family/${name#*/}"
    fi
    code=0
    # shellcheck disable=SC2086 # the arguments of a run are words
    "$BINARY" run ${run#* } $more --out "$out" ${JOBS:+--jobs "$JOBS"} || code=$?
    [ ! -d "$out/done" ] || "$BINARY" export "$out"
    # 3: some tasks failed, which the report says.
    [ "$code" = 0 ] || [ "$code" = 3 ] || exit "$code"
done
