#!/usr/bin/env bash
# Holds our interquartile mean, probability of improvement and performance profiles against rliable from PyPI: the
# stored numbers must be what it computes, and ours must be its numbers on others too.
#
#   scripts/rliable.sh            compares
#   scripts/rliable.sh --write    writes tests/rliable/reference.json
#   scripts/rliable.sh --prepare  only installs what it needs
set -euo pipefail
cd "$(dirname "$0")/.."

# rliable is for plots too; without them it needs these only. Versions that were released together: arch 7.2 breaks with
# pandas 3.
rliable=1.2.0
needs="numpy==2.2.6 scipy==1.15.3 pandas==2.2.3 statsmodels==0.14.4 arch==7.2.0 absl-py==2.1.0"
folder=${RLIABLE_DIR:-${CARGO_TARGET_DIR:-target}/rliable-$rliable}
if [ ! -e "$folder/installed" ]; then
    python3 -m venv "$folder"
    # shellcheck disable=SC2086
    "$folder/bin/pip" install --quiet $needs
    "$folder/bin/pip" install --quiet --no-deps "rliable==$rliable"
    touch "$folder/installed"
fi
[ "${1:-}" != --prepare ] || exit 0
python=$folder/bin/python
stored=tests/rliable/reference.json
if [ "${1:-}" = --write ]; then
    "$python" scripts/rliable_reference.py > "$stored"
    exit
fi
"$python" scripts/rliable_reference.py > "$folder/stored.json"
"$python" - "$stored" "$folder/stored.json" <<'PYTHON'
import json, math, sys

def same(a, b):
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[k], b[k]) for k in a)
    if isinstance(a, list):
        return len(a) == len(b) and all(map(same, a, b))
    return math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-12)

stored, computed = (json.load(open(path)) for path in sys.argv[1:])
if not same(stored, computed):
    sys.exit(f"{sys.argv[1]} is not what rliable computes; if it should be, run scripts/rliable.sh --write")
print(f"{len(stored)} stored cases are what rliable computes")
PYTHON
for seed in 2 3; do
    "$python" scripts/rliable_reference.py "$seed" > "$folder/$seed.json"
    RLIABLE_REFERENCE=$(realpath "$folder/$seed.json") cargo test --profile quick --quiet --test analysis rliable
done
