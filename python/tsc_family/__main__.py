"""The command ``tsc-family``, as ``python -m tsc_family`` too."""

from __future__ import annotations

import os
import signal
import sys

from . import _native, _sumo
from ._command import start


def main() -> None:
    """Runs the command and ends the process with its exit code."""
    # The command hears signals itself; without this, Python would raise KeyboardInterrupt on top.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    _sumo.find()
    code = _native.run_command(["tsc-family", *sys.argv[1:]], start())
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):
            pass
    # A controller's thread that never ends would keep the interpreter from ending.
    os._exit(code)


if __name__ == "__main__":
    main()
