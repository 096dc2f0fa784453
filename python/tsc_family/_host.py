"""Loads the files that controllers are written in; the native part of the command calls this."""

from __future__ import annotations

import faulthandler
import importlib
import inspect
import io
import json
import os
import platform
import signal
import sys
import sysconfig
import tempfile
import traceback
import types
from pathlib import Path
from typing import Any

from . import _controller, _native
from ._command import ARGUMENTS
from ._controller import Controller, learner_of
from ._native import Error
from ._register import register

_OWN = str(Path(__file__).parent)
_MODULE = "tsc_family_controller"

# The folders that controllers were loaded from, which their modules are found in.
_folders: set[Path] = set()

# Whether a file is being loaded, in which evaluate() and run() end the loading: the class is there by then.
loading = False


class Loaded(BaseException):
    """Ends the loading of a script that goes on to evaluate what it has defined."""


class _NoInput(io.TextIOBase):
    """Standard input of a controller, which has none: the worker's is a pipe of the run."""

    def readable(self) -> bool:
        return True

    def read(self, size: int | None = -1) -> str:
        raise Error("a controller has no standard input; read a file that `files` names")

    def readline(self, size: int | None = -1) -> str:  # type: ignore[override]
        return self.read()


class Opened:
    """A class of a file, and what a run records of it."""

    def __init__(self, cls: type[Controller], path: Path, arguments: dict[str, Any]) -> None:
        self._class, self._arguments = cls, arguments
        self.name = cls.__name__
        self.summary = (inspect.getdoc(cls) or "").split("\n")[0] if cls.__doc__ else ""
        self.learner = learner_of(cls)
        self.learns = self.learner is not None or callable(getattr(cls, "train", None))
        self.rewards = callable(getattr(cls, "reward", None))
        self.observes = callable(getattr(cls, "observation", None))
        self.files = {name: str(file) for name, file in _files(cls, path).items()}
        self.versions = _versions()

    def create(self, seed: int) -> Controller:
        """Makes an object."""
        _watch()
        _controller.set_seed(seed)
        made: Controller = self._class(*self._arguments["args"], **self._arguments["kwargs"])
        return made


def open_source(source: str) -> Opened:
    """Opens ``FILE.py:CLASS``, with the arguments of the class behind it, as :func:`_arguments` reads them."""
    path_class, _, text = source.partition("?")
    file, _, name = path_class.rpartition(":")
    path = Path(file).absolute()
    if not path.is_file():
        raise Error(f"there is no file {file}; give FILE.py:CLASS")
    arguments = _arguments(text)
    folder = os.getcwd()
    cls: Any
    cls, evaluates = _load(path)
    if os.getcwd() != folder:
        to = os.getcwd()
        os.chdir(folder)
        raise Error(
            f"{path.name} changes the working folder to {to} when it is imported, where the run would not find its files; "
            "use paths that begin at os.path.dirname(os.path.abspath(__file__))"
        )
    for part in name.split("."):
        cls = getattr(cls, part, None)
        if cls is None and evaluates:
            raise Error(
                f"{path.name} has no class {name} at its top level above {evaluates}, which evaluates; if the class comes "
                f"later, put the evaluation below `if __name__ == \"__main__\":`"
            )
        if cls is None:
            raise Error(
                f"{path.name} has no class {name} at its top level; if it is below `if __name__ == \"__main__\"`, move it up"
            )
    if not (isinstance(cls, type) and issubclass(cls, Controller)):
        raise Error(f"{path.name}: {name} is no tsc_family.Controller")
    return Opened(cls, path, arguments)


def _arguments(text: str) -> dict[str, Any]:
    """Reads arguments of a class: ``alpha=1.0&name=slow``, or JSON with ``args`` and ``kwargs``, as :func:`evaluate` writes it.

    A value is JSON where it can be, such as ``1.0``, ``true`` or ``[1,2]``, else a text.
    """
    if text.startswith("{"):
        try:
            return {"args": [], "kwargs": {}, **json.loads(text)}
        except ValueError as e:
            raise Error(f"what stands behind the ? is no JSON ({e})") from None
    named: dict[str, Any] = {}
    for part in filter(None, text.split("&")):
        name, is_given, value = part.partition("=")
        if not is_given or not name.isidentifier():
            raise Error(f"{part!r} behind the ? is no argument; write ?alpha=1.0&steps=3")
        if name in named:
            raise Error(f"the argument {name} stands behind the ? twice")
        try:
            named[name] = json.loads(value)
        except ValueError:
            named[name] = value
    return {"args": [], "kwargs": named}


def _load(path: Path) -> tuple[Any, str]:
    """Runs a file as a module of another name than ``__main__``; one of a package under its own name.

    Returns the module, and the line that went on to evaluate, where the loading ended there.
    """
    global loading
    folder, name = _package(path)
    _make_room(folder)
    # As when the script itself is run, or the package is imported.
    sys.path.insert(0, str(folder))
    sys.argv = [str(path), *json.loads(os.environ.get(ARGUMENTS, "[]"))]
    # Standard output has what the command says.
    sys.stdout = sys.stderr
    sys.stdin = _NoInput()
    # What was hashed is what runs: no bytecode of an earlier file of that name, size and time.
    sys.dont_write_bytecode = True
    source = path.read_bytes()
    if b"gymnasium" in source:
        try:
            register()
        except ImportError:
            pass
    module = types.ModuleType(name or f"{_MODULE}_{path.stem}")
    module.__file__ = str(path)
    loading = True
    try:
        if name:
            module.__package__ = name.rpartition(".")[0]
            try:
                importlib.import_module(module.__package__)
            except Loaded as e:
                # An import that is ended forgets its modules, and the class with them.
                raise Error(
                    f"{_line_of(e)}, evaluates when the package {module.__package__} is imported; put the evaluation below "
                    f"`if __name__ == \"__main__\":`"
                ) from None
            # The package may import it, or another class of it was opened before.
            if name in sys.modules:
                return sys.modules[name], ""
        # Not imported: an import forgets the module when a script that goes on to evaluate ends it.
        sys.modules[module.__name__] = module
        exec(compile(source, str(path), "exec"), module.__dict__)
    except Loaded as e:
        # The class is there by then, or whoever looks for it says that it is not.
        return module, _line_of(e)
    except SystemExit:
        pass
    except BaseException:
        sys.modules.pop(module.__name__, None)
        raise
    finally:
        loading = False
    return module, ""


def _line_of(ended: Loaded) -> str:
    """Returns the file and line that ended the loading."""
    own = [frame for frame in traceback.extract_tb(ended.__traceback__) if not _is_ours(frame.filename)]
    return f"{own[-1].filename}, line {own[-1].lineno}" if own else "a script"


def _make_room(folder: Path) -> None:
    """Takes the modules of controllers from other folders out of the way: two may have modules of the same name."""
    for other in _folders - {folder}:
        for name, module in list(sys.modules.items()):
            if _file_of(module, other) is not None:
                del sys.modules[name]
        sys.path[:] = [place for place in sys.path if place != str(other)]
    _folders.clear()
    _folders.add(folder)


def _package(path: Path) -> tuple[Path, str]:
    """Returns the folder to import from, and the name of a module of a package; empty for a file of its own."""
    names, folder = [path.stem], path.parent
    while (folder / "__init__.py").is_file():
        names.insert(0, folder.name)
        folder = folder.parent
    return folder, ".".join(names) if len(names) > 1 else ""


def _files(cls: type[Controller], path: Path) -> dict[str, Path]:
    """Returns what a class consists of, by name: its file, modules from its folder or below, files that it names."""
    folder = _package(path)[0]
    found = {str(path.relative_to(folder)): path}
    for module in list(sys.modules.values()):
        file = _file_of(module, folder)
        if file is not None and file.is_file():
            found[str(file.relative_to(folder))] = file
    for name in cls.files:
        file = path.parent / name
        if not file.is_file():
            raise Error(f"{cls.__name__} names a file that is not there: {file}")
        found[str(name)] = file
    return found


def _file_of(module: Any, folder: Path) -> Path | None:
    """Returns the file of a module that lies in a folder or below and is not installed."""
    origin = getattr(module, "__file__", None)
    # Some modules that are made while a program runs say a name that is no file.
    file = Path(origin) if isinstance(origin, str) and os.path.isabs(origin) else None
    return None if file is None or folder not in file.parents or _is_installed(file) else file


def _is_installed(file: Path) -> bool:
    """Whether a file is Python's, or of a package that is installed: versions say which."""
    if str(file).startswith(_OWN + os.sep) or {"site-packages", "dist-packages"} & set(file.parts):
        return True
    paths = sysconfig.get_paths()
    return any(str(file).startswith(paths[name] + os.sep) for name in ("stdlib", "platstdlib"))


def _versions() -> dict[str, str]:
    """Returns the versions of Python and of packages that are loaded and say theirs."""
    versions = {"python": platform.python_version()}
    for name, module in list(sys.modules.items()):
        origin = getattr(module, "__file__", None) or ""
        version = getattr(module, "__version__", None)
        if "." not in name and isinstance(version, str) and "site-packages" in origin:
            versions[name] = version
    return versions


def _watch() -> None:
    """Lets the interpreter say where it is when it is asked by a signal."""
    if not _watch.done:  # type: ignore[attr-defined]
        stacks = tempfile.TemporaryFile()
        faulthandler.register(signal.SIGUSR2, file=stacks, all_threads=True)
        _watch.stacks = stacks  # type: ignore[attr-defined]
        _native.stack_in(stacks.fileno())
        _watch.done = True  # type: ignore[attr-defined]


_watch.done = False  # type: ignore[attr-defined]


def explained(error: BaseException, trace: types.TracebackType | None) -> str:
    """Returns what an exception says: of one of ours its words, of others the traceback without our own lines."""
    own = [frame for frame in traceback.extract_tb(trace) if not _is_ours(frame.filename)]
    if isinstance(error, Error) and not own:
        return str(error)
    head = ["Traceback (most recent call last):\n", *traceback.format_list(own)]
    last = traceback.format_exception_only(type(error), error)
    cause = error.__cause__ or (None if error.__suppress_context__ else error.__context__)
    before = [] if cause is None else [explained(cause, cause.__traceback__), "\n\nwhich led to\n\n"]
    return "".join([*before, *(head if own else []), *last]).rstrip()


def _is_ours(file: str) -> bool:
    return file.startswith(_OWN + os.sep) or "importlib" in file and "frozen" in file
