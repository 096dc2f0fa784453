"""The base class of controllers."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ._native import Error, Observation, Signal

if TYPE_CHECKING:
    from ._training import Training

# Seed of the next object; the host sets it.
_next_seed = 0


def set_seed(seed: int) -> None:
    """Says which seed the next controller gets."""
    global _next_seed
    _next_seed = seed


class Controller:
    """A controller of your own: give it a ``name``, and say in :meth:`act` which phases to show.

    It is a class, not an object: every task makes one anew, in a process of its own, from the file that the class is
    written in. What ``__init__`` gets must therefore be plain data (JSON), and is part of what the run records. Two
    objects with the same seed must decide alike; draw random numbers from ``self.rng``.

    Optional: ``train(self, env)`` for methods that learn, ``save(self, path)`` and ``load(self, path)`` to keep what was
    learned as the run's model, where ``path`` is a file.
    """

    name: str = ""
    """What records and pages call it: a to z, 0 to 9 and -; the class's name in small letters where it is empty."""

    files: Sequence[str] = ()
    """Further files that it consists of, such as weights, beside its own and the modules that it imports from there."""

    seed: int
    """Of everything random in it."""

    rng: np.random.Generator
    """A generator of that seed."""

    _arguments: tuple[tuple[Any, ...], dict[str, Any]]

    def __new__(cls, *args: Any, **kwargs: Any) -> Any:
        self = super().__new__(cls)
        self.seed = _next_seed
        self.rng = np.random.default_rng(_next_seed)
        self._arguments = (args, kwargs)
        return self

    def begin(self, signals: list[Signal]) -> None:
        """Starts an episode on these signals."""

    def act(self, obs: Observation) -> Sequence[int]:
        """Returns the phase of every signal for the next interval: indices into ``signal.phases``."""
        raise NotImplementedError(f"{type(self).__name__} has no act(self, obs)")

    if TYPE_CHECKING:

        def train(self, env: Training) -> None:
            """Learns, on the run's training seeds, before it is evaluated; :meth:`begin` was called before."""

        def save(self, path: str) -> None:
            """Writes what was learned to a file."""

        def load(self, path: str) -> None:
            """Takes over what ``save`` wrote."""


class Learner(Controller):
    """A learner of this library that is paid for something else, or sees something else; say which in :attr:`method`.

    Network, exploration, updates, validation and checkpoints are those of the learner, and so are its settings
    (``settings={"idqn": {"learning_rate": 1e-4}}``). Give it ``reward(self, obs, signal)``, ``observation(self, obs,
    signal)``, or both. ``obs`` has one signal. What the learner itself is paid for and sees is in ``obs.wait()`` and
    ``obs.idqn()`` (idqn and ippo), ``obs.pressure()`` and ``obs.mplight()`` (mplight and its variants).

    :meth:`begin` is called at the start of every episode; reset there what a reward remembers.
    """

    method: str = "idqn"
    """The learner: ``idqn``, ``ippo``, ``mplight`` or ``mplight-star``."""

    if TYPE_CHECKING:

        def reward(self, obs: Observation, signal: Signal) -> float:
            """Returns what the interval that has passed at a signal was worth; called once per interval in training."""

        def observation(self, obs: Observation, signal: Signal) -> Any:
            """Returns what is seen of a signal: as many finite numbers each time, of about the size of 1.

            The numbers of an array are read row by row. A linear layer takes the place of the learner's convolution over
            lanes. Called several times per interval, so that it must remember nothing; at first without vehicles, for the
            number of numbers. Only for idqn and ippo: the network of mplight is made of movements.
            """


def learner_of(cls: type[Controller]) -> str | None:
    """Returns the learner that a class is built on, if it is built on one."""
    if not issubclass(cls, Learner):
        return None
    for method in ("act", "train", "save", "load"):
        if getattr(cls, method, None) is not getattr(Controller, method, None):
            raise Error(
                f"{cls.__name__}.{method} would never be called: a Learner acts, trains and saves as {cls.method} does; "
                "remove it, or derive from tsc_family.Controller"
            )
    if not (callable(getattr(cls, "reward", None)) or callable(getattr(cls, "observation", None))):
        raise Error(
            f"{cls.__name__} replaces nothing of {cls.method}; give it reward(self, obs, signal) or "
            "observation(self, obs, signal)"
        )
    return cls.method


def numbers_of(answer: Any) -> np.ndarray[Any, np.dtype[np.float32]]:
    """Returns the numbers of what ``observation`` returned, in one row."""
    try:
        return np.ascontiguousarray(answer, dtype=np.float32).ravel()
    except (TypeError, ValueError):
        raise Error(f"observation() returned {answer!r}; return an array of numbers") from None


def number_of(answer: Any) -> float:
    """Returns the number that ``reward`` returned."""
    try:
        return float(answer)
    except (TypeError, ValueError):
        raise Error(f"reward() returned {answer!r}; return a number") from None


def name_of(cls: type[Controller]) -> str:
    """Returns what records call a controller."""
    return cls.name or cls.__name__.lower().replace("_", "-")


def arguments_of(controller: Controller) -> str:
    """Returns what a controller was made with, as JSON; empty without arguments."""
    args, kwargs = controller._arguments
    if not args and not kwargs:
        return ""
    given = {"args": list(args), "kwargs": kwargs}
    try:
        text = json.dumps(given, sort_keys=True, allow_nan=False)
    except (TypeError, ValueError) as e:
        name = type(controller).__name__
        raise Error(
            f"{name} was made with something that is no plain data ({e}); every task makes it anew, so give it numbers, "
            f"texts, lists and dicts, or the path of a file in `files`"
        ) from None
    return text
