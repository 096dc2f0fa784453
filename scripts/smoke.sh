#!/usr/bin/env bash
# Runs the smoke scenario end to end with a built binary, from an empty folder.
set -euo pipefail
binary=$(realpath "$1")
scripts=$(realpath "$(dirname "$0")")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"

"$binary" doctor
"$binary" run smoke --eval-seeds 2 --out results/smoke
"$binary" run smoke --eval-seeds 2 --out results/again --jobs 1 --quiet
python3 "$scripts/same-records.py" results/smoke results/again
"$binary" report results/smoke
test -s results/smoke/report/index.html
test "$(wc -l <results/smoke/report/scores.csv)" -eq 11
