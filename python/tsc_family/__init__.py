"""Which traffic signal controller is best, over the whole family of a city's intersections, and how sure are we?

- :class:`Controller` and :func:`evaluate`: a controller of one's own, ranked beside those of tsc-family.
- :func:`benchmark`: one answer for any policy: its score, and its place among what is published.
- :func:`family`, :func:`sample`, :func:`estimate`: the statistics alone, on scores of any kind.
- ``gymnasium.make("tsc_family/Signal-v0", ...)``, :func:`make_vec`, :func:`parallel_env`: environments to learn in.
- :func:`run`: everything else that the command ``tsc-family`` does.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from ._native import Error, Lane, Limits, Movement, Observation, Phase, Signal
from ._register import is_command as _is_command
from ._register import register as _register

if TYPE_CHECKING:
    from ._benchmark import Benchmark, benchmark
    from ._controller import Controller, Learner
    from ._evaluate import Result, evaluate, run
    from ._family import Estimate, Family, Sample, estimate, family, sample
    from ._place import sizes
    from ._training import Training
    from .envs import SignalEnv, make_vec
    from .parallel import SignalsEnv, parallel_env

if not _is_command():
    # A worker is started for every task, and importing gymnasium takes longer than some of them.
    try:
        _register()
    except ImportError:
        pass

__all__ = [
    "Benchmark",
    "Controller",
    "Error",
    "Estimate",
    "Family",
    "Lane",
    "Learner",
    "Limits",
    "Movement",
    "Observation",
    "Phase",
    "Result",
    "Sample",
    "Signal",
    "SignalEnv",
    "SignalsEnv",
    "Training",
    "benchmark",
    "estimate",
    "evaluate",
    "family",
    "make_vec",
    "parallel_env",
    "run",
    "sample",
    "sizes",
]

# Loaded when they are asked for: the command starts a worker per task, most of which need none of it, and gymnasium
# and pettingzoo may not be there.
_WHERE = {
    "Benchmark": "_benchmark",
    "benchmark": "_benchmark",
    "Controller": "_controller",
    "Learner": "_controller",
    "Training": "_training",
    "evaluate": "_evaluate",
    "Result": "_evaluate",
    "run": "_evaluate",
    "Estimate": "_family",
    "Family": "_family",
    "Sample": "_family",
    "estimate": "_family",
    "family": "_family",
    "sample": "_family",
    "sizes": "_place",
    "SignalEnv": "envs",
    "make_vec": "envs",
    "SignalsEnv": "parallel",
    "parallel_env": "parallel",
}


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f".{_WHERE[name]}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
