"""Policies of any library as controllers: one that is trained, or a function that trains one per point MDP."""

from __future__ import annotations

import importlib
import inspect
import pickle
import random
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from . import _host
from ._controller import Controller
from ._native import Error, Observation, Signal
from ._training import Training


class _Acting(Controller):
    """What asks a policy for the phase of every signal."""

    observation: str
    policy: Any

    def begin(self, signals: list[Signal]) -> None:
        self._signals = signals
        self._ask, self._shape = None, None

    def act(self, obs: Observation) -> list[int]:
        if hasattr(self.policy, "act") and not hasattr(self.policy, "predict"):
            return list(self.policy.act(obs))
        if self._ask is None:
            self._ask = asked(self.policy)
            self._shape = getattr(getattr(self.policy, "observation_space", None), "shape", None)
        return [self._phase(obs, index, signal) for index, signal in enumerate(self._signals)]

    def _phase(self, obs: Observation, index: int, signal: Signal) -> int:
        seen = obs.idqn(index) if self.observation == "idqn" else obs.mplight(index)
        answer = self._ask(padded(np.asarray(seen, dtype=np.float32), self._shape))
        action = np.asarray(answer[0] if isinstance(answer, tuple) else answer).reshape(-1)
        phases = len(signal.phases)
        known = max(phases, getattr(getattr(self.policy, "action_space", None), "n", 0))
        if action.size != 1 or action.dtype.kind not in "iu" or not 0 <= action[0] < known:
            raise Error(f"predict returned {answer!r} for signal {signal.id}; a phase is a whole number from 0 to {phases - 1}")
        # As in the environments: a padded action keeps the phase that is shown.
        return int(action[0] if action[0] < phases else obs.phase[index])


class Trained(_Acting):
    """A policy that is trained, read from the file that benchmark() wrote."""

    def __init__(self, file: str, sha256: str, loader: str, folder: str, observation: str) -> None:
        self.observation = observation
        # Where the script imports its own modules from.
        sys.path.append(folder)
        if not loader:
            self.policy = pickle.loads(Path(file).read_bytes())
            return
        module, _, name = loader.partition(":")
        self.policy = getattr(importlib.import_module(module), name).load(file)


class PerPoint(_Acting):
    """A policy that a function of an environment trains on every point MDP."""

    def __init__(self, file: str, function: str, sha256: str, observation: str, reward: str) -> None:
        self.observation, self._reward = observation, reward
        # The script's folder comes beside that of installed packages, and does not take its place.
        _host._folders.clear()
        module, _ = _host._load(Path(file))
        self._make: Callable[[Any], Any] = getattr(module, function)

    def train(self, env: Training) -> None:
        gym = env.gym(observation=self.observation, reward=self._reward)
        seed = self.seed % 2**31
        random.seed(seed), np.random.seed(seed), gym.action_space.seed(seed)
        if "torch" in sys.modules:
            # Workers share the processors.
            sys.modules["torch"].manual_seed(seed), sys.modules["torch"].set_num_threads(1)
        self.policy = self._make(gym)
        if not (hasattr(self.policy, "predict") or hasattr(self.policy, "act")):
            raise Error(f"{self._make.__name__} returned {self.policy!r}, which has neither predict(observation) nor act(obs)")


def asked(policy: Any) -> Callable[[Any], Any]:
    """Returns the policy's best action as a function of an observation."""
    try:
        knows = "deterministic" in inspect.signature(policy.predict).parameters
    except (TypeError, ValueError):
        knows = False
    return (lambda seen: policy.predict(seen, deterministic=True)) if knows else policy.predict


def padded(seen: np.ndarray[Any, Any], shape: tuple[int, ...] | None) -> np.ndarray[Any, Any]:
    """Returns an observation in the shape that a policy was trained for, with zeros where the signal has less."""
    if shape is None or seen.shape == tuple(shape):
        return seen
    if len(shape) != seen.ndim or any(has > room for has, room in zip(seen.shape, shape)):
        raise Error(
            f"the policy was trained for observations of shape {tuple(shape)}, and this signal has {seen.shape}; train it with "
            "sizes=tf.sizes(points) of all point MDPs, or give a function that trains one per point MDP"
        )
    room = np.zeros(shape, dtype=seen.dtype)
    room[tuple(slice(0, size) for size in seen.shape)] = seen
    return room
