"""tf.benchmark: every kind of policy, and its place among what is published."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import tsc_family as tf
from tsc_family._benchmark import Benchmark, _published
from tsc_family._policy import Trained

SCRIPT = """
import numpy as np, tsc_family as tf

class First:
    def __init__(self, phase=0): self.phase = phase
    def predict(self, seen): return np.array(self.phase), None

class Own(tf.Controller):
    def act(self, obs): return [0]

def trained(env):
    obs, _ = env.reset()
    assert env.total_steps == 2 * 30 and env.action_masks().all()
    over = False
    while not over:
        obs, _, _, over, _ = env.step(0)
    return First()

if __name__ == "__main__":
    small = dict(smoke=True, networks=%r, quiet=True)
    import script
    found = [tf.benchmark(script.First(), name="object", **small), tf.benchmark(trained, **small), tf.benchmark(Own, **small)]
    print([(f.name, round(f.score, 6)) for f in found])
    print(found[0])
"""


def test_an_object_a_function_and_a_controller_that_do_the_same_score_the_same(tmp_path, networks):
    (tmp_path / "script.py").write_text(SCRIPT % networks)
    done = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    first, *rest = done.stdout.splitlines()
    scores = dict(eval(first))
    assert set(scores) == {"object", "trained", "own"} and len(set(scores.values())) == 1 and scores["own"] > 0
    assert "Nothing is compared: no scores of smoke" in done.stdout and "Report: " in rest[-1]


@pytest.mark.parametrize(
    ("policy", "words"),
    [("model.zip", "give a .safetensors file"), (3, "has neither act"), (lambda env: None, "no function at the top level")],
)
def test_what_is_no_policy_is_said(tmp_path, policy, words):
    with pytest.raises(tf.Error, match=words):
        tf.benchmark(policy, "smoke", out=tmp_path / "out")


@pytest.mark.parametrize("answer", [99, -1, 0.7, None, [0, 1]])
def test_an_answer_that_is_no_phase_is_refused(answer):
    def act(answer, **known):
        policy = Trained.__new__(Trained)
        policy.observation, policy.policy = "idqn", SimpleNamespace(predict=lambda seen: answer, **known)
        policy.begin([SimpleNamespace(id="c", phases=[0, 1])])
        return policy.act(SimpleNamespace(idqn=lambda index: np.zeros((2, 5)), phase=[1]))

    with pytest.raises(tf.Error, match="for signal c; a phase is a whole number from 0 to 1"):
        act(answer)
    assert act((np.array(0), None)) == [0]
    # Of a policy that was trained with padded spaces a padded action keeps the phase.
    assert act(3, action_space=SimpleNamespace(n=4)) == [1]


PUBLISHED = Path(__file__).parents[2] / "data/published/salt-lake-city-resco.json"
IDENTITY = {"scenario": "salt-lake-city", "simulator": "SUMO 1.15.0", "tsc_family": "", "settings": {"preset": "resco"}}


def test_published_rows_are_those_of_equal_settings_and_version():
    file = json.loads(PUBLISHED.read_text())
    same = {**IDENTITY, "tsc_family": file["version"], "settings": {**file["settings"], "idqn": {"gamma": 0.5}}}
    rows, why = _published(same)
    assert why == "" and {"fixed-time", "mplight-star", "nema"} <= {row["method"] for row in rows}
    other = {**same, "settings": {**same["settings"], "signal": {**file["settings"]["signal"], "delta_time_s": 5}}}
    assert _published(other)[1] == "published scores have other settings (signal.delta_time_s)"
    assert "version" in _published({**same, "tsc_family": "0.0.1"})[1]
    assert _published({**same, "scenario": "mine"})[0] == []


def test_places_follow_from_intervals():
    found = Benchmark.__new__(Benchmark)
    found.score, found.interval = 0.50, (0.47, 0.53)
    row = {"method": "a", "low": 0.53, "score": 0.56, "high": 0.59}
    assert found._side(row) == 1 and math.hypot(0.03, 0.03) < 0.06
    assert found._side({**row, "low": 0.50, "score": 0.54, "high": 0.58}) == 0
    assert found._side({**row, "low": 0.40, "score": 0.42, "high": 0.44}) == -1
