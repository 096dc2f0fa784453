#!/usr/bin/env bash
# Builds in release and runs the main job on the embedded family with a small budget.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo build --release
binary="${CARGO_TARGET_DIR:-target}/release/tsc-family"
"$binary" doctor
"$binary" run salt-lake-city --budget "${BUDGET:-6}" --eval-seeds 3 --out results/demo
echo "Open results/demo/report/index.html in a browser."
