#!/usr/bin/env bash
# What a maintainer tries before a release: the long form of what `.ci/run` tries in short. Takes about two hours.
set -euo pipefail
cd "$(dirname "$0")/.."
target=${CARGO_TARGET_DIR:-target}
program=$target/quick/tsc-family

step() { printf '\n=== %s (%s s)\n' "$1" "$SECONDS"; }

step "tests: all mutations of the readers, all published runs, the commands on their pages"
NIGHTLY=1 make test
step "formatting, clippy, docs; clippy of the program without SUMO"
make check
step "licences, sources and advisories of crates"
scripts/deny.sh
step "interquartile mean, probability of improvement and profiles against rliable"
scripts/rliable.sh
step "smoke scenario from another folder"
scripts/smoke.sh "$program"
step "pages in a browser"
scripts/browser.sh "$program"
step "RESCO's scenarios with several signals"
scripts/resco.sh "$program"
step "batch systems"
scripts/cluster.sh "$program"
for version in 3.9 3.10 3.11 3.12 3.13; do
    if command -v "python$version" >/dev/null; then
        step "the Python package on Python $version"
        PYTHON=python$version WHEEL_TARGET_DIR=$target scripts/python.sh
    else
        step "SKIPPED: there is no python$version"
    fi
done
step "done"
