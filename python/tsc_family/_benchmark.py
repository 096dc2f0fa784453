"""One answer for any policy: its score over the family, its place among what is published, and what is not decided."""

from __future__ import annotations

import hashlib
import inspect
import json
import math
import pickle
import sys
from collections.abc import Callable, Mapping
from os import fspath
from pathlib import Path
from typing import Any

from . import _host, _native
from ._controller import Controller, name_of
from ._evaluate import Result, _columns, evaluate
from ._native import Error
from ._place import Path as PathLike

# What is enough to see that a policy works.
_SMALL = {"eval_seeds": 2, "settings": {"demand.horizon_s": 300}}

# Fewest point MDPs of a sample that give a policy a place, as in reports.
_FEWEST = 10


class Benchmark(Result):
    """What :func:`benchmark` found; it prints as a short table, and has all that a :class:`Result` has."""

    def __init__(self, result: Result, name: str) -> None:
        super().__init__(result.folder, result._table)
        self.name = name
        """What records and pages call the policy."""
        identity = json.loads((self.folder / "manifest.json").read_text())["identity"]
        table = _columns(self._written("summary.csv"))
        row = list(table["method"]).index(name)

        def number(key: str) -> float:
            return float(table[key][row])

        self.score: float = number("overall")
        """Delay in proportion to the baseline's, weighted by importance; below 1 is better than the baseline."""
        low, high = number("overall_low"), number("overall_high")
        self.interval: tuple[float, float] | None = None if math.isnan(low) else (low, high)
        """95% interval of the score."""
        points, family = len(identity["points"]), identity["sample"]["family_size"]
        self.sample = f"{points} of {family} point MDPs, {identity['sample']['sampling']}"
        """Which point MDPs were evaluated."""
        if math.isnan(self.score):
            raise Error(f"no task of {name} succeeded; {self.report()} has the reasons")
        if math.isnan(number("rank")):
            self.published, self._unlike = [], f"{name} lacks results on some point MDPs"
        elif points < min(_FEWEST, family):
            self.published, self._unlike = [], f"fewer than {_FEWEST} point MDPs say too little of the family; give budget=20"
        else:
            self.published, self._unlike = _published(identity)
        """The published rows of the same family, preset, settings and version: method, score, low, high."""
        self.ahead, self.behind, self.open = ([row["method"] for row in self.published if self._side(row) == s] for s in (1, -1, 0))

    def _side(self, row: Mapping[str, Any]) -> int:
        """Returns 1 where the policy is surely ahead of a published row, -1 where it is behind, 0 where that is open."""
        if self.interval is None:
            return 0
        lead = row["score"] - self.score
        own, other = self.interval, (row["low"], row["high"])
        near = (own[1] - self.score, row["score"] - other[0]) if lead > 0 else (self.score - own[0], other[1] - row["score"])
        return 0 if abs(lead) <= math.hypot(*near) else (1 if lead > 0 else -1)

    @property
    def rank(self) -> tuple[int, int] | None:
        """First and last place that the policy may have among the published methods; None where nothing is published."""
        return (len(self.behind) + 1, len(self.behind) + len(self.open) + 1) if self.published else None

    @property
    def decided(self) -> str:
        """What the intervals decide, and what they do not, in words."""
        if not self.published:
            return f"Nothing is compared: {self._unlike}."
        words = [("ahead of", self.ahead), ("behind", self.behind), ("open, it may be chance, against", self.open)]
        return "; ".join(f"{what} {', '.join(methods)}" for what, methods in words if methods).capitalize() + "."

    def __str__(self) -> str:
        def line(name: str, score: float, interval: tuple[float, float] | None, what: str) -> str:
            span = "" if interval is None else f"{interval[0]:.3f} to {interval[1]:.3f}"
            return f"{name:24} {score:6.3f}  {span:16} {what}".rstrip()

        rows = [(self.score, line(self.name, self.score, self.interval, f"<- {self.sample}"))]
        rows += [(r["score"], line(r["method"], r["score"], (r["low"], r["high"]), "published")) for r in self.published]
        place = ""
        if self.rank is not None:
            first, last = self.rank
            place = f"Place {first}{'' if first == last else f' to {last}'} of {len(self.published) + 1}. "
        head = f"{'method':24} {'score':>6}  95% interval"
        return "\n".join([head, *(text for _, text in sorted(rows)), f"{place}{self.decided}", f"Report: {self.report()}"])


def _published(identity: Mapping[str, Any]) -> tuple[list[dict[str, Any]], str]:
    """Returns the published rows that a run can be compared with; none, and why, where there are none."""
    run = (identity["scenario"], identity["tsc_family"], identity["simulator"])
    try:
        rows: list[dict[str, Any]] = json.loads(_native.published(run, json.dumps(identity["settings"])))["methods"]
    except Error as e:
        return [], str(e)
    return rows, ""


def benchmark(
    policy: Any,
    scenario: str = "salt-lake-city",
    *,
    name: str | None = None,
    budget: int | str | None = 20,
    smoke: bool = False,
    observation: str = "idqn",
    reward: str = "wait",
    out: PathLike | None = None,
    **options: Any,
) -> Benchmark:
    """Evaluates a policy on a sample of a family, and places it among the published methods.

    ``policy`` is one of

    - a :class:`Controller`, as a class or an object;
    - an object with ``predict(observation)``, such as a trained model of Stable-Baselines3, which acts on every point MDP;
    - a function of a Gymnasium environment that trains such an object and returns it: it is called once per point MDP, and
      ``env.total_steps`` says how many steps the run's episodes have;
    - the path of a model that this program has saved (``results/a/models/000/1.safetensors``).

    What it sees and is paid for is ``observation`` and ``reward``, as for :class:`SignalEnv`; a function as
    observation is not possible here. Published scores assist the sample, as in ``tsc-family run``. ``smoke`` takes two small
    point MDPs and short episodes, to see that a policy works. ``options`` are those of :func:`evaluate`; the same call
    continues an interrupted one.
    """
    if _host.loading:
        raise _host.Loaded
    if observation not in ("idqn", "mplight"):
        raise Error(f"observation={observation!r}: give idqn or mplight; a Controller can see anything")
    smoke = smoke or scenario == "smoke"
    if smoke:
        scenario, budget, options = "smoke", None, {**_SMALL, **options}
    what = f"{name or _name(policy)}{'-smoke' if smoke else ''}"
    folder = Path("results") / f"benchmark-{what}" if out is None else Path(fspath(out))
    called, controllers, models = _as_controllers(policy, name, folder, observation, reward)
    learns = not models and callable(getattr(next(iter(controllers.values())), "train", None))
    if smoke and learns:
        options.setdefault("episodes", 2)
    result = evaluate(controllers, scenario, budget=budget, models=models, out=folder, **options)
    return Benchmark(result, called)


def _name(policy: Any) -> str:
    if isinstance(policy, Controller):
        return name_of(type(policy))
    if isinstance(policy, type) and issubclass(policy, Controller):
        return name_of(policy)
    if isinstance(policy, str) or hasattr(policy, "__fspath__"):
        return "model"
    called = getattr(policy, "__name__", None) or type(policy).__name__
    return "".join(c if c.isalnum() else "-" for c in str(called).lower()).strip("-") or "policy"


def _as_controllers(
    policy: Any, name: str | None, folder: Path, observation: str, reward: str
) -> tuple[str, dict[str, Any], dict[str, PathLike]]:
    """Returns what the policy is called, and what :func:`evaluate` takes of it: controllers, and models."""
    from ._policy import PerPoint, Trained

    called = name or _name(policy)
    if isinstance(policy, Controller) or (isinstance(policy, type) and issubclass(policy, Controller)):
        return called, {called: policy}, {}
    if isinstance(policy, str) or hasattr(policy, "__fspath__"):
        if Path(fspath(policy)).suffix != ".safetensors":
            raise Error(f"{policy}: give a .safetensors file of a run; load other models and give the object with predict()")
        return called, {}, {called: policy}
    if hasattr(policy, "predict") or hasattr(policy, "act"):
        file, loader = _saved(policy, folder)
        own = getattr(sys.modules.get(type(policy).__module__), "__file__", None) or "."
        from_there = str(Path(own).absolute().parent)
        return called, {called: _lazily(Trained, str(file), _sha256(file), loader, from_there, observation)}, {}
    if inspect.isfunction(policy):
        path = getattr(sys.modules.get(policy.__module__), "__file__", None)
        if path is None or not Path(path).is_file() or "<" in policy.__qualname__ or "." in policy.__qualname__:
            raise Error(
                f"{policy.__qualname__} is no function at the top level of a file, and every task calls it in a process of "
                "its own: write it to a file (in a notebook: %%writefile mine.py) and import it from there"
            )
        file = Path(path).absolute()
        return called, {called: _lazily(PerPoint, str(file), policy.__name__, _sha256(file), observation, reward)}, {}
    raise Error(f"{policy!r} has neither act(obs) nor predict(observation), and is no function of an environment")


def _lazily(cls: Callable[..., Controller], *args: Any) -> Controller:
    """Returns an object of a controller without its __init__, which only tasks need."""
    made: Controller = cls.__new__(cls, *args)  # type: ignore[call-overload]
    return made


def _saved(policy: Any, folder: Path) -> tuple[Path, str]:
    """Writes a policy for the tasks; returns the file, and how it is loaded where it has its own way."""
    kept = folder.parent / f"{folder.name}-policy"
    kept.mkdir(parents=True, exist_ok=True)
    new, cls = kept / "new.zip", type(policy)
    if callable(getattr(policy, "save", None)) and callable(getattr(cls, "load", None)):
        policy.save(str(new))
        loader = f"{cls.__module__}:{cls.__qualname__}"
    else:
        loader = ""
        new.write_bytes(_pickled(policy))
    # A second saving of the same model may have other bytes, and would be another run.
    file = kept / f"{_state(policy) or _sha256(new)[:16]}.zip"
    if file.is_file():
        new.unlink()
    else:
        new.rename(file)
    return file.absolute(), loader


def _pickled(policy: Any) -> bytes:
    """Returns the bytes of an object; those of classes of a script too where cloudpickle is there."""
    try:
        import cloudpickle as pickler  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ImportError:
        pickler = pickle
        if type(policy).__module__ == "__main__":
            raise Error(
                f"{type(policy).__name__} is a class of the script, which tasks cannot find: write it to a file and import it "
                "from there, give it save() and load(), or pip install cloudpickle"
            ) from None
    try:
        return bytes(pickler.dumps(policy))
    except Exception as e:
        raise Error(f"{type(policy).__name__} has no save() and load(), and cannot be pickled for the tasks: {e}") from None


def _state(policy: Any) -> str:
    """Returns what tells apart two models of Stable-Baselines3; empty for others."""
    state = getattr(getattr(policy, "policy", None), "state_dict", None)
    if not callable(state):
        return ""
    whole = hashlib.sha256()
    for key, value in sorted(state().items()):
        whole.update(key.encode() + value.detach().cpu().numpy().tobytes())
    return whole.hexdigest()[:16]


def _sha256(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
