"""Whatever a controller does: its task has a failed record that says what happened, and the run goes on."""

import pytest

BEGIN = "class Mine(tf.Controller):\n"

# What a class is written like, and what its record says.
CASES = {
    "raises in __init__": (
        "    def __init__(self): raise ValueError('no such weights')\n",
        ["mine.py\", line 3, in __init__", "ValueError: no such weights"],
    ),
    "raises in begin": (
        "    def begin(self, signals): signals[7]\n",
        ["in begin", "IndexError: list index out of range"],
    ),
    "raises in act": (
        "    def act(self, obs): return [self.next(obs)]\n"
        "    def next(self, obs): return 1 // 0\n",
        ["mine.py\", line 3, in act", "line 4, in next", "ZeroDivisionError"],
    ),
    "has no act": ("    pass\n", ["Mine has no act(self, obs)"]),
    "returns a phase that does not exist": (
        "    def act(self, obs): return [9]\n",
        ["act returned phase 9 for signal", "which has 0 to 1"],
    ),
    "returns a negative phase": ("    def act(self, obs): return [-1]\n", ["act returned phase -1"]),
    "returns NaN": (
        "    def act(self, obs): return [float('nan')]\n",
        ["act returned nan (float) for signal", "a whole number from 0 to 1"],
    ),
    "returns too many": (
        "    def act(self, obs): return [0, 0]\n",
        ["act returned [0, 0] (list); it has to be a list of 1, the phase of every signal"],
    ),
    "returns too few": ("    def act(self, obs): return []\n", ["act returned [] (list); it has to be a list of 1"]),
    "returns a wrong shape": (
        "    def act(self, obs): return np.zeros((1, 2), int)\n",
        ["act returned array([0, 0])", "a whole number from 0 to 1"],
    ),
    "returns a number": ("    def act(self, obs): return 0\n", ["act returned 0 (int); it has to be a list of 1"]),
    "returns nothing": ("    def act(self, obs): pass\n", ["act returned None (NoneType)"]),
    "returns a text": ("    def act(self, obs): return 'x'\n", ["act returned 'x' (str)"]),
    "changes a mask": (
        "    def act(self, obs):\n        obs.phase_mask[:] = True\n",
        ["ValueError", "read-only"],
    ),
    "reads standard input": (
        "    def act(self, obs): return [int(input())]\n",
        ["a controller has no standard input"],
    ),
    "calls sys.exit": (
        "    def act(self, obs):\n        import sys\n        sys.exit(3)\n",
        ["in act", "SystemExit: 3"],
    ),
    "calls os._exit": (
        "    def act(self, obs):\n        import os\n        os._exit(3)\n",
        ["3"],
    ),
    "exhausts the stack": (
        "    def act(self, obs): return self.act(obs)\n",
        ["RecursionError: maximum recursion depth exceeded"],
    ),
    "changes the working folder": (
        "    def act(self, obs):\n        import os\n        os.chdir('/')\n        return [0]\n",
        ["act() changed the working folder"],
    ),
    "raises in train": (
        "    def train(self, env):\n        env.reset()\n        env.step([0])\n        raise KeyError('replay')\n"
        "    def act(self, obs): return [0]\n",
        ["in train", "KeyError: 'replay'"],
    ),
    "trains with a phase that does not exist": (
        "    def train(self, env):\n        env.reset()\n        env.step([5])\n"
        "    def act(self, obs): return [0]\n",
        ["step() got phase 5 for signal"],
    ),
    "saves nothing": (
        "    def train(self, env): pass\n    def save(self, path): pass\n    def act(self, obs): return [0]\n",
        ["save(path) wrote 0 files; write one, at path"],
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_a_failed_record_says_what_happened(evaluated, case):
    text, words = CASES[case]
    mine, done = evaluated(BEGIN + text)
    assert done.returncode == 3, done.stderr
    assert [record["outcome"] for record in mine] == ["failed", "failed"], mine
    for word in words:
        assert word in mine[0]["reason"], mine[0]["reason"]
    # Nothing of this package is in a traceback.
    assert "tsc_family/_" not in mine[0]["reason"]


# Time without a step, and one point MDP: a machine that is busy starts a worker in less.
HANGS = ["--stall-timeout", "5", "--budget", "1"]


@pytest.mark.parametrize(
    ("method", "text"),
    [
        ("act", "    def act(self, obs):\n        while True: pass\n"),
        # It never gives the interpreter back.
        ("act", "    def act(self, obs):\n        import re\n        re.match('(a+)+$', 'a' * 50 + 'b')\n"),
        ("train", "    def train(self, env):\n        while True: pass\n    def act(self, obs): return [0]\n"),
    ],
)
def test_one_that_hangs_is_ended_with_its_stack(evaluated, method, text):
    mine, done = evaluated(BEGIN + text, "Mine", *HANGS)
    assert done.returncode == 3, done.stderr
    assert "mine.py\", line" in mine[0]["reason"] and f"in {method}" in mine[0]["reason"], mine[0]["reason"]


def test_prints_go_to_the_log_and_threads_that_never_end_keep_nothing_up(evaluated, tmp_path):
    text = (
        "    def begin(self, signals):\n"
        "        import os, threading, time\n"
        "        print('a print')\n        os.write(1, b'bytes to standard output\\n')\n"
        "        threading.Thread(target=time.sleep, args=(10000,)).start()\n"
        "    def act(self, obs): return [0]\n"
    )
    mine, done = evaluated(BEGIN + text)
    assert done.returncode == 0, done.stderr
    assert [record["outcome"] for record in mine] == ["done", "done"] or len(mine) == 2
    logs = "".join(path.read_text() for path in (tmp_path / "out" / "logs").rglob("*.log"))
    assert "a print" in logs and "bytes to standard output" in logs
    assert "a print" not in done.stdout


def test_a_process_that_a_class_is_forked_into_ends_and_answers_nothing(evaluated):
    forks = "    def __init__(self):\n        os.fork()\n    def act(self, obs):\n        os.fork()\n        return [0]\n"
    forked, done = evaluated("import os\n" + BEGIN + forks)
    assert done.returncode == 0, (done.stderr, forked)
    assert len(forked) == 2 and {record["outcome"] for record in forked} == {"ok"}


@pytest.mark.parametrize(
    ("text", "name", "words"),
    [
        ("raise RuntimeError('broken file')\n", "Mine", ["mine.py\", line 2", "RuntimeError: broken file"]),
        ("def f(:\n", "Mine", ["SyntaxError", "mine.py\", line 2"]),
        ("import no_such_module\n", "Mine", ["ModuleNotFoundError: No module named 'no_such_module'"]),
        ("class Mine: pass\n", "Mine", ["Mine is no tsc_family.Controller"]),
        ("", "Mine", ["mine.py has no class Mine at its top level"]),
        ("class Mine(tf.Controller):\n    files = ['weights.bin']\n", "Mine", ["names a file that is not there"]),
        ("class Mine(tf.Controller): pass\n", "Mine?{", ["is no JSON"]),
    ],
)
def test_one_that_cannot_be_opened_is_refused_before_anything_runs(evaluated, tmp_path, text, name, words):
    _, done = evaluated(text, name)
    assert done.returncode == 2, done.stderr
    for word in words:
        assert word in done.stderr, done.stderr
    assert "tsc_family/_" not in done.stderr
    assert not (tmp_path / "out").exists()
