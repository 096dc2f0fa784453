#!/usr/bin/env bash
# Reads what `tsc-family export` writes with polars, pandas and DuckDB from PyPI: every cell must be what the record says.
#
#   scripts/export.sh [PROGRAM]
#   scripts/export.sh --prepare   only installs what it needs
set -euo pipefail
program=$(realpath -m -- "${1:-${CARGO_TARGET_DIR:-$(dirname "$0")/../target}/release/tsc-family}")
cd "$(dirname "$0")/.."

needs="polars==1.31.0 pandas==2.2.3 numpy==2.2.6 pyarrow==20.0.0 duckdb==1.3.2"
folder=${EXPORT_DIR:-${CARGO_TARGET_DIR:-target}/export}
if [ ! -e "$folder/installed" ]; then
    python3 -m venv "$folder"
    # shellcheck disable=SC2086
    "$folder/bin/pip" install --quiet $needs
    touch "$folder/installed"
fi
[ "${1:-}" != --prepare ] || exit 0
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
"$program" run cartpole --methods ppo --set ppo.total_steps=2048 --budget 3 --eval-seeds 4 --quiet --out "$results/r"
"$program" export "$results/r"
"$folder/bin/python" scripts/export_check.py "$results/r"
