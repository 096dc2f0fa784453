#!/usr/bin/env bash
# Installs what building and running tsc-family needs, through apt-get when that is possible;
# otherwise prints the one line to run and stops.
#
#   scripts/setup.sh          what all of it needs
#   scripts/setup.sh --run    what running needs, without compilers
#   scripts/setup.sh mujoco   MuJoCo instead, which only half-cheetah and swimmer need, through pip
set -euo pipefail

if [ "${1:-}" = mujoco ]; then
    # One of the versions in crates/control-tasks/src/mujoco.rs.
    wanted=mujoco==4.0.0
    python3 -c 'import mujoco' 2>/dev/null && exit 0
    command -v python3 >/dev/null || {
        echo "python3 is missing: install it, then try again" >&2
        exit 1
    }
    # Where the system keeps its Python to itself, it goes into a folder of this user's own.
    python3 -m pip install --quiet "$wanted" 2>/dev/null && exit 0
    folder=${XDG_DATA_HOME:-$HOME/.local/share}/tsc-family/mujoco
    if ! { python3 -m venv "$folder" && "$folder/bin/pip" install --quiet "$wanted"; }; then
        echo "pip cannot install $wanted; get its wheel from PyPI, unpack it, and set MUJOCO_LIB_DIR to its folder mujoco" >&2
        exit 1
    fi
    echo "MuJoCo is in a folder of its own; set"
    echo "  export MUJOCO_LIB_DIR=$("$folder/bin/python" -c 'import mujoco; print(mujoco.__path__[0])')"
    exit 0
elif [ $# -gt 0 ] && [ "$1" != --run ]; then
    echo "usage: scripts/setup.sh [--run | mujoco]" >&2
    exit 1
fi
builds=true
[ "${1:-}" != --run ] || builds=false

if $builds && ! command -v cargo >/dev/null; then
    echo "cargo is missing: install Rust (1.89 or newer), https://rustup.rs" >&2
    exit 1
fi

missing=()
has_file() { compgen -G "$1" >/dev/null; }
# Prints Debian's packages of the libraries that a wheel's file takes from the system and does not find there:
# libsumo contains the window, so it wants those of X and GL, which a server may not have.
lacking() {
    ldd "$@" 2>/dev/null | awk '/=> not found/ { print $1 }' | sort -u | while read -r library; do
        case $library in
            libGL.so.*) echo libgl1 ;;
            libX11.so.*) echo libx11-6 ;;
            libXext.so.*) echo libxext6 ;;
            libXrender.so.*) echo libxrender1 ;;
            libatomic.so.*) echo libatomic1 ;;
            libexpat.so.*) echo libexpat1 ;;
            libxcb.so.*) echo libxcb1 ;;
            libz.so.*) echo zlib1g ;;
            *) echo "$library" ;;
        esac
    done
}

# SUMO: an installation named by the environment (the layout of the eclipse-sumo wheel, or folders
# of its own) serves as well as Debian's package.
if [ -n "${SUMO_LIB_DIR:-}" ] && [ -n "${SUMO_INCLUDE_DIR:-}" ]; then :
elif [ -n "${SUMO_HOME:-}" ] && [ -e "$SUMO_HOME/lib64/libsumocpp.so" ]; then
    mapfile -t -O "${#missing[@]}" missing < <(lacking "$SUMO_HOME/lib64/libsumocpp.so" "$SUMO_HOME/bin/netconvert")
else
    { [ -x /usr/bin/netconvert ] && has_file '/usr/lib/python3/dist-packages/libsumo/_libsumo*.so'; } ||
        missing+=(sumo)
    has_file '/usr/lib/*/libpython3.*.so.1.0' || missing+=(libpython3.11)
fi
! $builds || command -v c++ >/dev/null || missing+=(g++)

[ ${#missing[@]} -eq 0 ] && exit 0

if ! command -v apt-get >/dev/null; then
    echo "missing: ${missing[*]} (Debian's names); install them; SUMO also comes with \`pip install" \
        "eclipse-sumo==1.15.0\`, then set SUMO_HOME to its folder \`sumo\` (docs/install.md)" >&2
    exit 1
fi
install="apt-get install -y --no-install-recommends ${missing[*]}"
if [ "$(id -u)" -eq 0 ]; then
    sudo=
elif sudo -n true 2>/dev/null; then
    sudo=sudo
else
    echo "missing: ${missing[*]}; run this, then try again:" >&2
    echo "  sudo apt-get update && sudo $install" >&2
    exit 1
fi
echo "installing ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
log=$(mktemp)
if ! { $sudo apt-get update && $sudo $install; } >"$log" 2>&1; then
    tail -n 20 "$log" >&2
    echo "apt-get failed; its output is in $log" >&2
    exit 1
fi
rm -f "$log"
