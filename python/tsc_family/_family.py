"""Families, samples of them and estimates, on whatever numbers you have: no traffic needed, and no SUMO."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._native import Error

Settings = Mapping[str, Any]
"""Settings to replace, by dotted name or by section: ``{"demand.horizon_s": 600}``, ``{"demand": {"horizon_s": 600}}``."""

_TOLERANCE = 1e-6
_RESAMPLES = 2000


def flags(settings: Settings | None, preset: str | None = None) -> list[str]:
    """Returns settings as the command's ``--set`` has them, the preset first."""

    def text(value: Any) -> str:
        return value if isinstance(value, str) else json.dumps(value)

    def flat(settings: Settings, section: str) -> Iterator[tuple[str, Any]]:
        for key, value in settings.items():
            if isinstance(value, Mapping):
                yield from flat(value, f"{section}{key}.")
            else:
                yield f"{section}{key}", value

    if not isinstance(settings, (Mapping, type(None))):
        raise Error(f"settings={settings!r}: give names and values, such as {{'demand.horizon_s': 600}}")
    named = [] if preset is None else [f"preset={preset}"]
    return named + [f"{key}={text(value)}" for key, value in flat(settings or {}, "")]


@dataclass(frozen=True, eq=False)
class Family:
    """Point MDPs with features and an importance that sums to 1.

    Of a scenario (:func:`family`), or your own: ``Family(features, importance)`` with an array of shape
    ``[points, features]`` and one of shape ``[points]``.
    """

    features: NDArray[np.float64]
    """Context features, shape ``[points, features]``."""
    importance: NDArray[np.float64]
    """Probability of every point MDP, shape ``[points]``; sums to 1."""
    points: list[str] = field(default_factory=list)
    """Ids; ``p0``, ``p1``, ... where none are given."""
    feature_names: list[str] = field(default_factory=list)
    """Names of the features; ``x0``, ``x1``, ... where none are given."""
    feature_units: list[str] = field(default_factory=list)
    """Their units, empty for counts."""
    titles: list[str] = field(default_factory=list)
    """What people call the point MDPs; their ids where they have no other names."""
    instances: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """How many real instances every point MDP stands for."""
    describing: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 0)))
    """What samples are spread over where features do not describe the points, shape ``[points, columns]``, or empty."""
    name: str = "family"
    """Name of the family."""

    def __post_init__(self) -> None:
        features = np.asarray(self.features, dtype=np.float64)
        if features.ndim == 1:
            features = features[:, None]
        if features.ndim != 2 or len(features) == 0:
            raise Error(f"features have shape {features.shape}; give [points, features]")
        importance = np.asarray(self.importance, dtype=np.float64)
        if importance.shape != (len(features),):
            raise Error(f"importance has shape {importance.shape}; give one number for each of {len(features)} points")
        if not np.isfinite(features).all() or not np.isfinite(importance).all():
            raise Error("features and importance must be finite numbers")
        if (importance < 0).any():
            first = int(np.flatnonzero(importance < 0)[0])
            raise Error(f"the importance of point {first} is {importance[first]:g}; nothing is below 0")
        total = float(importance.sum())
        if abs(total - 1) > _TOLERANCE:
            raise Error(f"importance sums to {total:g}, not to 1; divide by the sum")
        count, width = features.shape
        points = [str(p) for p in self.points] or [f"p{i}" for i in range(count)]
        names = list(self.feature_names) or [f"x{i}" for i in range(width)]
        instances = np.asarray(self.instances, dtype=np.int64)
        values: dict[str, Any] = {
            "features": features,
            "importance": importance / total,
            "points": points,
            "feature_names": names,
            "feature_units": list(self.feature_units) or [""] * width,
            "titles": list(self.titles) or points,
            "instances": instances if instances.size else np.ones(count, dtype=np.int64),
            "describing": np.asarray(self.describing, dtype=np.float64),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)
        for name, wanted in [("points", count), ("titles", count), ("feature_names", width), ("feature_units", width)]:
            if len(values[name]) != wanted:
                raise Error(f"{len(values[name])} {name} for {wanted}")
        if len(set(points)) != count:
            raise Error("two point MDPs have the same id")
        if self.describing.size and len(self.describing) != count:
            raise Error(f"describing has {len(self.describing)} rows for {count} points")

    def __len__(self) -> int:
        return len(self.points)

    def __repr__(self) -> str:
        return f"Family({self.name!r}, {len(self)} point MDPs, features {', '.join(self.feature_names)})"

    def index(self, point: str) -> int:
        """Returns the position of a point MDP by its id, or else by what people call it."""
        for names in (self.points, self.titles):
            if point in names:
                return names.index(point)
        raise Error(f"family {self.name!r} has no point MDP {point!r}")

    def _given(self, known: Mapping[str, ArrayLike]) -> dict[str, Any]:
        return {
            "name": self.name,
            "points": self.points,
            "titles": self.titles,
            "features": self.features.tolist(),
            "feature_names": self.feature_names,
            "feature_units": self.feature_units,
            "importance": self.importance.tolist(),
            "instances": self.instances.tolist(),
            "describing": self.describing.tolist() if self.describing.size else [],
            "known": [(name, _of_all(name, scores, len(self))) for name, scores in known.items()],
        }


def _of_all(name: str, scores: ArrayLike, count: int) -> list[float]:
    values = np.asarray(scores, dtype=np.float64)
    if values.shape != (count,) or not np.isfinite(values).all():
        raise Error(f"known scores of {name!r} have shape {values.shape}; give a finite number for each of {count} points")
    return list(values.tolist())


@dataclass(frozen=True, eq=False)
class Sample:
    """The point MDPs that were chosen from a family, and what each stands for."""

    points: list[str]
    """Ids, in the order of the choice."""
    indices: NDArray[np.int64]
    """Their positions in the family."""
    weights: NDArray[np.float64]
    """Weight of each score in the estimate; sums to 1."""
    counts: NDArray[np.int64]
    """How often each was drawn, or for k-means the size of its cluster."""
    inclusion: NDArray[np.float64]
    """Probability to be in the sample; NaN where it is not known."""
    sampling: str
    """How they were chosen."""
    family: Family
    """What they were chosen from."""
    known: dict[str, NDArray[np.float64]]
    """Scores of cheap methods on every point MDP, over which the sample was spread."""
    plan: str
    """The same as JSON, as ``manifest.json`` has it."""

    def __len__(self) -> int:
        return len(self.points)

    def __repr__(self) -> str:
        return f"Sample({len(self)} of {len(self.family)} point MDPs, {self.sampling})"


@dataclass(frozen=True, eq=False)
class Estimate:
    """An estimate of a method's performance over a whole family, with its interval."""

    value: float
    """The estimate: the mean score, weighted by importance."""
    interval: tuple[float, float] | None
    """Its interval, or None where the spread cannot be estimated, as from one number per point on a whole family."""
    level: float
    """Share of such intervals that hold what they are of, such as 0.95."""
    estimator: str
    """Name of the estimator: M1, M2, M3, balanced, BQ or all."""
    assumptions: str
    """What must hold for the interval to be one."""
    resamples: NDArray[np.float64]
    """Estimates from resampled data; empty where there is no interval."""
    centre: float
    """Of what the resamples are; another estimate than ``value`` for some estimators."""
    degrees: float | None
    """Degrees of freedom of the mean over few seeds, where these alone make the spread."""
    stretch: float
    """By which factor the interval is wider than the resamples, because seeds are few."""
    missing: int = 0
    """Point MDPs of the sample that have no score, and are taken as missing at random."""

    def __repr__(self) -> str:
        low_high = "no interval" if self.interval is None else f"{self.interval[0]:.4g} to {self.interval[1]:.4g}"
        return f"Estimate({self.value:.4g}, {self.level:.0%}: {low_high}, {self.estimator})"

    def difference(self, other: Estimate) -> Estimate:
        """Returns ``other - self``, resample by resample: of two methods on one sample, which share their draws."""
        if self.estimator != other.estimator or len(self.resamples) != len(other.resamples):
            raise Error("a difference is of two estimates from the same sample")
        first, second = ({**vars(e), "resamples": e.resamples.tolist()} for e in (self, other))
        numbers = _native.difference(first, second)
        missing = max(self.missing, other.missing)
        return Estimate(**numbers, estimator=self.estimator, assumptions=self.assumptions, missing=missing)


def family(scenario: str = "salt-lake-city", *, preset: str | None = None, settings: Settings | None = None) -> Family:
    """Returns the family of a scenario: a name that the package carries, or a path.

    Carried are ``salt-lake-city``, ``salt-lake-city-peak``, ``smoke``, ``cartpole``, ``pendulum``,
    ``mountain-car``, ``acrobot``, ``pendulum-swing-up``, ``quad``, ``half-cheetah`` and ``swimmer``.
    """
    of = _native.family(scenario, flags(settings, preset))
    count = len(of["points"])
    features = np.asarray(of["features"], dtype=np.float64).reshape(count, len(of["feature_names"]))
    return Family(**{**of, "features": features})


def sample(
    family: Family | str,
    budget: int,
    sampling: str = "balanced",
    *,
    seed: int = 0,
    known: Mapping[str, ArrayLike] | None = None,
) -> Sample:
    """Chooses ``budget`` point MDPs of a family.

    ``sampling`` is ``balanced``, ``bayesian-quadrature``, ``k-means`` (M3), ``with-replacement`` (M1),
    ``without-replacement`` (M2) or ``all``. ``known`` has scores of cheap methods on every point MDP: a balanced sample and
    one by Bayesian quadrature are then spread over them too. The same seed chooses the same
    points, as ``tsc-family run --sampling ... --seed`` does.
    """
    family = _as_family(family)
    known = dict(known or {})
    if known and sampling not in ("balanced", "bayesian-quadrature"):
        raise Error(f"known scores have no effect with {sampling}; leave them out, or use balanced or bayesian-quadrature")
    plan = _native.sample(family._given(known), sampling, int(budget), int(seed))
    draws = json.loads(plan)["draws"]
    points = [draw["point"] for draw in draws]
    return Sample(
        points=points,
        indices=np.array([family.index(point) for point in points], dtype=np.int64),
        weights=np.array([draw["weight"] for draw in draws]),
        counts=np.array([draw["count"] for draw in draws], dtype=np.int64),
        inclusion=np.array([draw.get("inclusion", np.nan) for draw in draws], dtype=np.float64),
        sampling=sampling,
        family=family,
        known={name: np.asarray(scores, dtype=np.float64) for name, scores in known.items()},
        plan=plan,
    )


def _as_family(of: Family | str) -> Family:
    return family(of) if isinstance(of, str) else of


Scores = Union[ArrayLike, Mapping[str, ArrayLike]]
"""Per point MDP of the sample a number, one per seed, or one per replicate and seed; or the same by id."""


def estimate(
    scores: Scores,
    sample: Sample,
    *,
    baseline: Scores | None = None,
    name: str = "method",
    resamples: int = _RESAMPLES,
    seed: int = 0,
) -> Estimate:
    """Returns the estimate of a method's mean score over the whole family, from its scores on a sample.

    ``scores`` has shape ``[n]``, ``[n, seeds]`` or ``[n, replicates, seeds]`` in the order of ``sample.points``, or is
    a mapping from ids to such values. What is NaN or missing counts as missing at random; a warning says how much that is,
    and so does :attr:`Estimate.missing`. With ``baseline``, of one of these shapes and on the same seeds, every score is
    divided by it; of several replicates by their mean for each seed. For differences between methods, use one
    sample and one seed: :meth:`Estimate.difference`.
    """
    rows = _rows(scores, sample, "scores")
    against = _rows(baseline, sample, "baseline") if baseline is not None else {}
    points = [point for point in sample.points if point in rows and (baseline is None or point in against)]
    if not points:
        raise Error("no point MDP of the sample has a score")
    missing = len(sample.points) - len(points)
    if missing:
        warnings.warn(
            f"{missing} of {len(sample.points)} point MDPs have no score and are taken as missing at random, which flatters a "
            f"method that fails where it is bad",
            stacklevel=2,
        )
    of_method, of_baseline = [], []
    for point in points:
        values = rows[point]
        divisor = against[point].mean(axis=0) if point in against else np.ones(values.shape[1])
        if len(divisor) != values.shape[1]:
            raise Error(f"{point}: {values.shape[1]} seeds, but {len(divisor)} of the baseline")
        of_method.append(values.tolist())
        of_baseline.append(divisor.tolist())
    measured = {
        "name": name,
        "points": points,
        "scores": of_method,
        "baseline": of_baseline,
        "resamples": int(resamples),
        "seed": int(seed),
    }
    return Estimate(**_native.estimate(sample.family._given(sample.known), sample.plan, measured), missing=missing)


def _rows(scores: Scores, sample: Sample, what: str) -> dict[str, NDArray[np.float64]]:
    """Returns the finite numbers of each point, shape ``[replicates, seeds]``."""
    if isinstance(scores, Mapping):
        unknown = set(scores) - set(sample.points)
        if unknown:
            raise Error(f"{what}: {sorted(unknown)[0]!r} is not in the sample")
        given = {point: np.asarray(value, dtype=np.float64) for point, value in scores.items()}
    else:
        array = np.asarray(scores, dtype=np.float64)
        if array.ndim not in (1, 2, 3) or len(array) != len(sample):
            raise Error(f"{what} have shape {array.shape}; give one row for each of {len(sample)} points of the sample")
        given = dict(zip(sample.points, array))
    rows = {}
    for point, value in given.items():
        if value.ndim > 2:
            raise Error(f"{what}: {point!r} has shape {value.shape}; give [seeds] or [replicates, seeds]")
        row = np.atleast_2d(value)
        finite = np.isfinite(row)
        if finite.all() and row.size:
            rows[point] = row
        elif finite.any():
            raise Error(f"{what}: {point!r} has some numbers and some NaN; leave the point out, or give all")
    return rows
