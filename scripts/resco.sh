#!/usr/bin/env bash
# Holds what is derived and simulated of RESCO's scenarios, most of them with several signals, against RESCO's own
# configuration and plain sumo. The scenarios are in the wheel of sumo-rl on PyPI; their licences (CC BY-NC-SA, GPL) are
# why none is in this repository.
#
#   scripts/resco.sh [PROGRAM [SCENARIO...]]
#   scripts/resco.sh --prepare   only fetches the scenarios
set -euo pipefail
program=$(realpath -m -- "${1:-${CARGO_TARGET_DIR:-$(dirname "$0")/../target}/release/tsc-family}")
cd "$(dirname "$0")/.."

sumo_rl=1.4.5
folder=${RESCO_DIR:-${CARGO_TARGET_DIR:-target}/resco-$sumo_rl}
if [ ! -e "$folder/fetched" ]; then
    rm -rf "$folder"
    python3 -m venv "$folder"
    "$folder/bin/pip" download --quiet --no-deps --only-binary :all: --dest "$folder" "sumo-rl==$sumo_rl"
    python3 -m zipfile -e "$folder"/sumo_rl-*.whl "$folder"
    touch "$folder/fetched"
fi
[ "${1:-}" != --prepare ] || exit 0
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
python3 scripts/resco_check.py "$program" "$folder/sumo_rl/nets/RESCO" "$results" "${@:2}"
