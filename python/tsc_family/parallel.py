"""Several signals as a PettingZoo environment in which all agents act at once."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from pettingzoo import ParallelEnv  # type: ignore[import-untyped]

from ._family import Settings
from ._native import Error, Signal
from ._place import Path, Where, check_seed
from ._view import ObservationOf, RewardOf, View

_SEEDS = 2**30


class SignalsEnv(ParallelEnv):  # type: ignore[misc]
    """Signals of a SUMO configuration, or of a point MDP, as agents; see :class:`tsc_family.SignalEnv` for the options.

    All agents have the same spaces, with room for the largest signal; ``infos[agent]["action_mask"]`` says which actions
    are phases. At the end of an episode every ``info`` has what a record has of the whole network.
    """

    metadata: dict[str, Any] = {"name": "tsc_family_signals_v0", "render_modes": [], "is_parallelizable": True}

    def __init__(
        self,
        point: str | None = None,
        *,
        sumocfg: Path | None = None,
        scenario: str = "salt-lake-city",
        preset: str | None = None,
        settings: Settings | None = None,
        networks: Path | None = None,
        observation: str | ObservationOf = "idqn",
        reward: str | RewardOf = "wait",
        observation_space: spaces.Space[Any] | None = None,
        sizes: Mapping[str, int] | None = None,
    ) -> None:
        self.render_mode = None
        self._place = Where(scenario, preset, settings, networks).place(point, sumocfg)
        if sizes is not None:
            self._place.resize(dict(sizes))
        room = {**self._place.sizes(), **(sizes or {})}
        self._view = View(observation, reward, observation_space, room)
        self.signals: dict[str, Signal] = {signal.id: signal for signal in self._place.signals()}
        self.possible_agents: list[str] = list(self.signals)
        self.agents: list[str] = []
        # Each agent draws from spaces of its own.
        both = (self._view.observation_space, self._view.action_space)
        self._spaces = {agent: copy.deepcopy(both) for agent in self.possible_agents}
        self._masks = {agent: signal.phase_mask.astype(np.int8) for agent, signal in self.signals.items()}
        self._random = np.random.default_rng()

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Returns what an agent may see."""
        return self._spaces[agent][0]

    def action_space(self, agent: str) -> spaces.Discrete:
        """Returns what an agent may do."""
        return self._spaces[agent][1]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
        """Starts an episode with the vehicles of a seed; without one, the next follows from the last."""
        if seed is not None:
            self._random = np.random.default_rng(check_seed(seed))
        self._seed = int(self._random.integers(_SEEDS)) if seed is None else int(seed)
        self._place.reset(self._seed)
        self.agents = list(self.possible_agents)
        infos = self._infos()
        for info in infos.values():
            info["seed"] = self._seed
        return self._observations(), infos

    def step(self, actions: Mapping[str, Any]) -> tuple[
        dict[str, Any], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]
    ]:
        """Asks for a phase of every signal and lets the interval go by; an action that is no phase keeps the phase."""
        if not self.agents:
            raise Error("the episode is over; call reset() first")
        infos = self._infos()
        phases = []
        for index, agent in enumerate(self.possible_agents):
            if agent not in actions:
                raise Error(f"there is no action of {agent!r}; all signals decide at once")
            phase, mask = int(actions[agent]), self._masks[agent]
            if not (0 <= phase < len(mask) and mask[phase]):
                if not self._spaces[agent][1].contains(phase):
                    raise Error(f"action {actions[agent]!r} of {agent!r} is not in {self._spaces[agent][1]}")
                infos[agent]["invalid_action"] = True
                phase = self._place.phase(index)
            phases.append(phase)
        over = self._place.step(phases)
        observations = self._observations()
        signals = enumerate(self.signals.items())
        rewards = {agent: self._view.reward(self._place, i, signal) for i, (agent, signal) in signals}
        if over:
            record = {**self._place.finish(), "seed": self._seed}
            for info in infos.values():
                info.update(record)
            self.agents = []
        agents = self.possible_agents
        return observations, rewards, dict.fromkeys(agents, False), dict.fromkeys(agents, over), infos

    def close(self) -> None:
        """Ends the episode, so that another environment may simulate in this process."""
        self._place.close()

    def _observations(self) -> dict[str, Any]:
        signals = enumerate(self.signals.items())
        return {agent: self._view.observe(self._place, i, signal) for i, (agent, signal) in signals}

    def _infos(self) -> dict[str, dict[str, Any]]:
        return {agent: {"action_mask": mask.copy()} for agent, mask in self._masks.items()}


def parallel_env(point: str | None = None, **kwargs: Any) -> SignalsEnv:
    """Returns several signals as a PettingZoo environment; the arguments are those of :class:`SignalsEnv`."""
    return SignalsEnv(point, **kwargs)
