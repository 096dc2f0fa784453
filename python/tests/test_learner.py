"""Learners of the library with a reward or an observation of a class, and models of classes played elsewhere."""

import csv
import json

import pytest

import tsc_family as tf

HEAD = "import numpy as np, tsc_family as tf\n"

CLASSES = HEAD + """
class Paid(tf.Learner):
    "IDQN that is paid -1 per interval."
    def reward(self, obs, signal): return -1

class Looks(tf.Learner):
    "IPPO that sees queues alone."
    method = "ippo"
    def observation(self, obs, signal):
        assert obs.lanes.shape[0] == 1 and obs.lanes.shape[1] == len(signal.lanes)
        return obs.lanes[0, :, 0] / 10

class Pressed(tf.Learner):
    "MPLight with a memory of an episode."
    method = "mplight"
    def begin(self, signals): self.last = 0.0
    def reward(self, obs, signal):
        change, self.last = obs.pressure() - self.last, obs.pressure()
        return change
"""


def first_and_rows(folder):
    for path in sorted((folder / "done").rglob("*.jsonl")):
        first, *rows = [json.loads(line) for line in path.read_text().splitlines()]
        yield first, rows


def models(folder):
    """Returns the file of each model by its method and point MDP."""
    with (folder / "report" / "models.csv").open(newline="") as file:
        return {(row["method"], row["point"]): folder / row["file"] for row in csv.DictReader(file)}


def run(tsc_family, networks, tmp_path, text, classes, *more):
    (tmp_path / "mine.py").write_text(text)
    given = [f"--controller={name.lower()}=mine.py:{name}" for name in classes]
    methods = ",".join(["baseline", *(name.lower() for name in classes)])
    return tsc_family(
        "run", "smoke", "--eval-seeds", "1", "--episodes", "2", "--set", "demand.horizon_s=120", "--methods", methods,
        "--networks", networks, "--out", "out", *given, *more,
    )  # fmt: skip


def test_a_learner_has_another_reward_or_observation(tsc_family, networks, tmp_path):
    done = run(tsc_family, networks, tmp_path, CLASSES, ["Paid", "Looks", "Pressed"], "--set", "idqn.hidden=8")
    assert done.returncode == 0, done.stderr
    seen = set()
    for first, rows in first_and_rows(tmp_path / "out"):
        training = [row["metrics"] for row in rows if row["kind"] == "training"]
        if first["method"] == "baseline":
            continue
        seen.add(first["method"])
        assert first["outcome"] == "ok" and len(training) == 2
        if first["method"] == "paid":
            # 120 s in intervals of 10 s.
            assert [row["return"] for row in training] == [-12.0, -12.0]
        else:
            assert all(row["return"] != -12.0 for row in training)
    assert seen == {"paid", "looks", "pressed"}
    identity = json.loads((tmp_path / "out" / "manifest.json").read_text())["identity"]
    learners = {own["name"]: own["learner"] for own in identity["controllers"]}
    assert learners == {"paid": "idqn", "looks": "ippo", "pressed": "mplight"}

    # The models are played again with the class beside them, and only so.
    for name in learners:
        alone = tsc_family("run", "smoke", "--model", f"saved={models(tmp_path / 'out')[name, 'busy']}", "--dry-run")
        assert alone.returncode == 2 and f"--controller {name}=FILE.py:CLASS" in alone.stderr


def test_a_learner_goes_on_where_another_build_on_it_has_read_its_settings(tsc_family, networks, tmp_path):
    more = ["--set", "idqn.hidden=8"]
    assert run(tsc_family, networks, tmp_path, CLASSES, ["Paid"], *more).returncode == 0
    given = ["--controller", "paid=mine.py:Paid", "--networks", networks, "--out", "out"]
    base = ["run", "smoke", "--eval-seeds", "1", "--episodes", "2", "--set", "demand.horizon_s=120"]
    added = [*base, "--methods", "baseline,paid,idqn", *given]
    other = tsc_family(*added, "--set", "idqn.hidden=16")
    assert other.returncode == 5 and "idqn" in other.stderr, other.stderr
    same = tsc_family(*added, *more)
    assert same.returncode == 0, same.stderr


def test_a_model_of_a_class_is_played_elsewhere(tsc_family, networks, tmp_path):
    text = HEAD + """
class Own(tf.Controller):
    def __init__(self): self.phase = 0
    def train(self, env):
        for phase in (0, 1):
            _, done = env.reset(), False
            while not done: _, done = env.step([phase])
        self.phase = 1
    def act(self, obs): return [self.phase]
    def save(self, path): np.save(path + ".npy", self.phase)
    def load(self, path): self.phase = int(np.load(path + ".npy"))
"""
    done = run(tsc_family, networks, tmp_path, text, ["Own"])
    assert done.returncode == 0, done.stderr
    played = tsc_family("evaluate", "--from", "out", "--out", "moved", "--networks", networks, "--controller", "own=mine.py:Own")
    assert played.returncode == 0, played.stderr
    rows = list(csv.DictReader((tmp_path / "moved" / "transfer" / "transfer.csv").open(newline="")))
    assert len(rows) == 4
    home = [row for row in rows if row["trained_on"] == row["evaluated_on"]]
    assert len(home) == 2 and all(row["score"] == row["own_training"] for row in home)


def test_models_are_methods_of_an_evaluation(tsc_family, networks, tmp_path, monkeypatch):
    done = run(tsc_family, networks, tmp_path, CLASSES, ["Paid"])
    assert done.returncode == 0, done.stderr
    monkeypatch.chdir(tmp_path)
    options = {"eval_seeds": 1, "episodes": 2, "settings": {"demand": {"horizon_s": 120}}, "networks": networks, "quiet": True}
    model = models(tmp_path / "out")["paid", "busy"]
    with pytest.warns(UserWarning, match="some tasks failed"):
        # It was trained on busy, and quiet has other lanes.
        result = tf.evaluate("paid=mine.py:Paid", "smoke", models={"saved": model}, out="models", **options)
    rows = list(csv.DictReader((result.folder / "report" / "scores.csv").open(newline="")))
    scores = {(row["method"], row["point"]): row["delay_s"] for row in rows}
    assert scores["saved", "busy"] == scores["paid", "busy"] != ""
    with pytest.raises(tf.Error, match="give names and files"):
        tf.evaluate("paid=mine.py:Paid", "smoke", models=model, out="x", **options)


# What a class is written like, the exit code, and what is said.
WRONG = {
    "numbers that are none": ("    def reward(self, obs, signal): return float('nan')\n", "reward() returned NaN for signal"),
    "no number": ("    def reward(self, obs, signal): pass\n", "reward() returned None; return a number"),
    "an error": ("    def reward(self, obs, signal): return 1 / 0\n", "ZeroDivisionError"),
    "another width": (
        "    def observation(self, obs, signal): return np.zeros(3 + (obs.lanes.sum() > 0))\n",
        "observation() returned 4 numbers for signal",
    ),
    "a text": ("    def observation(self, obs, signal): return 'busy'\n", "observation() returned 'busy'; return an array"),
    "nothing to see": ("    def observation(self, obs, signal): return []\n", "observation() returned no number"),
    "an observation for FRAP": (
        "    method = 'mplight'\n    def observation(self, obs, signal): return obs.mplight()\n",
        "only its reward can be replaced",
    ),
}


@pytest.mark.parametrize("what", WRONG)
def test_what_a_class_gets_wrong_is_in_the_record(tsc_family, networks, tmp_path, what):
    body, words = WRONG[what]
    done = run(tsc_family, networks, tmp_path, f"{HEAD}class Mine(tf.Learner):\n{body}", ["Mine"])
    assert done.returncode == 3, done.stderr
    reasons = [first["reason"] for first, _ in first_and_rows(tmp_path / "out") if first["method"] == "mine"]
    assert len(reasons) == 2 and all(words in reason for reason in reasons), reasons


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("    pass\n", "Mine replaces nothing of idqn"),
        ("    method = 'dqn'\n    def reward(self, obs, signal): return 0\n", "\"dqn\" is no learner of this library"),
        ("    def reward(self, obs, signal): return 0\n    def act(self, obs): return [0]\n", "Mine.act would never be called"),
    ],
)
def test_a_class_that_is_no_learner_is_refused(tsc_family, networks, tmp_path, body, words):
    done = run(tsc_family, networks, tmp_path, f"{HEAD}class Mine(tf.Learner):\n{body}", ["Mine"])
    assert done.returncode == 2 and words in done.stderr, done.stderr
    assert not (tmp_path / "out").exists()
