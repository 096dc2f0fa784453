#!/usr/bin/env bash
# Builds what a release offers, and tries it: the wheel of the Python package, with the manylinux tag that its symbols allow,
# an archive of the command alone, and one of the published records with their episodes of training. Both run with SUMO of the
# package eclipse-sumo, in the version that python/pyproject.toml names. .github/workflows/release.yml calls this.
#
#   scripts/release.sh [FOLDER]    into FOLDER, `dist` by default
#
# PYTHONS are the Pythons that the wheel is tried with; by default the oldest and the newest that are found.
set -euo pipefail
cd "$(dirname "$0")/.."

out=$(realpath -m "${1:-dist}")
target=$(realpath -m "${CARGO_TARGET_DIR:-target}")
sumo=$(sed -n 's/^requires = .*"\(eclipse-sumo==[0-9.]*\).*/\1/p' python/pyproject.toml)
build=${SUMO_WHEEL_DIR:-$target/$sumo-build}

step() { printf '\n--- %s (%s s)\n' "$1" "$SECONDS"; }

found=()
for minor in 9 10 11 12 13 14; do
    # A stand-in of a version manager answers to the name and has no Python behind it.
    ! "python3.$minor" -c '' 2>/dev/null || found+=("python3.$minor")
done
[ ${#found[@]} -gt 0 ] || { echo "no python3.9 or newer in PATH" >&2; exit 1; }
pythons=${PYTHONS:-$(printf '%s\n' "${found[0]}" "${found[-1]}" | sort -uV | xargs)}

step "what the build needs"
PYTHON=${PYTHON:-${found[-1]}} scripts/python.sh --prepare
SUMO_HOME=$("$build/bin/python" -c 'import importlib.metadata as m; print(m.distribution("eclipse-sumo").locate_file("sumo"))')
export SUMO_HOME
rm -rf "$out"
mkdir -p "$out"

step "the wheel: about 4 minutes of a processor"
CARGO_TARGET_DIR=$target/wheel "$build/bin/maturin" build --release --strip --manifest-path python/Cargo.toml --out "$out"
wheel=$(echo "$out"/*.whl)

step "the command"
CARGO_TARGET_DIR=$target/wheel cargo build --release
version=$("$target/wheel/release/tsc-family" --version | cut -d' ' -f2)
name=tsc-family-$version-linux-$(uname -m)
mkdir "$out/$name"
install "$target/wheel/release/tsc-family" LICENSE-APACHE LICENSE-MIT data/SOURCES.md "$out/$name"
chmod -x "$out/$name"/*.md "$out/$name"/LICENSE-*
cat >"$out/$name/README.md" <<END
# tsc-family $version

This command needs SUMO from PyPI, in this version:

    python3 -m venv sumo
    sumo/bin/pip install $sumo
    export SUMO_HOME=\$(sumo/bin/python -c 'import sumo; print(sumo.SUMO_HOME)')
    ./tsc-family doctor
    ./tsc-family run smoke

The Python package contains the same command and installs SUMO itself.
END
tar -C "$out" --sort=name --owner=0 --group=0 --numeric-owner -czf "$out/$name.tar.gz" "$name"

# Runs from before results/*/*/run.jsonl.xz left them out have their episodes of training in this revision.
if git cat-file -e 34e518dc 2>/dev/null; then
    step "records with their episodes of training"
    mapfile -t files < <(git ls-tree -r --name-only 34e518dc results | grep -E '/(records.tar.xz|[a-z]*.json|plan.jsonl.gz)$' | grep -v /report/)
    git archive --format=tar -o "$out/records-with-training.tar" 34e518dc "${files[@]}"
fi

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
step "the archive, unpacked elsewhere"
tar -C "$work" -xzf "$out/$name.tar.gz"
rm -r "${out:?}/$name"
(cd "$work" && scripts=$OLDPWD/scripts && "$scripts/smoke.sh" "$work/$name/tsc-family")
unset SUMO_HOME
for python in $pythons; do
    step "the wheel with $("$python" --version)"
    start=$SECONDS
    "$python" -m venv "$work/$python"
    "$work/$python/bin/pip" install --quiet "$wheel[sumo]"
    echo "pip install: $((SECONDS - start)) s"
    scripts/smoke.sh "$work/$python/bin/tsc-family"
done
step "done"
(cd "$out" && sha256sum ./*.whl ./*.tar* | tee SHA256SUMS && ls -l)
