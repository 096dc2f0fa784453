#!/usr/bin/env bash
# Builds the program and runs the main job on the embedded family with a small budget.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo build --profile quick
binary="${CARGO_TARGET_DIR:-target}/quick/tsc-family"
"$binary" doctor
"$binary" run salt-lake-city --budget "${BUDGET:-6}" --eval-seeds 3 --out results/demo
echo "Open results/demo/report/index.html in a browser."
