"""Environments of gymnasium and PettingZoo."""

import json
import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import parallel_api_test

import tsc_family as tf

MINUTE = {"demand.horizon_s": 120}


@pytest.fixture
def env(networks):
    made = []

    def make(point="busy", **kwargs):
        made.append(gymnasium.make("tsc_family/Signal-v0", point=point, scenario="smoke", networks=networks,
                                   settings=MINUTE, **kwargs))  # fmt: skip
        return made[-1]

    yield make
    for one in made:
        one.close()


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"observation": "mplight", "reward": "pressure"},
        {"sizes": {"lanes": 30, "phases": 8, "slots": 24}},
        {
            "observation": lambda obs, signal: obs.lanes[0, :, 0] / 50,
            "reward": lambda obs, signal: -float(obs.lanes[0, :, 0].sum()),
            "observation_space": gymnasium.spaces.Box(0, np.inf, (12,), np.float32),
        },
    ],
)
def test_gymnasium_s_checks_pass(env, options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if callable(options.get("observation")):
            width = env().unwrapped.signal.lane_mask.size
            options = {**options, "observation_space": gymnasium.spaces.Box(0, np.inf, (width,), np.float32)}
        check_env(env(**options).unwrapped)


def play(env, seed=None):
    """Plays the phases in turn; returns the rewards and the last info."""
    _, info = env.reset(seed=seed)
    rewards, over, turn = [], False, 0
    while not over:
        turn += 1
        _, reward, terminated, over, info = env.step(turn // 3 % int(info["action_mask"].sum()))
        rewards.append(reward)
        assert not terminated
    return rewards, {**info, "action_mask": info["action_mask"].tolist()}


def test_a_seed_has_the_same_vehicles_and_no_seed_follows_from_the_last(env):
    one = env()
    first, second, third = play(one, 7), play(one), play(one, 7)
    assert first == third and first[1]["seed"] == 7
    assert second[1]["seed"] != 7 and second[1]["delay_s"] != first[1]["delay_s"]
    assert play(one)[1]["seed"] == second[1]["seed"]


def test_a_seed_has_the_vehicles_of_a_run_s_row_with_that_seed(env, evaluated, tmp_path):
    _, done = evaluated(
        "class Mine(tf.Controller):\n"
        "  def begin(self, signals): self.turn, self.count = 0, len(signals[0].phases)\n"
        "  def act(self, obs):\n    self.turn += 1\n    return [self.turn // 3 % self.count]\n",
        "Mine", "--set", "demand.horizon_s=120",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    files = [path.read_text().splitlines() for path in (tmp_path / "out" / "done").rglob("*.jsonl")]
    rows = [json.loads(lines[1]) for lines in files if json.loads(lines[0])["method"] == "mine"
            and json.loads(lines[0])["point"] == "busy"]  # fmt: skip
    assert len(rows) == 1
    info = play(env(), rows[0]["seed"])[1]
    assert {name: info[name] for name in rows[0]["metrics"]} == rows[0]["metrics"]


def test_what_is_padded_keeps_the_phase_and_says_so(env):
    one = env("quiet", sizes={"phases": 8})
    _, info = one.reset(seed=1)
    # Another one of the same place knows its signals without an episode of its own.
    with pytest.raises(tf.Error, match=r"call reset\(\) first"):
        env("quiet", sizes={"phases": 8}).unwrapped.step(7)
    _, info = one.reset(seed=1)
    assert info["action_mask"].tolist()[-1] == 0 and one.action_space.n == 8
    assert one.step(7)[4]["invalid_action"]
    with pytest.raises(tf.Error, match="not in Discrete"):
        one.unwrapped.step(8)


def test_spaces_are_equal_over_points_that_follow_one_another(networks):
    env = tf.SignalEnv(["quiet", "busy"], scenario="smoke", networks=networks, settings=MINUTE)
    shapes = set()
    for expected in ["quiet", "busy", "quiet"]:
        seen, info = env.reset(seed=1)
        assert info["point"] == expected
        shapes.add(seen.shape)
    assert shapes == {env.observation_space.shape}
    env.close()


def test_a_second_simulation_is_refused_with_the_way_out(env):
    one, other = env(), env("quiet")
    one.reset(seed=1)
    with pytest.raises(tf.Error, match="make_vec"):
        other.reset(seed=1)
    one.close()
    other.reset(seed=1)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"point": "bussy"}, "did you mean busy"),
        ({"observation": "idq"}, "there are idqn, mplight"),
        ({"reward": "fun"}, "there are wait, pressure"),
        ({"observation": lambda obs, signal: 0}, "give observation_space"),
        ({"sizes": {"phases": 1}}, "give at least that"),
        ({"sizes": {"wheels": 1}}, "there is no \"wheels\""),
        ({"sumocfg": "a.sumocfg"}, "either point"),
    ],
)
def test_what_is_wrong_is_said(networks, options, words):
    with pytest.raises(tf.Error, match=words):
        tf.SignalEnv(**{"point": "busy", "scenario": "smoke", "networks": networks, **options})


def test_pettingzoo_s_checks_pass(networks):
    env = tf.parallel_env("busy", scenario="smoke", networks=networks, settings=MINUTE)
    parallel_api_test(env, num_cycles=50)
    env.close()


def test_several_signals_of_a_sumocfg_act_at_once_as_in_a_run(grid, tsc_family, tmp_path):
    env = tf.parallel_env(sumocfg=grid)
    parallel_api_test(env, num_cycles=50)
    assert sorted(env.possible_agents) == ["A0", "A1", "B0", "B1"]
    (tmp_path / "mine.py").write_text(
        "import tsc_family as tf\n"
        "class Mine(tf.Controller):\n"
        "  def begin(self, signals): self.turn, self.count = 0, len(signals)\n"
        "  def act(self, obs):\n"
        "    self.turn += 1\n"
        "    return [(self.turn + i) // 3 % 2 for i in range(self.count)]\n"
    )
    run = ["run", "--sumocfg", str(grid), "--controller", "mine=mine.py:Mine", "--methods", "mine", "--eval-seeds", "1"]
    done = tsc_family(*run, "--out", "out")
    assert done.returncode == 0, done.stderr
    files = [path.read_text().splitlines() for path in (tmp_path / "out" / "done").rglob("*.jsonl")]
    row = next(json.loads(lines[1]) for lines in files if json.loads(lines[0])["method"] == "mine")
    env.reset(seed=row["seed"])
    turn, rewards = 0, set()
    while env.agents:
        turn += 1
        _, reward, _, _, infos = env.step({agent: (turn + i) // 3 % 2 for i, agent in enumerate(env.possible_agents)})
        rewards.update(reward.values())
    assert len(rewards) > 1 and row["metrics"]["delay_s"] > 0
    for info in infos.values():
        assert {name: info[name] for name in row["metrics"]} == row["metrics"]
    with pytest.raises(tf.Error, match="all signals decide at once"):
        env.reset(seed=1)
        env.step({"A0": 0})
    with pytest.raises(tf.Error, match="parallel_env"):
        tf.SignalEnv(sumocfg=grid).reset(seed=1)
    env.close()


def test_vector_environments_are_processes_with_equal_spaces(networks, tmp_path):
    script = tmp_path / "vector.py"
    script.write_text(
        "import tsc_family as tf\n"
        "if __name__ == '__main__':\n"
        f"    envs = tf.make_vec(['quiet', 'busy'], 2, scenario='smoke', networks={networks!r},\n"
        "                       settings={'demand.horizon_s': 120})\n"
        "    seen, _ = envs.reset(seed=3)\n"
        "    assert seen.shape == envs.observation_space.shape and seen.shape[0] == 2\n"
        "    for _ in range(12):\n"
        "        seen, reward, _, over, info = envs.step([0, 0])\n"
        "    assert over.all() and (info['delay_s'] > 0).all(), info\n"
        "    envs.close()\n"
        "    print('well')\n"
    )
    done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=120)
    assert done.stdout == "well\n", done.stderr
