"""Families, samples and estimates, also of what is no traffic."""

import numpy as np
import pytest

import tsc_family as tf


def test_the_carried_family_has_arrays_with_names_and_units():
    family = tf.family("salt-lake-city")
    assert (len(family), family.features.shape) == (164, (164, 6))
    assert family.feature_names[:2] == ["lanes", "speed_mph"] and family.importance.sum() == pytest.approx(1)
    assert family.feature_units[1] == "mph" or family.feature_units[1]
    assert family.instances.sum() == 282
    assert family.index(family.points[3]) == 3


def test_a_sample_is_that_of_the_command(tsc_family, tmp_path):
    sample = tf.sample("salt-lake-city", 20, seed=3)
    out = tsc_family("run", "--budget", "20", "--sampling", "balanced", "--seed", "3", "--dry-run", "--json")
    assert out.returncode == 0, out.stderr
    import json

    draws = [json.loads(line) for line in out.stdout.splitlines()]
    assert [d["point"] for d in draws] == sample.points
    assert [d["weight"] for d in draws] == list(sample.weights)


@pytest.mark.parametrize("sampling", ["balanced", "bayesian-quadrature", "k-means", "with-replacement", "without-replacement"])
def test_an_estimate_of_no_traffic_at_all_holds_the_truth(sampling):
    rng = np.random.default_rng(0)
    features = rng.normal(size=(200, 2))
    importance = rng.random(200)
    family = tf.Family(features, importance / importance.sum(), feature_names=["a", "b"])
    scores = 1 + 0.3 * features[:, 0] + 0.1 * features[:, 1] ** 2
    sample = tf.sample(family, 60, sampling, seed=1)
    estimate = tf.estimate(scores[sample.indices], sample)
    truth = float(family.importance @ scores)
    assert estimate.interval[0] < truth < estimate.interval[1]
    assert abs(estimate.value - truth) < 0.2 and estimate.assumptions


def test_the_order_of_points_is_the_user_s_own():
    family = tf.Family([[1.0], [2.0], [3.0]], [0.1, 0.3, 0.6], points=["x", "y", "z"])
    sample = tf.sample(family, 3, "all")
    by_id = tf.estimate({"x": 1.0, "y": 2.0, "z": 3.0}, sample)
    by_row = tf.estimate(np.array([1.0, 2.0, 3.0])[sample.indices], sample)
    assert by_id.value == by_row.value == pytest.approx(0.1 + 0.6 + 1.8)
    assert by_id.interval is None or by_id.interval[0] == by_id.interval[1] or by_id.estimator == "all"


def test_a_sample_is_spread_over_known_scores():
    rng = np.random.default_rng(1)
    features = rng.normal(size=(150, 1))
    family = tf.Family(features, np.full(150, 1 / 150))
    cheap = np.exp(rng.normal(size=150) * 0.5)
    mine = cheap * 0.8 + rng.normal(size=150) * 0.01
    known = {"cheap": cheap, "other": cheap**0.9}
    quadrature = tf.sample(family, 40, "bayesian-quadrature", known=known)
    by_quadrature = tf.estimate(mine[quadrature.indices], quadrature)
    assert by_quadrature.value == pytest.approx(mine.mean(), abs=0.02)
    sample = tf.sample(family, 40, seed=2, known=known)
    assert abs(tf.estimate(mine[sample.indices], sample).value - mine.mean()) < 0.05


def test_scores_are_divided_by_a_baseline_and_differences_are_paired():
    family = tf.Family(np.arange(30.0), np.full(30, 1 / 30))
    sample = tf.sample(family, 10)
    rng = np.random.default_rng(3)
    baseline = rng.uniform(20, 40, (10, 5))
    half = tf.estimate(baseline / 2, sample, baseline=baseline)
    assert half.value == pytest.approx(0.5)
    a = tf.estimate(baseline * 0.7 + rng.normal(size=(10, 5)), sample, baseline=baseline, name="a")
    gap = a.difference(half)
    assert gap.value == pytest.approx(0.5 - a.value) and gap.interval[1] < 0


def test_a_baseline_of_several_replicates_is_their_mean():
    family = tf.Family(np.arange(30.0), np.full(30, 1 / 30))
    sample = tf.sample(family, 10)
    baseline = np.random.default_rng(3).uniform(20, 40, (10, 3, 5))
    by_all = tf.estimate(baseline, sample, baseline=baseline)
    assert by_all.value == pytest.approx(1)
    by_mean = tf.estimate(baseline, sample, baseline=baseline.mean(axis=1))
    assert by_all.value == pytest.approx(by_mean.value)


def test_a_difference_is_as_wide_as_few_seeds_make_it():
    family = tf.Family(np.arange(3.0), np.full(3, 1 / 3))
    sample = tf.sample(family, 3, "all")
    rng = np.random.default_rng(3)
    one, other = (tf.estimate(rng.uniform(1, 2, (3, 2)), sample, name=name) for name in ("one", "other"))
    assert one.stretch > 1.2
    gap = one.difference(other)
    low, high = np.quantile(gap.resamples, [0.025, 0.975])
    assert gap.interval[1] - gap.interval[0] > 1.2 * (high - low)
    assert gap.interval[0] <= gap.value <= gap.interval[1]


def test_missing_scores_are_left_out():
    family = tf.Family(np.arange(10.0), np.full(10, 0.1))
    sample = tf.sample(family, 10, "all")
    scores = np.arange(10.0)
    scores[4] = np.nan
    with pytest.warns(UserWarning, match="1 of 10 point MDPs have no score"):
        estimate = tf.estimate(scores[sample.indices], sample)
    assert estimate.value == pytest.approx((45 - 4) / 9) and estimate.missing == 1


@pytest.mark.parametrize(
    ("act", "words"),
    [
        (lambda: tf.Family([[1.0]], [0.5]), "importance sums to 0.5"),
        (lambda: tf.Family([[1.0], [2.0], [3.0]], [1.0, -1.0, 1.0]), "the importance of point 1 is -1"),
        (lambda: tf.Family([[1.0], [2.0]], [1.0]), "one number for each of 2 points"),
        (lambda: tf.Family([[np.nan]], [1.0]), "finite"),
        (lambda: tf.sample("smoke", 3), "the family has 2 point MDPs"),
        (lambda: tf.sample("smoke", 1, "clever"), "sampling"),
        (lambda: tf.family("smok"), "did you mean smoke"),
        (lambda: tf.estimate([1.0], tf.sample("smoke", 2)), "one row for each of 2"),
        (lambda: tf.estimate({"nowhere": 1.0}, tf.sample("smoke", 2)), "is not in the sample"),
        (lambda: tf.estimate([np.nan, np.nan], tf.sample("smoke", 2)), "no point MDP of the sample has a score"),
        (lambda: tf.sample("smoke", 1, "k-means", known={"a": [1, 2]}), "no effect with k-means"),
    ],
)
def test_what_is_wrong_is_said(act, words):
    with pytest.raises(tf.Error, match=words):
        act()


def test_another_task_s_family_is_read_too():
    assert len(tf.family("cartpole")) == 576
