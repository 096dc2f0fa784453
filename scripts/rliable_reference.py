#!/usr/bin/env python3
"""Prints interquartile means, probabilities of improvement and performance profiles of made-up scores as rliable
computes them; tests/analysis/rliable.rs holds ours against them.

    scripts/rliable_reference.py [SEED] > tests/rliable/reference.json

Needs rliable 1.2.0; scripts/rliable.sh installs it. The stored file is of seed 1.
"""

import json
import sys

import numpy as np
from rliable import library, metrics

# Point MDPs of a case, and runs of either method. Few of them, numbers that four does not divide, and as many as
# the family of Salt Lake City has.
SHAPES = [(1, 1, 1), (3, 1, 2), (4, 2, 2), (5, 5, 5), (7, 3, 4), (26, 5, 5), (164, 1, 1), (164, 5, 3)]


def case(generator, tasks, runs_x, runs_y):
    # Two decimals, so that there are ties; a third of the tasks is equal for both.
    difficulty = generator.gamma(2.0, 0.4, size=tasks)
    x = np.round(difficulty * generator.uniform(0.7, 1.3, size=(runs_x, tasks)), 2)
    y = np.round(difficulty * generator.uniform(0.8, 1.2, size=(runs_y, tasks)), 2)
    y[:, ::3] = x[:1, ::3]
    means = np.mean(x, axis=0)
    taus = np.unique(np.concatenate([means, np.linspace(0.0, 2.0, 9)]))
    profiles, _ = library.create_performance_profile(
        {"x": x}, taus, use_score_distribution=False, reps=1
    )
    runs, _ = library.create_performance_profile({"x": x}, taus, reps=1)
    return {
        "x": x.tolist(),
        "y": y.tolist(),
        "mean_scores": means.tolist(),
        "aggregate_iqm": float(metrics.aggregate_iqm(means[None, :])),
        "aggregate_iqm_of_runs": float(metrics.aggregate_iqm(x)),
        "probability_of_improvement": float(metrics.probability_of_improvement(x, y)),
        "taus": taus.tolist(),
        "profile": profiles["x"].tolist(),
        "profile_of_runs": runs["x"].tolist(),
    }


def main():
    generator = np.random.default_rng(int(sys.argv[1]) if len(sys.argv) > 1 else 1)
    cases = [case(generator, *shape) for shape in SHAPES]
    print("[\n" + ",\n".join(json.dumps(case) for case in cases) + "\n]")


if __name__ == "__main__":
    main()
