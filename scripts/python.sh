#!/usr/bin/env bash
# Builds the Python package against the eclipse-sumo wheel, installs it with SUMO into a fresh virtual environment, and
# uses it there as its README says: the example of a controller, the smoke scenario, the tests. The records of smoke have to
# equal those of PROGRAM, which simulates with Debian's SUMO.
#
#   scripts/python.sh [PROGRAM]          PYTHON=python3.12 scripts/python.sh
#   scripts/python.sh --prepare   only installs what the build needs
#
# It is compiled in target/wheel, or in WHEEL_TARGET_DIR: where that is the folder of other builds, crates are compiled once
# for both, but what depends on SUMO again whenever builds for another SUMO take turns.
set -euo pipefail
cd "$(dirname "$0")/.."

python=${PYTHON:-python3}
# Absolute: what builds works in other folders.
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
sumo=$(sed -n 's/^requires = .*"\(eclipse-sumo==[0-9.]*\).*/\1/p' python/pyproject.toml)
maturin=$(sed -n 's/^requires = .*"\(maturin[^"]*\)".*/\1/p' python/pyproject.toml)

step() { printf '\n--- %s (%s s)\n' "$1" "$SECONDS"; }

step "what the build needs"
# Not the build's own environment of pip: its path is another each time, and everything would be compiled again.
build=${SUMO_WHEEL_DIR:-$target/$sumo-build}
if [ ! -e "$build/installed" ]; then
    "$python" -m venv "$build"
    "$build/bin/pip" install --quiet "$sumo" "$maturin"
    touch "$build/installed"
fi
SUMO_HOME=$("$build/bin/python" -c 'import importlib.metadata as m; print(m.distribution("eclipse-sumo").locate_file("sumo"))')
SUMO_HOME=$SUMO_HOME scripts/setup.sh
[ "${1:-}" != --prepare ] || exit 0
program=${1:-}

step "the wheel"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
SUMO_HOME="" CARGO_TARGET_DIR=$(realpath -m "${WHEEL_TARGET_DIR:-$target/wheel}") PATH="$build/bin:$PATH" "$build/bin/pip" wheel \
    --quiet --no-deps --no-build-isolation --wheel-dir "$work/wheel" ./python
wheel=$(echo "$work"/wheel/*.whl)
ls -l "$work/wheel"

step "a fresh virtual environment, and from there to a report"
start=$SECONDS
"$python" -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet "$wheel[sumo]"
echo "pip install: $((SECONDS - start)) s"
# Nothing of this shell's may help to find SUMO, nor this folder to find the package.
unset SUMO_HOME PYTHONPATH
mkdir "$work/user"
cp python/examples/longest_queue.py "$work/user"
(cd "$work/user" && "$work/venv/bin/python" longest_queue.py smoke)
test -s "$work/user/results/longest/report/index.html"
echo "from pip install to report: $((SECONDS - start)) s"

step "the smoke scenario"
"$work/venv/bin/tsc-family" run smoke --eval-seeds 2 --out "$work/package"
if [ -n "$program" ]; then
    "$program" run smoke --eval-seeds 2 --out "$work/program" --quiet
    cmp "$work/package/report/episodes.csv" "$work/program/report/episodes.csv"
    echo "the records equal those of $program"
fi

step "tests of the package, with gymnasium, PettingZoo and pandas"
"$work/venv/bin/pip" install --quiet "$wheel[test]"
# Many tests wait for programs that they start, so there are twice as many at a time as processors.
"$work/venv/bin/pytest" python/tests --numprocesses "$((2 * $(nproc)))" -o cache_dir="$work/pytest"
step "done"
