#!/usr/bin/env bash
# Builds against the eclipse-sumo wheel from PyPI as the README says it and runs the smoke scenario with it, so
# that both ways of getting SUMO keep working.
set -euo pipefail
cd "$(dirname "$0")/.."

version=${WHEEL_VERSION:-1.28.0}
folder=${SUMO_WHEEL_DIR:-${CARGO_TARGET_DIR:-target}/eclipse-sumo-$version}
if [ ! -x "$folder/bin/netconvert" ]; then
    python3 -m venv "$folder"
    "$folder/bin/pip" install --quiet "eclipse-sumo==$version"
fi
SUMO_HOME=$("$folder/bin/python" -c 'import sumo; print(sumo.SUMO_HOME)')
export SUMO_HOME
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-target}/wheel
scripts/setup.sh
cargo build --release
scripts/smoke.sh "$CARGO_TARGET_DIR/release/tsc-family"
