#!/usr/bin/env bash
# Makes every kind of page and opens it in Chromium (scripts/browser.py).
#
#   scripts/browser.sh BINARY [FOLDER]    FOLDER keeps pages and screenshots
#   scripts/browser.sh --prepare          only installs what it needs
set -euo pipefail
binary=$(realpath -m -- "$1")
folder=$(realpath -m "${2:-$(mktemp -d)}")
cd "$(dirname "$0")/.."
repository=$PWD

# Chromium is Debian's, which has security updates; Playwright drives it and brings no browser of its own.
venv=$(realpath -m "${BROWSER_DIR:-${CARGO_TARGET_DIR:-target}/playwright}")
if ! command -v chromium >/dev/null; then
    sudo=
    [ "$(id -u)" -eq 0 ] || sudo="sudo -n"
    export DEBIAN_FRONTEND=noninteractive
    { $sudo apt-get update && $sudo apt-get install -y --no-install-recommends chromium fonts-liberation; } >/dev/null
fi
if [ ! -e "$venv/installed" ]; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet playwright==1.65.2
    touch "$venv/installed"
fi
[ "$1" != --prepare ] || exit 0

mkdir -p "$folder"
cd "$folder"
short="--eval-seeds 2 --set demand.horizon_s=120 --quiet"
# shellcheck disable=SC2086 # options are words
"$binary" run smoke $short --episodes 6 --methods baseline,fixed-time,max-pressure,idqn --out run
"$binary" run cartpole --methods ppo --set ppo.total_steps=4096 --budget 4 --quiet --out carts
"$binary" report run --against fixed-time >/dev/null
cp "$repository/crates/signals/tests/utdf/two-signals.csv" .
"$binary" build-networks --utdf two-signals.csv --quiet --out street
# shellcheck disable=SC2086
"$binary" run street $short --preset field --budget all --methods existing,nema,fixed-time --out engineer
"$binary" build-networks --osm "$repository/osm-signals/tests/networks/four_arms/input.osm" --quiet --out city
"$venv/bin/python" "$repository/scripts/browser.py" screenshots run/report/index.html \
    run/report/against-fixed-time/index.html carts/report/index.html city/quality.html \
    engineer/report/index.html engineer/report/intersections/i0001.html engineer/report/plans/i0001.html
