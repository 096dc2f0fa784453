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
