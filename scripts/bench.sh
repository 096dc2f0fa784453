#!/usr/bin/env bash
# Runs the benchmarks; `scripts/bench.sh > benches/runs/NAME.md` keeps their figures.
set -euo pipefail
cd "$(dirname "$0")/.."

echo "tsc-family $(git describe --always --dirty 2>/dev/null || echo unknown)," \
    "$(nproc) processors, $(uname -sm), $(rustc --version)"
echo
cargo bench --quiet --bench main_job
cargo bench --quiet --bench training
