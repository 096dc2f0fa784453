#!/usr/bin/env bash
# What must pass before a push, cheapest first.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo fmt --all --check
cargo clippy --workspace --all-targets --release -- -D warnings
cargo clippy --all-targets --release --no-default-features -- -D warnings
make doc
