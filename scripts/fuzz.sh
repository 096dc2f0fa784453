#!/usr/bin/env bash
# Gives readers of files inputs that follow what the code does with them, with libFuzzer: fuzz/README.md.
#
#   scripts/fuzz.sh 600              all readers, ten minutes each
#   scripts/fuzz.sh 600 net record   these
#
# JOBS is how many at the same time. What is found is in fuzz/artifacts/, and the exit code 1.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=${1:?"usage: scripts/fuzz.sh SECONDS [READER ...]"}
shift
readers=("$@")
if [ ${#readers[@]} -eq 0 ]; then
    mapfile -t readers < <(ls fuzz/seeds)
fi

# The dictionary of a reader, as the table of fuzz/README.md has it.
dictionary() {
    local name
    name=$(sed -n "s/^|[^|]*\`$1\`[^|]*|.*| \`\([a-z]*\)\` |\$/\1/p" fuzz/README.md)
    [ -n "$name" ] || { echo "no reader $1; there are: $(ls fuzz/seeds | xargs)" >&2; return 2; }
    echo "$name"
}
for reader in "${readers[@]}"; do dictionary "$reader" >/dev/null; done

# The passes that `cargo fuzz` asks of a nightly compiler, but for the address sanitizer; with one unit of code per crate,
# for the linker drops counters of others. Overflows and broken debug assertions are finds.
passes="-Cpasses=sancov-module"
for pass in level=4 inline-8bit-counters pc-table trace-compares; do
    passes+=" -Cllvm-args=-sanitizer-coverage-$pass"
done
cp Cargo.lock fuzz/
RUSTFLAGS="$passes --cfg fuzzing -Cdebug-assertions -Ccodegen-units=1 -Coverflow-checks" \
    CARGO_INCREMENTAL=0 CARGO_PROFILE_RELEASE_OPT_LEVEL=2 \
    cargo build --release --manifest-path fuzz/Cargo.toml --bin reader --target-dir fuzz/target \
    --target "$(rustc --print host-tuple)"
program=$(ls fuzz/target/*/release/reader)

fuzz() {
    mkdir -p "fuzz/corpus/$1" "fuzz/artifacts/$1"
    log=fuzz/artifacts/$1.log
    if READER=$1 RAYON_NUM_THREADS=1 "$program" "fuzz/corpus/$1" "fuzz/seeds/$1" "-dict=fuzz/$(dictionary "$1").dict" \
        "-max_total_time=$seconds" -timeout=10 -rss_limit_mb=2048 -max_len=65536 \
        "-artifact_prefix=fuzz/artifacts/$1/" >"$log" 2>&1; then
        echo "$1: nothing found, $(grep '^Done' "$log")"
    else
        echo "$1: something found, or it did not start: $log"
        return 1
    fi
}
export -f fuzz dictionary
export program seconds
printf '%s\n' "${readers[@]}" | xargs -P "${JOBS:-1}" -I{} bash -c 'fuzz {}' || exit 1
