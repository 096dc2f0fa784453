#!/usr/bin/env bash
# Runs the smoke scenario end to end with a built binary, from an empty folder.
set -euo pipefail
binary=$(realpath "$1")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

"$binary" doctor
"$binary" run smoke --eval-seeds 2 --out results/smoke
"$binary" run smoke --eval-seeds 2 --out results/again --jobs 1 --quiet
for record in results/smoke/done/000/*.jsonl; do
    other=results/again/done/000/$(basename "$record")
    # Wall-clock values are the only difference that is allowed.
    strip='s/,"wall":{[^}]*}//'
    cmp <(sed "$strip" "$record") <(sed "$strip" "$other") || {
        echo "$record depends on the number of workers" >&2
        exit 1
    }
done
"$binary" report results/smoke
test -s results/smoke/report/index.html
test "$(wc -l <results/smoke/report/scores.csv)" -eq 9
