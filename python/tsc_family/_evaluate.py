"""Evaluates controllers over a family, beside those of tsc-family."""

from __future__ import annotations

import csv
import re
import sys
import warnings
from collections.abc import Iterable, Mapping, Sequence
from os import fspath
from pathlib import Path
from typing import Any, Union

import numpy as np

from . import _host
from ._command import INCOMPLETE, SOME_FAILED, call, error_of
from ._controller import Controller, arguments_of, name_of
from ._family import Settings, flags
from ._native import Error
from ._place import Path as PathLike

One = Union[Controller, "type[Controller]", str]
Controllers = Union[One, Iterable[One], Mapping[str, Union[Controller, "type[Controller]"]]]
"""Controllers of your own, as objects or classes; texts are what ``--controller`` takes, such as ``mine=exec:./cmd``.
A mapping names them, so that one class can be there several times: ``{"full": L(alpha=1.0), "no-memory": L(alpha=0.0)}``."""

_WITH_RESULTS = (0, SOME_FAILED, INCOMPLETE)


class Result:
    """A results directory: tables as data, and the page."""

    def __init__(self, folder: PathLike, table: str = "") -> None:
        self.folder = Path(fspath(folder))
        """The results directory."""
        self._table = table

    def __repr__(self) -> str:
        return f"Result({str(self.folder)!r})"

    def table(self) -> str:
        """Returns the ranking as text: score with interval, delays, who is worst where."""
        if not self._table:
            self._table = _output(["report", fspath(self.folder)])
        return self._table

    def scores(self) -> Any:
        """Returns a row per method, point MDP and training: a pandas DataFrame if pandas is there, else a dict of arrays."""
        return self._read("scores.csv")

    def summary(self) -> Any:
        """Returns a row per method: score, interval and other means; as :meth:`scores` does."""
        return self._read("summary.csv")

    def report(self) -> Path:
        """Returns the path of the page with all figures, for a browser."""
        return self._written("index.html")

    def _written(self, name: str) -> Path:
        path = self.folder / "report" / name
        if not path.is_file():
            _output(["report", fspath(self.folder)])
        return path

    def _read(self, name: str) -> Any:
        path = self._written(name)
        try:
            import pandas  # type: ignore[import-untyped,unused-ignore]
        except ImportError:
            return _columns(path)
        return pandas.read_csv(path)


def _columns(path: Path) -> dict[str, np.ndarray[Any, Any]]:
    """Returns the columns of a table: numbers where all of them are, else texts."""
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = list(csv.reader(file))
    columns = {}
    for name, values in zip(header, zip(*rows) if rows else [()] * len(header)):
        try:
            columns[name] = np.array([float(value) if value else np.nan for value in values])
        except ValueError:
            columns[name] = np.array(values)
    return columns


def evaluate(
    controllers: Controllers,
    scenario: str = "salt-lake-city",
    *,
    budget: int | str | None = None,
    sampling: str | None = None,
    like: PathLike | None = None,
    assist: PathLike | None = None,
    until_decided: bool = False,
    looks: Sequence[int] = (),
    eval_seeds: int | None = None,
    seeds: PathLike | None = None,
    against: Sequence[str] = (),
    models: Mapping[str, PathLike] | None = None,
    out: PathLike | None = None,
    sumocfg: PathLike | Sequence[PathLike] = (),
    preset: str | None = None,
    settings: Settings | None = None,
    episodes: int | None = None,
    replicates: int | None = None,
    replace: Sequence[str] = (),
    seed: int = 0,
    jobs: int | None = None,
    stall_timeout: int | None = None,
    answer_timeout: int | None = None,
    memory_per_worker: int | None = None,
    networks: PathLike | None = None,
    retry_failed: bool = False,
    quiet: bool = False,
) -> Result:
    """Evaluates controllers on a sample of a family, ranked beside the methods ``against`` and the baseline.

    ``models`` has files of trained models by a name for each: methods that do not learn any more. The class of a model of
    your own has to be among ``controllers``.
    ``budget`` is the number of point MDPs. Where it is None, these are those of the run that is in ``out``, else all.
    With ``until_decided`` the run stops when a method is within 0.03 of the best. The
    other options are those of ``tsc-family run``. The same call continues an interrupted run. A call with more
    controllers, methods or point MDPs adds to the run in ``out``, whose records stay. A controller whose file has
    changed needs another ``out``, or its name in ``replace``, which computes its records again. A controller that fails on a point MDP has a failed record
    there with its own traceback; the run goes on, and a warning says so.

    In the script that a controller is written in, this ends the loading of that script where a worker loads it: whatever
    stands below is not run there, so that ``if __name__ == "__main__"`` is not needed.
    """
    if _host.loading:
        raise _host.Loaded
    sources = [] if models and not controllers else _sources(controllers)
    names = [source.partition("=")[0] for source in sources]
    models = {} if models is None else models
    if not isinstance(models, Mapping):
        raise Error(f"models={models!r}: give names and files, such as {{'trained': 'results/a/models/000/3.safetensors'}}")
    folder = Path("results") / names[0] if out is None else Path(fspath(out))
    arguments = ["run", fspath(scenario), "--out", fspath(folder), "--methods", ",".join([*names, *_names(against), *models])]
    for source in sources:
        arguments += ["--controller", source]
    for name, model in models.items():
        arguments += ["--model", f"{name}={fspath(model)}"]
    configs = [sumocfg] if isinstance(sumocfg, str) or hasattr(sumocfg, "__fspath__") else list(sumocfg)
    for config in configs:
        arguments += ["--sumocfg", fspath(config)]
    for setting in flags(settings):
        arguments += ["--set", setting]
    options = {
        "budget": budget,
        "sampling": sampling,
        "like": None if like is None else fspath(like),
        "assist": None if assist is None else fspath(assist),
        "looks": ",".join(map(str, looks)) or None,
        "eval-seeds": eval_seeds,
        "seeds": None if seeds is None else fspath(seeds),
        "preset": preset,
        "episodes": episodes,
        "replicates": replicates,
        "seed": seed,
        "jobs": jobs,
        "stall-timeout": stall_timeout,
        "answer-timeout": answer_timeout,
        "memory-per-worker": memory_per_worker,
        "networks": None if networks is None else fspath(networks),
    }
    for name, value in options.items():
        if value is not None:
            arguments.append(f"--{name}={value}")
    if until_decided:
        arguments.append("--until-decided")
    if replace:
        arguments += ["--replace", ",".join(_names(replace))]
    if retry_failed:
        arguments.append("--retry-failed")
    code, table, words = call(arguments, show_output=False, show_progress=not quiet)
    if code not in _WITH_RESULTS:
        raise Error(in_python(str(error_of(words, code))))
    if code == SOME_FAILED:
        warnings.warn(f"some tasks failed; {folder}/report says which and why", stacklevel=2)
    if code == INCOMPLETE:
        warnings.warn("some tasks have no record, for reasons of the machine; the same call continues", stacklevel=2)
    return Result(folder, table)


def _sources(controllers: Controllers) -> list[str]:
    """Returns what ``--controller`` takes of each."""
    if isinstance(controllers, Mapping):
        sources = [source_of(controller, name) for name, controller in controllers.items()]
    elif isinstance(controllers, (Controller, type, str)):
        sources = _sources([controllers])
    elif callable(controllers) or not isinstance(controllers, Iterable):
        raise Error(
            f"{controllers!r} is no controller; give a class with act(self, obs) that is derived from tsc_family.Controller, "
            "an object of it, or several of them"
        )
    else:
        sources = [source if isinstance(source, str) else source_of(source) for source in controllers]
    if not sources:
        raise Error("give at least one controller")
    return sources


def _names(names: Sequence[str]) -> list[str]:
    """Returns names; one alone needs no list."""
    return [names] if isinstance(names, str) else list(names)


# What options of the command are called in Python where that is not their own name.
_CALLED = {"methods": "against", "set": "settings", "controller": "controllers"}


def in_python(words: str) -> str:
    """Returns what the command said with its options as they are called in Python."""

    def called(option: str) -> str:
        return _CALLED.get(option, option.replace("-", "_"))

    words = re.sub(r"\n\n.*--help.*", "", words, flags=re.DOTALL)
    wrong = re.fullmatch(r"invalid value '(.*)' for '--([a-z-]+)\b[^']*'(?:: |\n *)(.*)", words, flags=re.DOTALL)
    if wrong:
        return f"{called(wrong[2])}={wrong[1]}: {wrong[3]}"
    return re.sub(r"(?<![\w-])--([a-z]+(?:-[a-z]+)*)", lambda option: called(option[1]), words)


def run(arguments: Sequence[str]) -> int:
    """Runs the command ``tsc-family`` with any arguments, such as ``["list", "smoke"]``, and returns its exit code.

    Raises :class:`Error` with its words where it can do nothing (exit codes other than 0, 3 and 6).
    """
    if _host.loading:
        raise _host.Loaded
    code, _, words = call([str(a) for a in arguments], show_output=True, show_progress=True)
    if code not in _WITH_RESULTS:
        raise error_of(words, code)
    return code


def _output(arguments: Sequence[str]) -> str:
    """Returns what a command puts out."""
    code, text, words = call(arguments, show_output=False, show_progress=False)
    if code not in _WITH_RESULTS:
        raise error_of(words, code)
    return text


def source_of(controller: Controller | type[Controller], name: str = "") -> str:
    """Returns what ``--controller`` takes: name, file, class and arguments; the name is the class's where none is given."""
    cls = controller if isinstance(controller, type) else type(controller)
    if not issubclass(cls, Controller):
        raise Error(f"{cls.__name__} is no tsc_family.Controller")
    # Not inspect's file: in a notebook, that is one that no other process can read.
    file = getattr(sys.modules.get(cls.__module__), "__file__", None)
    if file is None or not Path(file).is_file():
        raise Error(
            f"{cls.__name__} is written in no file, and every task makes it anew in a process of its own: write it to a "
            f"file (in a notebook: %%writefile mine.py), import it from there, and evaluate it"
        )
    if "<locals>" in cls.__qualname__:
        raise Error(f"{cls.__name__} is defined within a function; move it to the top level of {Path(file).name}")
    arguments = "" if isinstance(controller, type) else arguments_of(controller)
    source = f"{name or name_of(cls)}={Path(file).absolute()}:{cls.__qualname__}"
    return f"{source}?{arguments}" if arguments else source
