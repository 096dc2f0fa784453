#!/usr/bin/env bash
# Computes what is published of Salt Lake City, one run after the other, each going on from what is
# committed under results/salt-lake-city/NAME, and packs it so that it can be committed again.
#
#   scripts/family.sh                 all runs, in their order
#   scripts/family.sh resco nema-resco    these only
#   scripts/family.sh --list          their names
#
# The folder field is of the preset field of version 0.1.0, which this version cannot continue.
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
    "resco --preset resco --methods $untrained"
    "field-0.2.0 --preset field --methods $untrained"
    "resco-all-pairs --preset resco --set signal.actions=all-pairs --methods $untrained"
    "field-all-pairs-0.2.1 --preset field --set signal.actions=all-pairs --methods $untrained,nema"
    "intersections-resco --preset resco --set family.detail=per-approach --methods $untrained"
    "resco-0084 --preset resco --set family.hourly_share=0.084 --methods $untrained"
    "resco-0055 --preset resco --set family.hourly_share=0.055 --methods $untrained"
    "learners --preset resco --methods $learners $last"
    "learners-budget-20 --preset resco --budget 20 --sampling k-means --replicates 3 --methods $learners,mplight-star-resco $last"
    "ippo-budget-4 --preset resco --budget 4 --sampling k-means --episodes 1400 --methods baseline,ippo $last"
    "nema-resco --preset resco --methods baseline,nema"
    "nema-field-0.2.0 --preset field --methods baseline,nema"
    "nema-intersections-resco --preset resco --set family.detail=per-approach --methods baseline,nema"
    "intersections-field-0.2.1 --preset field --set family.detail=per-approach --methods baseline,nema,fixed-time,max-pressure,max-pressure-resco,actuated"
    "intersections-field-40 --preset field --set family.detail=per-approach --budget 40 --methods baseline,nema,fixed-time,max-pressure,max-pressure-resco,actuated"
    "learners-validated-20 --preset resco --budget 20 --assist results/salt-lake-city/resco --methods baseline,fixed-time,max-pressure,max-pressure-resco,actuated,nema,idqn,mplight,mplight-star"
    "learners-validated-field-20 --preset field --budget 20 --assist results/salt-lake-city/field-0.2.0 --methods baseline,fixed-time,max-pressure,max-pressure-resco,actuated,nema,idqn,mplight,mplight-star"
    "learners-validated --preset resco --methods baseline,idqn,mplight,mplight-star"
    "ten-methods-resco --preset resco --budget 80 --looks 10,20,40,80 --sampling bayesian-quadrature --until-decided=first-place --set training.patience=6 --methods fixed-time,max-pressure,max-pressure-resco,actuated,nema,idqn,ippo,mplight,mplight-star,mplight-star-resco"
    "resco-sumo-1.28 --preset resco --methods $untrained,nema"
    "field-sumo-1.28 --preset field --methods $untrained,nema"
    "ippo-validated-20 --preset resco --budget 20 --sampling balanced --episodes 400 --methods baseline,ippo"
)

if [ "${1:-}" = --list ]; then
    printf '%s\n' "${runs[@]}"
    exit
fi
if [ -z "${BINARY:-}" ]; then
    cargo build --release --quiet
    BINARY=${CARGO_TARGET_DIR:-target}/release/tsc-family
fi

# Packs the records of a run, as far as they are there.
pack() {
    tar -C "$1" --sort=name --mtime=@0 --owner=0 --group=0 -cJf "$1/records.tar.xz" done
    gzip -nkf "$1/plan.jsonl"
    echo "$1: $(find "$1/done" -name '*.jsonl' | wc -l) of $(wc -l <"$1/plan.jsonl") tasks" >&2
}

# Unpacks what was committed of a run.
unpack() {
    if [ ! -d "$1/done" ] && [ -e "$1/records.tar.xz" ]; then
        tar -xJf "$1/records.tar.xz" -C "$1"
        gunzip -kf "$1/plan.jsonl.gz"
    fi
}

for run in "${runs[@]}"; do
    name=${run%% *}
    if [ $# -gt 0 ] && [[ " $* " != *" $name "* ]]; then
        continue
    fi
    out=results/salt-lake-city/$name
    unpack "$out"
    if [[ $run =~ --assist\ ([^ ]+) ]]; then
        unpack "${BASH_REMATCH[1]}"
    fi
    code=0
    # shellcheck disable=SC2086 # the arguments of a run are words
    "$BINARY" run salt-lake-city ${run#* } --eval-seeds 5 --networks "networks/family/$name" \
        --out "$out" ${JOBS:+--jobs "$JOBS"} || code=$?
    [ -d "$out/done" ] && pack "$out"
    # 3: some tasks failed, which the report says.
    [ "$code" -eq 0 ] || [ "$code" -eq 3 ] || exit "$code"
done
