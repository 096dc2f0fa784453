#!/usr/bin/env bash
# Makes every kind of page and opens it in Chromium at two widths, in print and without scripts: nothing may complain,
# stick out or be cut, links must lead somewhere, and tables must sort and filter (scripts/browser/checks.py). Then it
# plants each of these faults in a page, and fails where one is not found.
#
#   scripts/browser.sh BINARY             looks at pages in a temporary folder
#   scripts/browser.sh BINARY FOLDER      the same, and keeps them in an empty FOLDER
#   scripts/browser.sh --prepare          only installs what it needs
#
# LARGE_PAGE may name the page that the test report_large has made with TSC_FAMILY_KEEP_PAGE.
set -euo pipefail
binary=$(realpath -m -- "$1")
kept=${2:+$(realpath -m "$2")}
cd "$(dirname "$0")/.."
repository=$PWD

# Chromium is Debian's, which has security updates; Playwright drives it and brings no browser of its own.
playwright=1.65.2
venv=${BROWSER_DIR:-${CARGO_TARGET_DIR:-target}/playwright-$playwright}
if ! command -v chromium >/dev/null; then
    sudo=
    [ "$(id -u)" -eq 0 ] || sudo="sudo -n"
    export DEBIAN_FRONTEND=noninteractive
    log=$(mktemp)
    { $sudo apt-get update && $sudo apt-get install -y --no-install-recommends chromium fonts-liberation; } >"$log" 2>&1 || {
        tail -n 20 "$log" >&2
        echo "chromium is missing and apt-get failed; its output is in $log" >&2
        exit 1
    }
    rm -f "$log"
fi
if [ ! -e "$venv/installed" ]; then
    python3 -m venv "$venv"
    "$venv/bin/pip" install --quiet "playwright==$playwright"
    touch "$venv/installed"
fi
[ "$1" != --prepare ] || exit 0
python=$(realpath -s "$venv/bin/python")

if [ -n "$kept" ]; then
    folder=$kept
    mkdir -p "$folder"
    [ -z "$(ls -A "$folder")" ] || { echo "$folder is not empty" >&2; exit 1; }
else
    folder=$(mktemp -d)
    trap 'rm -rf "$folder"' EXIT
fi

# A family of 1,000 point MDPs, made up by its test.
mkdir "$folder/large"
if [ -n "${LARGE_PAGE:-}" ]; then
    cp "$LARGE_PAGE" "$folder/large/index.html"
else
    TSC_FAMILY_KEEP_PAGE="$folder/large/index.html" cargo test --workspace --profile quick --quiet --test analysis report_large >/dev/null
fi

cd "$folder"
quiet() { "$@" >"$folder/out" 2>&1 || { cat "$folder/out" >&2; exit 1; }; }
published() {
    cp -r "$repository/results/$1" "$2"
    quiet "$binary" report "$2"
}
published salt-lake-city/field-0.2.0 field
published cartpole/carl carl
quiet "$binary" report field --against fixed-time
quiet "$binary" run salt-lake-city --budget 4 --eval-seeds 2 --set demand.horizon_s=120 --out sample \
    --methods baseline,fixed-time,max-pressure
quiet "$binary" run smoke --eval-seeds 2 --episodes 6 --set demand.horizon_s=60 --out learner --methods max-pressure,idqn
quiet "$binary" estimate field --repeats 2
quiet "$binary" sensitivity field --cases --repeats 2
gzip <"$repository/osm-signals/tests/networks/four_arms/input.osm" >map.osm.gz
quiet "$binary" build-networks --osm map.osm.gz --out city

"$python" "$repository/scripts/browser" --large large/index.html \
    field/report/index.html field/report/against-fixed-time/index.html carl/report/index.html \
    sample/report/index.html learner/report/index.html field/estimate/index.html field/sensitivity/index.html \
    city/quality.html
