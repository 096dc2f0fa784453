#!/usr/bin/env bash
# Computes what is published under results/, one run after the other, each going on from what is committed under
# results/NAME, and packs it so that it can be committed again. Control tasks need no SUMO.
#
#   scripts/published.sh                                           all runs, in their order
#   scripts/published.sh cartpole salt-lake-city/resco             those of a folder, and one run
#   scripts/published.sh --list                                    their names
#
# The folders *-sumo-1.28 need a BINARY that was built with SUMO 1.28 (docs/install.md), and its SUMO_HOME.
#
# Ctrl-C stops it, and the same command continues. JOBS is the number of workers, BINARY a program to
# use instead of building one: a copy that later builds leave alone.
set -euo pipefail
cd "$(dirname "$0")/.."

untrained=baseline,fixed-time,max-pressure,max-pressure-resco,actuated
learners=baseline,idqn,ippo,mplight,mplight-star
# Trainings from before policies were chosen on validation seeds: their last policies.
last="--set training.select=last --set training.restart=never"
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
    "salt-lake-city/resco-0084 salt-lake-city --preset resco --set family.hourly_share=0.084 --methods $untrained"
    "salt-lake-city/resco-0055 salt-lake-city --preset resco --set family.hourly_share=0.055 --methods $untrained"
    "salt-lake-city/learners-budget-20 salt-lake-city --preset resco --budget 20 --sampling k-means --replicates 3 --methods $learners $last"
    "salt-lake-city/ippo-budget-4 salt-lake-city --preset resco --budget 4 --sampling k-means --episodes 1400 --methods baseline,ippo $last"
    "salt-lake-city/nema-resco salt-lake-city --preset resco --methods baseline,nema"
    "salt-lake-city/nema-field-0.2.0 salt-lake-city --preset field --methods baseline,nema"
    "salt-lake-city/nema-intersections-resco salt-lake-city --preset resco --set family.detail=per-approach --methods baseline,nema"
    "salt-lake-city/intersections-field-0.2.1 salt-lake-city --preset field --set family.detail=per-approach --methods baseline,nema,fixed-time,max-pressure,max-pressure-resco,actuated"
    "salt-lake-city/intersections-field-40 salt-lake-city --preset field --set family.detail=per-approach --budget 40 --methods baseline,nema,fixed-time,max-pressure,max-pressure-resco,actuated"
    "salt-lake-city/learners-validated-field-20 salt-lake-city --preset field --budget 20 --assist results/salt-lake-city/field-0.2.0 --methods baseline,fixed-time,max-pressure,max-pressure-resco,actuated,nema,idqn,mplight,mplight-star"
    "salt-lake-city/learners-validated salt-lake-city --preset resco --methods baseline,idqn,mplight,mplight-star"
    "salt-lake-city/ten-methods-resco salt-lake-city --preset resco --budget 80 --looks 10,20,40,80 --sampling bayesian-quadrature --until-decided=first-place --set training.patience=6 --methods fixed-time,max-pressure,max-pressure-resco,actuated,nema,idqn,ippo,mplight,mplight-star"
    "salt-lake-city/resco-sumo-1.28 salt-lake-city --preset resco --methods $untrained,nema"
    "salt-lake-city/field-sumo-1.28 salt-lake-city --preset field --methods $untrained,nema"
    "salt-lake-city/ippo-validated-20 salt-lake-city --preset resco --budget 20 --sampling balanced --episodes 400 --methods baseline,ippo"
)

if [ "${1:-}" = --list ]; then
    printf '%s\n' "${runs[@]}"
    exit
fi
if [ -z "${BINARY:-}" ]; then
    cargo build --release --quiet
    BINARY=${CARGO_TARGET_DIR:-target}/release/tsc-family
fi

# Packs files of a run. PACK FILES
pack() {
    tar -C "$out" --sort=name --mtime=@0 --owner=0 --group=0 --exclude=lock.json -cJf "$out/$1" "${@:2}"
}

# Unpacks what was committed of a run.
unpack() {
    if [ ! -d "$1/done" ] && [ -e "$1/progress.tar.xz" ]; then
        tar -xJf "$1/progress.tar.xz" -C "$1"
    elif [ ! -d "$1/done" ] && [ -e "$1/records.tar.xz" ]; then
        tar -xJf "$1/records.tar.xz" -C "$1"
        gunzip -kf "$1/plan.jsonl.gz"
    fi
}

for run in "${runs[@]}"; do
    name=${run%% *}
    if [ $# -gt 0 ] && [[ " $* " != *" $name "* && " $* " != *" ${name%/*} "* ]]; then
        continue
    fi
    out=results/$name
    unpack "$out"
    if [[ $run =~ --assist\ ([^ ]+) ]]; then
        unpack "${BASH_REMATCH[1]}"
    fi
    more="--eval-seeds 20"
    if [[ $name == salt-lake-city/* ]]; then
        more="--eval-seeds 5 --networks networks/family/${name#*/}"
    fi
    code=0
    # shellcheck disable=SC2086 # the arguments of a run are words
    "$BINARY" run ${run#* } $more --out "$out" ${JOBS:+--jobs "$JOBS"} || code=$?
    if [ -d "$out/done" ]; then
        echo "$out: $(find "$out/done" -name '*.jsonl' | wc -l) of $(wc -l <"$out/plan.jsonl") tasks" >&2
    fi
    case $code in
        # 3: some tasks failed, which the report says.
        0 | 3)
            pack records.tar.xz done
            gzip -nkf "$out/plan.jsonl"
            rm -f "$out/progress.tar.xz"
            ;;
        # What an interrupted run has done is no result yet, and only this script reads it.
        *)
            # shellcheck disable=SC2046 # names without spaces
            [ ! -d "$out/done" ] || pack progress.tar.xz $(cd "$out" && echo *.json plan.jsonl done)
            exit "$code"
            ;;
    esac
done
