"""Places that are simulated in this process."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from os import PathLike, fspath
from typing import Union

from . import _native, _sumo
from ._family import Settings, flags
from ._native import Error

Path = Union[str, "PathLike[str]"]

_LARGEST_SEED = 2**31 - 1


@dataclass(frozen=True)
class Where:
    """What is the same for all places of an environment."""

    scenario: str = "salt-lake-city"
    preset: str | None = None
    settings: Settings | None = None
    networks: Path | None = None

    def place(self, point: str | None, sumocfg: Path | None) -> _native.Simulation:
        """Returns the simulation of a place; its network is built if it is missing."""
        if (point is None) == (sumocfg is None):
            raise Error('give either point="..." of a scenario or sumocfg="..."')
        _sumo.find()
        return _native.Simulation(
            point,
            None if sumocfg is None else fspath(sumocfg),
            fspath(self.scenario),
            flags(self.settings, self.preset),
            None if self.networks is None else fspath(self.networks),
        )


def sizes(
    points: Iterable[str],
    *,
    scenario: str = "salt-lake-city",
    preset: str | None = None,
    settings: Settings | None = None,
    networks: Path | None = None,
) -> dict[str, int]:
    """Returns the room that these point MDPs need, for environments whose spaces are equal over all of them.

    Networks that are missing are built, which takes about half a second for each.
    """
    where = Where(scenario, preset, settings, networks)
    room: dict[str, int] = {}
    for point in points:
        for name, size in where.place(point, None).sizes().items():
            room[name] = max(size, room.get(name, 0))
    if not room:
        raise Error("no point MDPs are given")
    return room


def check_seed(seed: int) -> int:
    """Returns a seed that SUMO takes."""
    if not 0 <= seed <= _LARGEST_SEED:
        raise Error(f"seed {seed}: SUMO takes seeds from 0 to {_LARGEST_SEED}")
    return int(seed)
