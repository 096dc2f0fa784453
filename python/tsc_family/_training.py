"""What a controller's ``train`` gets: the run's training seeds, episode by episode."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from . import _native
from ._native import Error, Observation, Signal

if TYPE_CHECKING:
    from gymnasium import Env, spaces

    from ._view import ObservationOf, RewardOf


class Training:
    """The training of a controller on one point MDP.

    ``reset`` starts the next episode, with the next training seed of the run, and gives up one that goes on; ``step``
    asks for phases. What ``log`` is given goes into the row of the episode, until something else is asked for than a
    step: the next episode, or :attr:`delay_s`.
    """

    def __init__(self, lesson: _native.Lesson, episodes: int) -> None:
        self._lesson = lesson
        self._first: Observation | None = None
        self.episodes = episodes
        """Episodes that learners are trained for in this run (``--episodes``); ``train`` decides what it does."""

    @property
    def decisions(self) -> int:
        """Decisions of an episode."""
        return self._lesson.decisions

    @property
    def signals(self) -> list[Signal]:
        """The signals, as ``begin`` gets them."""
        self._look()
        return self._lesson.signals()

    def _look(self) -> None:
        """Starts the first episode where nothing is known yet; the first ``reset`` is then that one."""
        if self._first is None and not self._lesson.sizes()["lanes"]:
            self._first = self._lesson.reset()

    def reset(self) -> Observation:
        """Starts the next episode and returns what is seen before its first decision."""
        first, self._first = self._first, None
        return self._lesson.reset() if first is None else first

    def step(self, phases: Any) -> tuple[Observation, bool]:
        """Asks for a phase of every signal, and returns what is seen at the next decision and whether there is none."""
        self._first = None
        return self._lesson.step(phases)

    def log(self, **figures: float) -> None:
        """Adds figures to the row of the episode, by name; what is no finite number is left out."""
        for name, value in figures.items():
            self._lesson.log(name, float(value))

    @property
    def delay_s(self) -> float:
        """Mean delay per vehicle in the episode that is over, seconds; its row is written with this."""
        return float(self._lesson.finish())

    def validate(self) -> bool:
        """Offers what was learned so far for validation, between two episodes; returns whether training goes on.

        From ``training.validation_start`` on, every ``training.validation_interval`` episodes, the controller plays further
        episodes with ``begin`` and ``act``. A controller with ``save`` and ``load`` gets its best policy back at the end.
        It is ``False`` when ``training.patience`` is exhausted; without that setting it is always ``True``.
        """
        return self._lesson.validate()

    def gym(
        self,
        observation: str | ObservationOf = "idqn",
        reward: str | RewardOf = "wait",
        observation_space: spaces.Space[Any] | None = None,
    ) -> Env[Any, Any]:
        """Returns the training as a gymnasium environment, for libraries that want one; of one signal.

        Options are those of :class:`tsc_family.SignalEnv`. Every ``reset`` starts the next episode of the run, whatever
        seed it is given.
        """
        from ._training_env import TrainingEnv

        self._look()
        signals = self.signals
        if len(signals) > 1:
            raise Error(f"there are {len(signals)} signals; an environment of gymnasium has one, so use env.step()")
        return TrainingEnv(self, self._lesson, signals[0], observation, reward, observation_space)


def train(controller: Any, lesson: _native.Lesson, episodes: int) -> None:
    """Trains a controller; the native part calls this on a thread of its own."""
    training = Training(lesson, episodes)
    controller.begin(training.signals)
    controller.train(training)
