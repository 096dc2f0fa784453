#!/usr/bin/env bash
# Builds against the eclipse-sumo wheel from PyPI and runs the smoke scenario with it, so that both
# ways of getting SUMO keep working.
set -euo pipefail
cd "$(dirname "$0")/.."

version=${WHEEL_VERSION:-1.28.0}
folder=${SUMO_WHEEL_DIR:-${CARGO_TARGET_DIR:-target}/eclipse-sumo-$version}
if [ ! -e "$folder/sumo/lib64/libsumocpp.so" ]; then
    download=$(mktemp -d)
    python3 -m pip download --quiet --no-deps --dest "$download" "eclipse-sumo==$version"
    python3 -m zipfile -e "$download"/*.whl "$folder"
    rm -rf "$download"
    # zipfile does not keep permissions.
    chmod +x "$folder"/sumo/bin/*
fi
export SUMO_HOME
SUMO_HOME=$(realpath "$folder/sumo")
export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-target}/wheel
cargo build --release
scripts/smoke.sh "$CARGO_TARGET_DIR/release/tsc-family"
