"""Builds with maturin: for the SUMO that pip has installed for the build, or for the one in SUMO_HOME; says how far it is."""

import importlib.metadata
import os
import sys
import threading
import time
from pathlib import Path

import maturin
from maturin import *  # noqa: F403  What a build backend is made of is maturin's.

# Time between two lines, seconds.
_EVERY_S = 30

_home = Path(os.environ.get("SUMO_HOME", ""))
if (_home / "include/libsumo/libsumo.h").is_file():
    # Built for the SUMO of this machine, which is then the one that the package loads.
    os.environ["SUMO_INCLUDE_DIR"] = str(_home / "include")
    os.environ["SUMO_LIB_DIR"] = str(_home / "lib64")
else:
    try:
        os.environ["SUMO_HOME"] = str(importlib.metadata.distribution("eclipse-sumo").locate_file("sumo"))
    except importlib.metadata.PackageNotFoundError:
        # PyPI has none for this processor; libsumo-sys looks for Debian's.
        os.environ.pop("SUMO_HOME", None)
# As fast as a release at what takes time, and compiled in half of the time.
os.environ.setdefault("MATURIN_PEP517_ARGS", "--profile=quick")


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """Builds a wheel as maturin does, with a line of progress each half minute."""
    reading, writing = os.pipe()
    said = os.dup(2)
    os.dup2(writing, 2)
    os.close(writing)
    progress = _Progress(reading, said)
    try:
        return maturin.build_wheel(wheel_directory, config_settings, metadata_directory)
    finally:
        # The last that writes to the pipe is gone, so that the thread ends.
        os.dup2(said, 2)
        progress.join()


class _Progress(threading.Thread):
    """Passes on what cargo says, and counts the crates that it compiles."""

    def __init__(self, reading, said):
        super().__init__()
        self._reading, self._said = reading, said
        self._count, self._crate = 0, "nothing"
        self._over = threading.Event()
        self.start()
        threading.Thread(target=self._tell, daemon=True).start()

    def run(self):
        with open(self._reading, "rb") as lines:
            for line in lines:
                os.write(self._said, line)
                words = line.split()
                if words[:1] == [b"Compiling"]:
                    self._count, self._crate = self._count + 1, words[1].decode()
        self._over.set()

    def _tell(self):
        start = time.monotonic()
        with _listener() as listener:
            while not self._over.wait(_EVERY_S):
                minutes, seconds = divmod(round(time.monotonic() - start), 60)
                listener.write(f"\n{minutes}:{seconds:02} compiled {self._count} crates, now {self._crate}\n")
                listener.flush()


def _listener():
    """Opens what somebody reads; pip keeps what builds say to itself, unless it is called with -v."""
    for path in ("/dev/tty", f"/proc/{os.getppid()}/fd/2"):
        try:
            return open(path, "a")
        except OSError:
            continue
    return os.fdopen(os.dup(2), "a")
