"""Signals as gymnasium environments: ``gymnasium.make("tsc_family/Signal-v0", point="...")``.

A process simulates one place at a time. :func:`make_vec` gives every environment a process of its own.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AsyncVectorEnv
from numpy.typing import NDArray

from . import _native
from ._family import Settings
from ._native import Error, Signal
from ._place import Path, Where, check_seed
from ._place import sizes as sizes_of
from ._view import ObservationOf, RewardOf, View, masks, no_window

_SEEDS = 2**30


class SignalEnv(gymnasium.Env[Any, Any]):
    """One signal: an action is the green phase to ask for, a step is the time until the next decision.

    - ``point`` is a point MDP of ``scenario``, or several, which then follow one another, one per episode; ``sumocfg``
      is a SUMO configuration instead, with ``signal``, the id of the one to decide, where it has several: the others
      run their own program.
    - ``observation`` is ``idqn`` (a row per lane: whether the lane's number is that of the phase, approaching vehicles,
      waiting time, queue, speeds; scaled) or ``mplight`` (the phase, then the pressure of every movement), or a
      function of an :class:`~tsc_family.Observation` and the :class:`~tsc_family.Signal`, with its
      ``observation_space``.
    - ``reward`` is ``wait`` (waiting times, scaled and cut) or ``pressure`` (queues before less queues behind), or such
      a function.
    - ``sizes`` gives arrays more room than the signal needs, so that spaces are equal over a family; see
      :func:`tsc_family.sizes`. ``info["action_mask"]`` and ``action_masks()`` say which actions are phases; another one keeps the phase.

    ``reset(seed=s)`` has the vehicles of a run's row with seed ``s``; without a seed, the next follows from the last.
    Episodes are truncated when their time is over, and never terminated; ``info`` then has what a record has
    (``delay_s``, ``waiting_s``, ...).
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        point: str | Sequence[str] | None = None,
        *,
        sumocfg: Path | None = None,
        signal: str | None = None,
        scenario: str = "salt-lake-city",
        preset: str | None = None,
        settings: Settings | None = None,
        networks: Path | None = None,
        observation: str | ObservationOf = "idqn",
        reward: str | RewardOf = "wait",
        observation_space: spaces.Space[Any] | None = None,
        sizes: Mapping[str, int] | None = None,
        render_mode: str | None = None,
    ) -> None:
        if render_mode is not None:
            raise Error(no_window(render_mode))
        self.render_mode = None
        self._where = Where(scenario, preset, settings, networks)
        self._sumocfg = sumocfg
        self._signal_id = signal
        self._points: list[str | None] = [point] if point is None or isinstance(point, str) else list(point)
        self._episode = -1
        self._number = -1
        self._place: _native.Simulation | None = None
        if not self._points:
            raise Error("no point MDPs are given")
        if sizes is None and len(self._points) > 1:
            names = [str(p) for p in self._points]
            sizes = sizes_of(names, scenario=scenario, preset=preset, settings=settings, networks=networks)
        self._sizes = dict(sizes or {})
        self._enter(0)
        self._view = View(observation, reward, observation_space, {**self._now.sizes(), **self._sizes})
        self.observation_space = self._view.observation_space
        self.action_space = self._view.action_space

    def _enter(self, number: int) -> None:
        """Takes the place with a number, which may be the one it is."""
        point = self._points[number % len(self._points)]
        if self._number == number % len(self._points):
            return
        self.close()
        place = self._where.place(point, self._sumocfg)
        ids = place.ids()
        if self._signal_id is None and len(ids) > 1:
            shown = ", ".join(ids[:5]) + (", ..." if len(ids) > 5 else "")
            raise Error(f"there are {len(ids)} signals ({shown}); name one with signal=..., or use parallel_env")
        if self._signal_id is not None and self._signal_id not in ids:
            raise Error(f"there is no signal {self._signal_id!r}; there are {', '.join(ids)}")
        self._index = 0 if self._signal_id is None else ids.index(self._signal_id)
        place.decide_only(self._index)
        if self._sizes:
            place.resize(self._sizes)
        self._place, self._count = place, len(ids)
        self._number = number % len(self._points)
        self.point = point
        self.signal: Signal = place.signals()[0]
        self._mask: NDArray[np.int8] = self.signal.phase_mask.astype(np.int8)

    @property
    def _now(self) -> _native.Simulation:
        if self._place is None:
            raise Error("there is no place")
        return self._place

    @property
    def delta_time_s(self) -> int:
        """Simulated seconds between two decisions."""
        return int(self._now.delta_time_s)

    def action_masks(self) -> NDArray[np.bool_]:
        """Returns which actions are phases, as MaskablePPO of sb3-contrib asks for it."""
        return masks(self._mask, self.action_space)

    def _info(self) -> dict[str, Any]:
        info: dict[str, Any] = {"action_mask": self._mask.copy()}
        if self.point is not None:
            info["point"] = self.point
        return info

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Starts an episode with the vehicles of a seed."""
        super().reset(seed=seed)
        of_episode = int(self.np_random.integers(_SEEDS)) if seed is None else check_seed(seed)
        self._episode += 1
        self._enter(self._episode)
        self._seed = of_episode
        self._now.reset(of_episode)
        return self._view.observe(self._now, self._index, self.signal), {**self._info(), "seed": of_episode}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Asks for a phase and lets the interval go by."""
        try:
            phase = int(action)
        except (TypeError, ValueError, OverflowError):
            raise Error(f"action {action!r} is not in {self.action_space}") from None
        info = self._info()
        if not (0 <= phase < len(self._mask) and self._mask[phase]):
            if not self.action_space.contains(phase):
                raise Error(f"action {action!r} is not in {self.action_space}")
            info["invalid_action"] = True
            phase = self._now.phase(self._index)
        phases = [0] * self._count
        phases[self._index] = phase
        over = self._now.step(phases)
        seen = self._view.observe(self._now, self._index, self.signal)
        reward = self._view.reward(self._now, self._index, self.signal)
        if over:
            info.update(self._now.finish(), seed=self._seed)
        return seen, reward, False, over, info

    def close(self) -> None:
        """Ends the episode, so that another environment may simulate in this process."""
        if self._place is not None:
            self._place.close()


def make_vec(points: Sequence[str], num_envs: int | None = None, **kwargs: Any) -> AsyncVectorEnv:
    """Returns environments that run side by side, each in a process of its own, with observations in shared memory.

    Environment ``i`` plays ``points[i]``, ``points[i + num_envs]``, ... in turn, or ``points[i % len(points)]`` where
    there are fewer points than environments. ``kwargs`` are those of :class:`SignalEnv`. In a script, call it below
    ``if __name__ == "__main__":``, as everything that starts processes.
    """
    points = list(points)
    count = len(points) if num_envs is None else num_envs
    if not points or count < 1:
        raise Error("give at least one point MDP and one environment")
    kwargs = dict(kwargs)
    if kwargs.get("sizes") is None:
        where = {name: kwargs[name] for name in ("scenario", "preset", "settings", "networks") if name in kwargs}
        kwargs["sizes"] = sizes_of(dict.fromkeys(points), **where)
    shares = [points[i::count] or [points[i % len(points)]] for i in range(count)]
    # A process that is forked would have a simulator in an unknown state.
    return AsyncVectorEnv(
        [functools.partial(SignalEnv, share, **kwargs) for share in shares], shared_memory=True, context="spawn"
    )

