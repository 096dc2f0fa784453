"""The native part of tsc_family: what its Python part is made of."""

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

class Error(Exception):
    """What tsc-family cannot do, why, and the way out."""

class Lane:
    """An incoming lane."""

    @property
    def id(self) -> str:
        """SUMO's id of the lane."""
    @property
    def length_m(self) -> float:
        """Length, metres."""

class Movement:
    """Vehicles that come from one approach and turn the same way."""

    @property
    def index(self) -> int:
        """RESCO's number: three times the slot of the approach, plus 0 right, 1 through, 2 left."""
    @property
    def turn(self) -> str:
        """``left``, ``through`` or ``right``; U-turns count as left."""
    @property
    def lanes(self) -> list[int]:
        """Lanes from which it can be made; several movements may share one."""
    @property
    def downstream(self) -> list[int]:
        """Columns of ``Observation.downstream_queue``: the lanes of other signals that it leads to."""
    @property
    def share(self) -> float | None:
        """Share of the approach's vehicles that make it, where the demand says so."""

class Phase:
    """A green phase."""

    @property
    def state(self) -> str:
        """SUMO's state, one letter per link."""
    @property
    def pair(self) -> list[int]:
        """Movements that it is named by and that count for its pressure."""
    @property
    def service(self) -> list[str]:
        """How it serves each movement: ``red``, ``permissive`` or ``protected``."""

class Limits:
    """How long phases may and must be shown, seconds; the signal keeps to them, whatever it is asked for."""

    @property
    def min_green_s(self) -> NDArray[np.float64]:
        """Shortest green of each phase."""
    @property
    def max_green_s(self) -> NDArray[np.float64]:
        """Longest green of each phase; infinite where there is no limit."""
    @property
    def change_s(self) -> NDArray[np.float64]:
        """Yellow and all-red from one phase (row) to another (column)."""
    @property
    def min_cycle_s(self) -> float:
        """Shortest fixed cycle."""
    @property
    def max_cycle_s(self) -> float:
        """Longest fixed cycle, unless the shortest greens make it longer."""
    @property
    def own_program(self) -> bool:
        """Whether the network's own program keeps to these limits."""

class Signal:
    """A signal: its lanes, movements and phases, and how long phases may and must be shown."""

    @property
    def id(self) -> str:
        """SUMO's id of the signal."""
    @property
    def lanes(self) -> list[Lane]:
        """Incoming lanes."""
    @property
    def movements(self) -> list[Movement]:
        """Movements that exist."""
    @property
    def phases(self) -> list[Phase]:
        """Green phases: what a controller chooses from."""
    @property
    def phase_lanes(self) -> NDArray[np.bool_]:
        """Lanes with a green in each phase, shape ``[phases, lanes]``; as wide as observations, read-only."""
    @property
    def phase_mask(self) -> NDArray[np.bool_]:
        """Which phases are there, as wide as in observations; read-only."""
    @property
    def lane_mask(self) -> NDArray[np.bool_]:
        """Which lanes are there, as wide as in observations; read-only."""
    @property
    def limits(self) -> Limits:
        """How long phases may and must be shown."""

class Observation:
    """What signals' detectors tell at a decision; arrays are new each time, masks are shared and read-only."""

    @property
    def lanes(self) -> NDArray[np.float32]:
        """Shape ``[signals, lanes, 5]``: queue, approach, total_wait_s, max_wait_s, total_speed_mps, within sight."""
    @property
    def phase(self) -> NDArray[np.int64]:
        """The green of each signal, shape ``[signals]``."""
    @property
    def downstream_queue(self) -> NDArray[np.float32]:
        """Queues of the lanes of other signals that movements lead to, shape ``[signals, most]``."""
    @property
    def seen(self) -> NDArray[np.float32]:
        """Vehicles that have come so far, shape ``[signals, movements]``."""
    @property
    def lane_mask(self) -> NDArray[np.bool_]:
        """Which lanes are there, shape ``[signals, lanes]``."""
    @property
    def phase_mask(self) -> NDArray[np.bool_]:
        """Which phases are there, shape ``[signals, phases]``."""
    def idqn(self, signal: int = 0) -> NDArray[np.float32]:
        """Returns what IDQN sees of a signal: a row per lane or phase, whichever are more; scaled."""
    def mplight(self, signal: int = 0) -> NDArray[np.float32]:
        """Returns what MPLight sees of a signal: its phase, and the pressure of every movement."""
    def wait(self, signal: int = 0) -> float:
        """Returns what IDQN is paid for: waiting times, scaled and cut."""
    def pressure(self, signal: int = 0) -> float:
        """Returns what MPLight is paid for: queues behind less queues at the signal."""

class Simulation:
    """A place whose signals are simulated, episode after episode; one per process at a time."""

    def __init__(
        self, point: str | None, sumocfg: str | None, scenario: str, settings: Sequence[str], networks: str | None
    ) -> None: ...
    @property
    def delta_time_s(self) -> int:
        """Simulated seconds between two decisions."""
    @property
    def decisions(self) -> int:
        """Decisions of an episode."""
    def ids(self) -> list[str]: ...
    def sizes(self) -> dict[str, int]: ...
    def resize(self, sizes: Mapping[str, int]) -> None: ...
    def signals(self) -> list[Signal]: ...
    def decide_only(self, signal: int) -> None: ...
    def reset(self, seed: int) -> None: ...
    def step(self, phases: Sequence[int]) -> bool: ...
    def phase(self, signal: int) -> int: ...
    def observe(self, signal: int) -> Observation: ...
    def idqn(self, signal: int) -> NDArray[np.float32]: ...
    def mplight(self, signal: int) -> NDArray[np.float32]: ...
    def wait(self, signal: int) -> float: ...
    def pressure(self, signal: int) -> float: ...
    def finish(self) -> dict[str, float]: ...
    def close(self) -> None: ...

class Lesson:
    """The class's end of a training."""

    @property
    def decisions(self) -> int: ...
    def reset(self) -> Observation: ...
    def step(self, phases: Any) -> tuple[Observation, bool]: ...
    def finish(self) -> float: ...
    def validate(self) -> bool: ...
    def log(self, name: str, value: float) -> None: ...
    def signals(self) -> list[Signal]: ...
    def sizes(self) -> dict[str, int]: ...
    def observe(self, signal: int) -> Observation: ...
    def idqn(self, signal: int) -> NDArray[np.float32]: ...
    def mplight(self, signal: int) -> NDArray[np.float32]: ...
    def wait(self, signal: int) -> float: ...
    def pressure(self, signal: int) -> float: ...

def run_command(args: Sequence[str], start: Sequence[str]) -> int:
    """Runs the command, once in a process, and returns its exit code."""

def family(scenario: str, settings: Sequence[str]) -> dict[str, Any]:
    """Returns the family of a scenario."""

def published(run: tuple[str, str, str], settings: str) -> str:
    """Returns the published results, as JSON, with which a run of a scenario, version and simulator can be compared."""

def sample(given: Mapping[str, Any], sampling: str, budget: int, seed: int) -> str:
    """Chooses point MDPs; returns the sample as JSON."""

def difference(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the numbers of the difference of two estimates from the same sample, the second less the first."""

def estimate(given: Mapping[str, Any], plan: str, measured: Mapping[str, Any]) -> dict[str, Any]:
    """Returns the estimate of a method's overall performance over a family."""


def stack_in(file: int) -> None:
    """Says that the interpreter writes where it is into this open file when it gets USR2."""

def sumo_built_with() -> tuple[str, str]:
    """Where libsumo came from when this was built, and where it was."""

def sumo_found(library: str | PathLike[str] | None, missing: str | None) -> None:
    """Says where libsumo is, or why it is nowhere and what to do."""
