"""A training as a gymnasium environment."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from . import _native
from ._native import Error, Signal
from ._view import ObservationOf, RewardOf, View, masks
from ._training import Training


class TrainingEnv(gymnasium.Env[Any, Any]):
    """The signal of a training; see :meth:`tsc_family.Training.gym`."""

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(
        self,
        training: Training,
        lesson: _native.Lesson,
        signal: Signal,
        observation: str | ObservationOf,
        reward: str | RewardOf,
        observation_space: spaces.Space[Any] | None,
    ) -> None:
        self._training, self._lesson, self.signal = training, lesson, signal
        self.render_mode = None
        self._view = View(observation, reward, observation_space, lesson.sizes())
        self.observation_space = self._view.observation_space
        self.action_space = self._view.action_space
        self._mask = signal.phase_mask.astype(np.int8)

        self.total_steps: int = training.episodes * training.decisions
        """Steps of all episodes that learners are trained for in the run."""

    def action_masks(self) -> NDArray[np.bool_]:
        """Returns which actions are phases, as MaskablePPO of sb3-contrib asks for it."""
        return masks(self._mask, self.action_space)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Starts the next episode of the run; a seed is for what is random in the environment's spaces alone."""
        super().reset(seed=seed)
        self._training.reset()
        return self._view.observe(self._lesson, 0, self.signal), {"action_mask": self._mask.copy()}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Asks for a phase and lets the interval go by."""
        if not self.action_space.contains(int(action)):
            raise Error(f"action {action!r} is not in {self.action_space}")
        _, over = self._training.step([int(action)])
        info: dict[str, Any] = {"action_mask": self._mask.copy()}
        seen = self._view.observe(self._lesson, 0, self.signal)
        reward = self._view.reward(self._lesson, 0, self.signal)
        if over:
            info["delay_s"] = self._training.delay_s
        return seen, reward, False, over, info
