#!/usr/bin/env bash
# Trains every learner on the whole family of Salt Lake City, going on from what is committed under
# results/salt-lake-city/learners, and packs the result so that it can be committed again.
# Arguments go to `tsc-family run`; Ctrl-C stops it, and the same command continues.
set -euo pipefail
cd "$(dirname "$0")/.."

out=results/salt-lake-city/learners
methods=baseline,fixed-time,max-pressure,actuated,idqn,ippo,mplight,mplight-star,mplight-star-resco

if [ ! -d "$out/done" ] && [ -e "$out/records.tar.xz" ]; then
    tar -xJf "$out/records.tar.xz" -C "$out"
    gunzip -kf "$out/plan.jsonl.gz"
fi
cargo build --release --quiet
code=0
"${CARGO_TARGET_DIR:-target}/release/tsc-family" run --methods "$methods" --out "$out" "$@" || code=$?
"${CARGO_TARGET_DIR:-target}/release/tsc-family" report "$out" >/dev/null
tar -C "$out" --sort=name --mtime=@0 --owner=0 --group=0 -cJf "$out/records.tar.xz" done
gzip -nkf "$out/plan.jsonl"
echo "$(find "$out/done" -name '*.jsonl' | wc -l) of $(wc -l <"$out/plan.jsonl") tasks are packed" >&2
exit "$code"
