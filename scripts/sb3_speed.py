#!/usr/bin/env python3
"""Compares the time of a training with that of Stable-Baselines3 and sb3-contrib, on gymnasium's own cart and pole or pendulum.

    python3 -m venv /tmp/sb3 && /tmp/sb3/bin/pip install stable-baselines3==2.9.2 sb3-contrib==2.9.2
    /tmp/sb3/bin/python scripts/sb3_speed.py target/release/tsc-family [ROUNDS]

Every round trains each method once with either, one after the other, with the same defaults and steps and on one thread. Times are
processor time, so that other work on the machine counts less. Of Stable-Baselines3 only `learn` counts; of this program all of
`tsc-family run`: start, training, the validation of policies, one episode of evaluation, and report. Prints a table of medians in
Markdown.
"""

import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time

import gymnasium
import torch
from sb3_contrib import ARS, TRPO
from stable_baselines3 import PPO, SAC, TD3

CART, PENDULUM = ("cartpole", "CartPole-v1", "force_n,10"), ("pendulum", "Pendulum-v1", "mass_kg,1")
# Method, task, steps. A training of ppo or trpo is a number of updates of 2,048 steps.
TRAININGS = [
    (PPO, CART, 10_240),
    (TRPO, CART, 10_240),
    (ARS, CART, 10_000),
    (PPO, PENDULUM, 10_240),
    (TRPO, PENDULUM, 10_240),
    (SAC, PENDULUM, 1_000),
    (TD3, PENDULUM, 1_000),
]


def theirs(algorithm, task, steps, seed):
    policy = "LinearPolicy" if algorithm is ARS else "MlpPolicy"
    model = algorithm(policy, gymnasium.make(task[1]), seed=seed, device="cpu")
    begin = time.process_time()
    model.learn(steps)
    return time.process_time() - begin


def ours(program, algorithm, task, steps, seed):
    method = algorithm.__name__.lower()
    feature, value = task[2].split(",")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "own.toml").write_text(f'domain = "{task[0]}"\nfamily.points = "own.csv"\n')
        (folder / "own.csv").write_text(f"point,instances,{feature}\ngymnasium,1,{value}\n")
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [program, "run", "own.toml", "--methods", method, "--set", f"{method}.total_steps={steps}", "--seed", str(seed),
                   "--eval-seeds", "1", "--jobs", "1", "--quiet", "--out", "out"]
        subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    program = str(pathlib.Path(sys.argv[1]).resolve())
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    torch.set_num_threads(1)
    times = {training: ([], []) for training in range(len(TRAININGS))}
    for seed in range(rounds):
        for i, (algorithm, task, steps) in enumerate(TRAININGS):
            times[i][0].append(ours(program, algorithm, task, steps, seed + 1))
            times[i][1].append(theirs(algorithm, task, steps, seed + 1))
            print(f"round {seed + 1}: {algorithm.__name__} {times[i][0][-1]:.2f} s, {times[i][1][-1]:.2f} s", file=sys.stderr)
    print("| method | task | steps | this program, s | Stable-Baselines3, s | ratio |\n| --- | --- | ---: | ---: | ---: | ---: |")
    for i, (algorithm, task, steps) in enumerate(TRAININGS):
        own, other = (statistics.median(t) for t in times[i])
        print(f"| `{algorithm.__name__.lower()}` | `{task[0]}` | {steps:,} | {own:.2f} | {other:.2f} | {other / own:.1f} |")


if __name__ == "__main__":
    main()
