#!/usr/bin/env bash
# What must pass before a push, cheapest first.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo fmt --all --check
# With the features that the documentation is made with, which shares what is compiled here.
cargo clippy --workspace --all-targets --profile quick -- -D warnings
make doc
