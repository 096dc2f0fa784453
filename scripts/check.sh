#!/usr/bin/env bash
# Formatting and lints: what CI checks beside the tests. `make check` builds the documentation too.
set -euo pipefail
cd "$(dirname "$0")/.."

cargo fmt --all --check
# With the features that the documentation is made with, which shares what is compiled here.
cargo clippy --workspace --all-targets --profile quick -- -D warnings
