"""Controllers of one's own, evaluated from a script: same results however they are run."""

import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import tsc_family as tf

# The example, on ``smoke``, without a guard for the main module.
SCRIPT = """
import numpy as np, tsc_family as tf

class Longest(tf.Controller):
    "The phase with the most vehicles that have halted."
    name = "longest-queue"
    def begin(self, signals):
        self.serves = [s.phase_lanes for s in signals]
    def act(self, obs):
        return [int((m * o[:, 0]).sum(1).argmax()) for m, o in zip(self.serves, obs.lanes)]

result = tf.evaluate(Longest(), "smoke", budget=2, eval_seeds=2, against=["max-pressure", "fixed-time"],
                     settings={"demand.horizon_s": 300}, networks=%r, out="results/longest")
print(result.table())
print(sorted(result.scores()["method"].unique()), result.summary()["method"].tolist())
print(result.report())
"""


def python(text: str, folder: Path, *, name: str = "script.py", timeout: float = 180) -> subprocess.CompletedProcess:
    (folder / name).write_text(text)
    return subprocess.run(
        [sys.executable, name], cwd=folder, capture_output=True, text=True, timeout=timeout, stdin=subprocess.DEVNULL
    )


def done_files(folder: Path) -> dict[str, list[str]]:
    """Returns the records without what is of the clock."""
    files = {}
    for path in sorted((folder / "done").rglob("*.jsonl")):
        first, *rows = path.read_text().splitlines()
        summary = json.loads(first)
        for name in ("wall", "checksum", "sha256"):
            summary.pop(name, None)
        files[path.name] = [json.dumps(summary, sort_keys=True), *rows]
    return files


def test_the_example_runs_line_by_line(tmp_path, networks):
    done = python(SCRIPT % networks, tmp_path)
    assert done.returncode == 0, done.stderr
    assert "longest-queue" in done.stdout and "max-pressure" in done.stdout
    assert "['baseline', 'fixed-time', 'longest-queue', 'max-pressure']" in done.stdout
    page = tmp_path / done.stdout.splitlines()[-1]
    assert "longest-queue" in page.read_text() and "most vehicles that have halted" in (
        page.read_text() + (tmp_path / "results/longest/manifest.json").read_text()
    )
    about = json.loads((tmp_path / "results/longest/manifest.json").read_text())
    own = (about.get("identity") or about)["controllers"][0]
    assert own["name"] == "longest-queue" and set(own["sha256"]) == {"script.py"}
    assert {"python", "numpy"} <= set(own["versions"])


def test_a_script_has_its_arguments_where_a_worker_loads_it(tmp_path, networks):
    text = (
        "import sys, tsc_family as tf\n"
        "scenario, seeds = sys.argv[1:]\n"
        "class Mine(tf.Controller):\n    def act(self, obs): return [int(seeds) - 1]\n"
        "tf.evaluate(Mine, scenario, eval_seeds=int(seeds), out='out', quiet=True, settings={'demand.horizon_s': 60},\n"
        f"            networks={networks!r})\n"
    )
    (tmp_path / "with.py").write_text(text)
    done = subprocess.run([sys.executable, "with.py", "smoke", "1"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr


def test_a_script_of_a_package_goes_on_to_evaluate_its_class(tmp_path, networks):
    package = tmp_path / "mine"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "rule.py").write_text("def phase(): return 0\n")
    (package / "script.py").write_text(
        "import tsc_family as tf\n"
        "from .rule import phase\n"
        "class Mine(tf.Controller):\n    def act(self, obs): return [phase()]\n"
        "if __name__ == '__main__': print('started')\n"
        "tf.evaluate(Mine, 'smoke', eval_seeds=1, out='out', quiet=True, settings={'demand.horizon_s': 60},\n"
        f"            networks={networks!r})\n"
    )
    done = subprocess.run([sys.executable, "-m", "mine.script"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout == "started\n", done.stderr
    own = json.loads((tmp_path / "out/manifest.json").read_text())["identity"]["controllers"][0]
    assert set(own["sha256"]) == {"mine/__init__.py", "mine/rule.py", "mine/script.py"}
    # A script that the package imports evaluates before anybody has its class.
    (package / "__init__.py").write_text("from .script import Mine\n")
    done = subprocess.run([sys.executable, "-m", "mine.script"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1
    assert "script.py, line 6, evaluates when the package mine is imported; put the evaluation below" in done.stderr
    text = (package / "script.py").read_text().replace("tf.evaluate", "if __name__ == '__main__': tf.evaluate")
    (package / "script.py").write_text(text.replace("out='out'", "out='again'"))
    done = subprocess.run([sys.executable, "-m", "mine.script"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_a_class_below_an_import_that_evaluates_is_told_where_that_is(tsc_family, tmp_path, networks):
    (tmp_path / "base.py").write_text(
        "import tsc_family as tf\n"
        "class Base(tf.Controller):\n    def act(self, obs): return [0]\n"
        "tf.evaluate(Base, 'smoke', eval_seeds=1, out='base', quiet=True, settings={'demand.horizon_s': 60},\n"
        f"            networks={networks!r})\n"
    )
    (tmp_path / "mine.py").write_text("from base import Base\nclass Mine(Base): pass\n")
    done = tsc_family("run", "smoke", "--controller", "mine=mine.py:Mine", "--networks", networks, "--out", "r")
    assert done.returncode == 2
    assert "has no class Mine at its top level above" in done.stderr and "base.py, line 4, which" in done.stderr


RULE = """
import tsc_family as tf
class Mine(tf.Controller):
    def __init__(self, every=2, weights=(1, 2)): self.every, self.turn = every, 0
    def begin(self, signals): self.count = [len(s.phases) for s in signals]
    def act(self, obs):
        self.turn += 1
        draw = int(self.rng.integers(2))
        return [(self.turn // self.every + draw) % count for count in self.count]
"""


def run_args(out: str, networks: str, *more: str) -> list[str]:
    return ["run", "smoke", "--controller", 'mine=rule.py:Mine?{"kwargs": {"every": 3}}', "--methods", "mine",
            "--eval-seeds", "2", "--set", "demand.horizon_s=300", "--networks", networks, "--out", out, *more]  # fmt: skip


def test_the_results_are_the_same_with_any_jobs_and_after_kill_and_resume(tsc_family, tmp_path, networks):
    (tmp_path / "rule.py").write_text(RULE)
    for out, jobs in [("one", "1"), ("two", "2")]:
        done = tsc_family(*run_args(out, networks, "--jobs", jobs))
        assert done.returncode == 0, done.stderr
    child = subprocess.Popen(
        [sys.executable, "-m", "tsc_family", *run_args("killed", networks, "--jobs", "1")],
        cwd=tmp_path, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    limit = time.monotonic() + 60
    while not list((tmp_path / "killed" / "done").rglob("*.jsonl")) and time.monotonic() < limit:
        time.sleep(0.02)
    child.send_signal(signal.SIGKILL)
    child.wait()
    before = len(done_files(tmp_path / "killed"))
    assert 1 <= before < 4, before
    done = tsc_family(*run_args("killed", networks))
    assert done.returncode == 0, done.stderr
    one = done_files(tmp_path / "one")
    assert len(one) == 4
    assert one == done_files(tmp_path / "two") == done_files(tmp_path / "killed")


def test_two_controllers_have_modules_of_the_same_name(tsc_family, tmp_path, networks):
    """Each is hashed with its own, and uses its own."""
    for version, phase in [("v1", 0), ("v2", 1)]:
        (tmp_path / version).mkdir()
        (tmp_path / version / "rule.py").write_text(f"def phase(): return {phase}\n")
        (tmp_path / version / "mine.py").write_text(
            "import rule, tsc_family as tf\n"
            "class Mine(tf.Controller):\n"
            "    def act(self, obs):\n"
            f"        import rule as late\n"
            f"        assert rule.phase() == late.phase() == {phase}\n"
            "        return [rule.phase()]\n"
        )
    both = [f"--controller={name}={folder}/mine.py:Mine" for name, folder in (("a", "v1"), ("b", "v2"))]
    done = tsc_family("run", "smoke", *both, "--methods", "a,b", "--eval-seeds", "1", "--set", "demand.horizon_s=60",
                      "--networks", networks, "--out", "out", "--quiet")  # fmt: skip
    assert done.returncode == 0, done.stderr
    controllers = json.loads((tmp_path / "out/manifest.json").read_text())["identity"]["controllers"]
    assert [sorted(c["sha256"]) for c in controllers] == [["mine.py", "rule.py"]] * 2
    assert controllers[0]["sha256"]["rule.py"] != controllers[1]["sha256"]["rule.py"]


def test_a_controller_needs_no_folder_for_temporary_files(tsc_family, tmp_path, networks):
    (tmp_path / "rule.py").write_text(RULE)
    done = tsc_family(*run_args("out", networks), env={**os.environ, "TMPDIR": "/nowhere"})
    assert done.returncode == 0, done.stderr


def test_a_controller_that_has_changed_is_another_run(tsc_family, tmp_path, networks):
    (tmp_path / "rule.py").write_text(RULE)
    assert tsc_family(*run_args("out", networks)).returncode == 0
    (tmp_path / "rule.py").write_text(RULE + "# changed\n")
    done = tsc_family(*run_args("out", networks))
    assert done.returncode == 5 and "rule.py has changed" in done.stderr, done.stderr


LEARNER = """
import json, tsc_family as tf
class Mine(tf.Controller):
    "Tries both phases and keeps the better one."
    def __init__(self): self.best = 0
    def train(self, env):
        assert len(self.begun) == 1
        delays = []
        for phase in range(2):
            obs, done = env.reset(), False
            assert obs.lanes.shape[0] == len(env.signals) == 1
            while not done:
                obs, done = env.step([phase])
            env.log(tried=phase, nothing=float("nan"), endless=1e120)
            delays.append(env.delay_s)
        env.reset()
        env.step([0])
        self.best = delays.index(min(delays))
    def begin(self, signals): self.begun = signals
    def act(self, obs): return [self.best]
    def save(self, path):
        # As libraries do that add an ending of their own.
        with open(path + ".json", "w") as file: json.dump(self.best, file)
    def load(self, path):
        with open(path + ".json") as file: self.best = json.load(file)
"""


def test_a_training_has_rows_with_delays_and_figures_and_a_model(evaluated, tmp_path):
    mine, done = evaluated(LEARNER)
    assert done.returncode == 0, done.stderr
    assert len(mine) == 2
    rows = []
    for path in sorted((tmp_path / "out" / "done").rglob("*.jsonl")):
        first, *lines = [json.loads(line) for line in path.read_text().splitlines()]
        if first["method"] == "mine":
            rows.append([row for row in lines if row["kind"] == "training"])
    for training in rows:
        assert [row["metrics"]["tried"] for row in training] == [0, 1]
        assert all(row["metrics"]["delay_s"] > 0 and not {"nothing", "endless"} & row["metrics"].keys() for row in training)
        assert len({row["seed"] for row in training}) == 2
    assert len(list((tmp_path / "out" / "models").rglob("*.safetensors"))) == 2


SWINGS = """
import json, tsc_family as tf
class Mine(tf.Controller):
    "Knows after its second episode to serve all phases in turn, and forgets it."
    def __init__(self): self.turns = False
    def train(self, env):
        for episode in range(4):
            obs, done = env.reset(), False
            while not done:
                obs, done = env.step([0])
            self.turns = episode == 1
            assert env.validate() is True
    def begin(self, signals): self.phase, self.count = 0, len(signals[0].phases)
    def act(self, obs):
        self.phase = (self.phase + 1) % self.count if self.turns else 0
        return [self.phase]
    def save(self, path):
        with open(path, "w") as file: json.dump(self.turns, file)
    def load(self, path):
        with open(path) as file: self.turns = json.load(file)
"""


def test_a_controller_gets_its_best_policy_back(evaluated, tmp_path):
    settings = ["demand.horizon_s=300", "training.validation_start=1", "training.validation_interval=1"]
    mine, done = evaluated(SWINGS, "Mine", *[f"--set={setting}" for setting in settings])
    assert done.returncode == 0, (done.stderr, [record.get("reason") for record in mine])
    for path in sorted((tmp_path / "out" / "done").rglob("*.jsonl")):
        first, *rows = [json.loads(line) for line in path.read_text().splitlines()]
        if first["method"] == "mine":
            assert first["metrics"]["policy_row"] == 2
            assert first["metrics"]["delay_s"] < first["metrics"]["last_delay_s"]
            kinds = [row["kind"] for row in rows]
            assert kinds.count("training") == 4 and kinds.count("last") == kinds.count("evaluation") == 1


def test_a_controller_that_cannot_be_loaded_is_evaluated_with_its_last_policy(evaluated):
    settings = ["demand.horizon_s=300", "training.validation_start=1", "training.validation_interval=1"]
    text = SWINGS.partition("    def load")[0]
    mine, done = evaluated(text, "Mine", *[f"--set={setting}" for setting in settings])
    assert done.returncode == 0, (done.stderr, [record.get("reason") for record in mine])
    assert len(mine) == 2
    for record in mine:
        assert record["metrics"]["policy_row"] == 4
        assert record["metrics"]["delay_s"] == record["metrics"]["last_delay_s"]


GYM = """
import tsc_family as tf
class Mine(tf.Controller):
    def train(self, env):
        gym = env.gym("mplight", reward="pressure")
        for _ in range(2):
            seen, info = gym.reset(seed=1)
            over, total = False, 0.0
            while not over:
                seen, reward, _, over, info = gym.step(int(seen[1:].argmax()) % gym.action_space.n)
                total += reward
            assert info["delay_s"] > 0 and gym.observation_space.contains(seen)
    def act(self, obs): return [0]
"""


def test_a_training_is_a_gymnasium_environment_too(evaluated):
    mine, done = evaluated(GYM)
    assert done.returncode == 0, (done.stderr, [record.get("reason") for record in mine])


class Plain(tf.Controller):
    """Always the first."""

    def __init__(self, phase: int = 0, table: object = None) -> None:
        self.phase = phase

    def act(self, obs):
        return [self.phase]


def test_a_class_is_named_by_file_and_arguments():
    from tsc_family._evaluate import source_of

    file = Path(__file__).absolute()
    assert source_of(Plain) == source_of(Plain()) == f"plain={file}:Plain"
    assert source_of(Plain(1, table=[2])) == f'plain={file}:Plain?{{"args": [1], "kwargs": {{"table": [2]}}}}'
    assert Plain().rng.integers(10) == Plain().rng.integers(10)


def test_what_cannot_be_made_anew_is_refused_with_the_way_out(tmp_path):
    with pytest.raises(tf.Error, match="plain data"):
        tf.evaluate(Plain(table=object()), "smoke", out=tmp_path / "out")

    class Inner(tf.Controller):
        pass

    with pytest.raises(tf.Error, match="within a function"):
        tf.evaluate(Inner(), "smoke", out=tmp_path / "out")
    text = "import tsc_family as tf\nclass A(tf.Controller): pass\ntf.evaluate(A(), 'smoke')"
    done = subprocess.run([sys.executable, "-c", text], cwd=tmp_path, capture_output=True, text=True)
    assert "%%writefile" in done.stderr and not os.listdir(tmp_path)


def test_an_error_of_the_command_is_an_exception_with_its_words(tmp_path):
    with pytest.raises(tf.Error, match="did you mean smoke"):
        tf.evaluate(Plain(), "smok", out=tmp_path / "out", quiet=True)
    with pytest.raises(tf.Error, match="budget 3: the family has 2 point MDPs"):
        tf.evaluate(Plain(), "smoke", budget=3, out=tmp_path / "out", quiet=True)


ABLATION = """
import tsc_family as tf

class Weighted(tf.Controller):
    "Queues, with what was seen before."
    def __init__(self, alpha=0.0, label="none"): self.alpha, self.label = alpha, label
    def begin(self, signals): self.serves, self.old = [s.phase_lanes for s in signals], 0.0
    def act(self, obs):
        self.old = obs.lanes[:, :, 0] + self.alpha * self.old
        return [int((m * o).sum(1).argmax()) for m, o in zip(self.serves, self.old)]

if __name__ == "__main__":
    settings = {"demand.horizon_s": 300}
    result = tf.evaluate({"full": Weighted(alpha=0.5), "no-memory": Weighted()}, "smoke", eval_seeds=2, settings=settings,
                         against="max-pressure", networks=%r, out="named", quiet=True)
    print(sorted(map(str, result.summary()["method"])))
"""


def test_one_class_is_there_under_several_names_with_other_arguments(tsc_family, tmp_path, networks):
    done = python(ABLATION % networks, tmp_path, name="weighted.py")
    assert done.returncode == 0, done.stderr
    assert "['baseline', 'full', 'max-pressure', 'no-memory']" in done.stdout
    by_command = tsc_family(
        "run", "smoke", "--controller", "full=weighted.py:Weighted?alpha=0.5&label=a text", "--controller",
        "no-memory=weighted.py:Weighted?alpha=0.0", "--methods", "full,no-memory,max-pressure", "--eval-seeds", "2",
        "--set", "demand.horizon_s=300", "--networks", networks, "--out", "by-command", "--quiet",
    )  # fmt: skip
    assert by_command.returncode == 0, by_command.stderr

    def delays(out):
        lines = [json.loads(p.read_text().splitlines()[0]) for p in sorted((tmp_path / out / "done").rglob("*.jsonl"))]
        return {(line["method"], line["point"]): line["metrics"]["delay_s"] for line in lines}

    named = delays("named")
    assert named == delays("by-command")
    assert any(named["full", p] != named["no-memory", p] for p in ("quiet", "busy"))
    manifest = json.loads((tmp_path / "by-command/manifest.json").read_text())
    assert manifest["identity"]["controllers"][0]["source"] == "weighted.py:Weighted?alpha=0.5&label=a text"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("alpha", "'alpha' behind the ? is no argument; write"),
        ("a=1&a=2", "the argument a stands behind the ? twice"),
        ("{x", "is no JSON"),
    ],
)
def test_arguments_that_cannot_be_read_are_said(tsc_family, tmp_path, text, words):
    (tmp_path / "rule.py").write_text(RULE)
    done = tsc_family("run", "smoke", "--controller", f"mine=rule.py:Mine?{text}", "--methods", "mine", "--out", "out")
    assert done.returncode == 2 and words in done.stderr, done.stderr


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"budget": -3}, "budget=-3: expected a whole number or `all`"),
        ({"eval_seeds": 0}, "eval_seeds=0: expected a whole number from 1 to"),
        ({"answer_timeout": 5}, "answer_timeout has no effect: no controller is a command; leave it out"),
        ({"until_decided": True, "budget": 2}, "until_decided: it takes two methods to decide between"),
        ({"like": "nowhere"}, "nowhere"),
        ({"assist": "nowhere", "budget": 1}, "nowhere"),
        ({"against": "actuatd"}, 'unknown method "actuatd"'),
    ],
)
def test_errors_come_once_and_in_the_words_of_python(tmp_path, capfd, options, words):
    with pytest.raises(tf.Error) as raised:
        tf.evaluate(Plain(), "smoke", out=tmp_path / "out", settings={"demand.horizon_s": 60}, **options)
    assert words in str(raised.value) and "--" not in str(raised.value), raised.value
    said = capfd.readouterr()
    assert "error" not in said.err and said.out == "", said


@pytest.mark.parametrize("controllers", [len, 3, {}, [], {"full": 3}])
def test_what_is_no_controller_is_said(tmp_path, controllers):
    with pytest.raises(tf.Error, match="no controller|no tsc_family.Controller|at least one"):
        tf.evaluate(controllers, "smoke", out=tmp_path / "out")


def test_a_sample_that_stops_early_can_be_asked_for(tmp_path, networks):
    result = tf.evaluate(Plain(), "smoke", budget=2, looks=[2], until_decided=True, against=["baseline"], eval_seeds=2,
                         settings={"demand.horizon_s": 60}, networks=networks, out=tmp_path / "out", quiet=True)  # fmt: skip
    sample = json.loads((tmp_path / "out/manifest.json").read_text())["identity"]["sample"]
    within, methods = sample["growth"]["until"]["within"]
    assert (within, set(methods)) == (0.03, {"plain", "baseline"}) and "plain" in result.table()


def test_an_error_is_held_back_wherever_a_text_is_cut():
    from tsc_family._command import _Heard

    text = "a\nb error: x\nerr\nerror: bad\nmore\n"
    for size in range(1, 9):
        reading, writing = os.pipe()
        heard = _Heard(os.fdopen(reading, "rb"), stream := io.StringIO(), True)
        for begin in range(0, len(text), size):
            os.write(writing, text[begin : begin + size].encode())
            time.sleep(0.001)
        os.close(writing)
        assert heard.end() == text and stream.getvalue() == "a\nb error: x\nerr\n"
        heard.release()
        assert stream.getvalue() == text


def test_every_other_command_can_be_run(capfd):
    assert tf.run(["list", "smoke"]) == 0
    assert "busy" in capfd.readouterr().out
    with pytest.raises(tf.Error, match="unexpected argument"):
        tf.run(["list", "--no-such-option"])


@pytest.mark.parametrize("error", ["BrokenPipeError()", "ValueError('closed')", "UnicodeEncodeError('a', 'b', 0, 1, 'c')"])
def test_output_that_nobody_takes_keeps_no_command_waiting(tmp_path, error):
    text = (
        "import sys, tsc_family as tf\n"
        "class Gone:\n"
        f"    def write(self, text): raise {error}\n"
        "    def flush(self): pass\n"
        "sys.stdout = Gone()\n"
        # More than a pipe holds.
        "code = tf.run(['list', 'cartpole', '--json'])\n"
        "sys.__stdout__.write(f'ended with {code}')\n"
    )
    assert "ended with 0" in python(text, tmp_path, timeout=60).stdout


def test_an_interrupt_ends_a_run_that_the_same_call_continues(tmp_path, networks):
    text = (
        "import tsc_family as tf, time\n"
        "class Slow(tf.Controller):\n"
        "    def act(self, obs):\n        time.sleep(0.05)\n        return [0]\n"
        "import os; first = not os.path.exists('once')\n"
        f"tf.evaluate(Slow(), 'smoke', eval_seeds=2, jobs=1, out='out', networks={networks!r},\n"
        "            settings={'demand.horizon_s': 300})\n"
        "print('finished')\n"
    )
    (tmp_path / "slow.py").write_text(text)
    # What a shell starts in the background ignores SIGINT, and so would all that the tests start.
    child = subprocess.Popen([sys.executable, "slow.py"], cwd=tmp_path, stdin=subprocess.DEVNULL,
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                             preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))  # fmt: skip
    limit = time.monotonic() + 60
    while not list((tmp_path / "out" / "done").rglob("*.jsonl")) and time.monotonic() < limit:
        time.sleep(0.02)
    # Python alone hears of it, as in a notebook.
    child.send_signal(signal.SIGINT)
    out, err = child.communicate(timeout=60)
    assert "KeyboardInterrupt" in err and "finished" not in out, (out, err)
    before = len(done_files(tmp_path / "out"))
    assert before < 4
    done = python(text, tmp_path, name="slow.py")
    assert done.returncode == 0 and "finished" in done.stdout, done.stderr
    assert len(done_files(tmp_path / "out")) == 4
