"""Where SUMO is: the ``eclipse-sumo`` package that is installed beside this one.

The native part was built for one version of SUMO, which the extra ``sumo`` names; another one is refused, because
SUMO's library promises nothing between versions.
"""

from __future__ import annotations

import os
import re
from importlib import metadata
from pathlib import Path

from . import _native

_PACKAGE = "eclipse-sumo"
_WAY_OUT = "pip install 'tsc-family[sumo]'"


def required() -> str:
    """Returns the version of SUMO that this package was built for."""
    for requirement in metadata.requires("tsc-family") or []:
        found = re.match(rf"{_PACKAGE}\s*\(?==\s*([\d.]+)", requirement)
        if found:
            return found.group(1)
    raise RuntimeError("the package's metadata name no version of SUMO; install it again")


def home() -> tuple[Path | None, str]:
    """Returns SUMO's folder, or None and why there is none and what to do."""
    wanted = required()
    try:
        package = metadata.distribution(_PACKAGE)
    except metadata.PackageNotFoundError:
        return None, f"the package {_PACKAGE} {wanted} is not installed here; {_WAY_OUT}"
    if package.version != wanted:
        return None, f"{_PACKAGE} {package.version} is installed, but {wanted} is needed; {_WAY_OUT}"
    folder = Path(str(package.locate_file("sumo")))
    if not (folder / "lib64" / "libsumocpp.so").is_file():
        return None, f"{folder} lacks lib64/libsumocpp.so; pip install --force-reinstall {_PACKAGE}=={wanted}"
    return folder, ""


def find() -> None:
    """Tells the native part where SUMO is; raises nothing, so that what simulates nothing works without it."""
    kind, library = _native.sumo_built_with()
    if kind != "eclipse-sumo":
        # Built on this machine for a SUMO that stays where it is.
        home_of_it = Path(library).parents[1]
        if (home_of_it / "bin" / "netconvert").is_file():
            os.environ["SUMO_HOME"] = str(home_of_it)
        return
    folder, missing = home()
    if folder is None:
        _native.sumo_found(None, missing)
        return
    _native.sumo_found(folder / "lib64" / "libsumocpp.so", None)
    # netconvert, and what SUMO's programs read, are those of the same version.
    os.environ["SUMO_HOME"] = str(folder)
