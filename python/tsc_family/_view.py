"""What learners see of signals, and what they are paid for."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping
from typing import Any, Union

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from . import _native
from ._native import Error, Observation, Signal

ObservationOf = Callable[[Observation, Signal], NDArray[Any]]
"""What a learner sees: of an observation whose first axis has one signal, and that signal."""

RewardOf = Callable[[Observation, Signal], float]
"""What a learner is paid for."""

Place = Union[_native.Simulation, _native.Lesson]
"""What simulates signals."""

_OBSERVATIONS = ("idqn", "mplight")
_REWARDS = ("wait", "pressure")


def masks(phases: NDArray[Any], space: spaces.Space[Any]) -> NDArray[np.bool_]:
    """Returns for every action of a space whether it is a phase."""
    mask = np.zeros(int(getattr(space, "n")), dtype=bool)
    mask[: len(phases)] = phases[: len(mask)].astype(bool)
    return mask


def no_window(mode: str) -> str:
    """Says why nothing is rendered, and how to see an episode."""
    gui = shutil.which("sumo-gui")
    shows = f"{gui} shows it" if gui else "sumo-gui, which is not installed here, shows it"
    return (
        f"render_mode={mode!r}: SUMO runs within this process as a library, which has no window. "
        f"`tsc-family routes --run DIR --point POINT --method METHOD --out FOLDER` writes an episode that a run has recorded, and {shows}: "
        "sumo-gui -c FOLDER/episode.sumocfg"
    )


class View:
    """What a learner sees of the signals of places, and what it is paid for."""

    def __init__(
        self,
        observation: str | ObservationOf,
        reward: str | RewardOf,
        observation_space: spaces.Space[Any] | None,
        room: Mapping[str, int],
    ) -> None:
        for given, known, what in [(observation, _OBSERVATIONS, "observation"), (reward, _REWARDS, "reward")]:
            if isinstance(given, str) and given not in known:
                raise Error(f"there is no {what} {given!r}; there are {', '.join(known)}, or give a function")
        if callable(observation) and observation_space is None:
            raise Error("with a function as observation, give observation_space=... too")
        if isinstance(observation, str) and observation_space is not None:
            raise Error(f"observation_space has no effect: {observation!r} has its own")
        self._observation = observation
        self._reward = reward
        self.action_space = spaces.Discrete(room["phases"])
        self.observation_space = observation_space or self._space(room)

    def _space(self, room: Mapping[str, int]) -> spaces.Box:
        if self._observation == "idqn":
            shape = (max(room["lanes"], room["phases"], 2), 5)
            return spaces.Box(0.0, np.inf, shape, np.float32)
        low = np.full(1 + room["slots"], -np.inf, np.float32)
        low[0] = 0.0
        return spaces.Box(low, np.inf, dtype=np.float32)

    def observe(self, place: Place, index: int, signal: Signal) -> Any:
        """Returns what is seen of a signal."""
        if callable(self._observation):
            return self._observation(place.observe(index), signal)
        return place.idqn(index) if self._observation == "idqn" else place.mplight(index)

    def reward(self, place: Place, index: int, signal: Signal) -> float:
        """Returns what the last interval at a signal was worth."""
        if callable(self._reward):
            return float(self._reward(place.observe(index), signal))
        return place.wait(index) if self._reward == "wait" else place.pressure(index)
