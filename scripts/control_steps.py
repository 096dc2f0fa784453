#!/usr/bin/env python3
"""Writes tests/control_tasks/*.csv: steps of gymnasium's Pendulum-v1 and MountainCarContinuous-v0.

    python3 -m venv /tmp/gymnasium && /tmp/gymnasium/bin/pip install gymnasium==1.4.0
    /tmp/gymnasium/bin/python scripts/control_steps.py

1,000 steps of gymnasium's own constants and 50 of each of some contexts, set as CARL does (attributes of a made
environment). Actions are random, some of them beyond the limits, in double precision for the pendulum and in single precision
for the car; an episode that is over is followed by a new one, whose row
says `start`.
"""

import csv
import pathlib
import random

import gymnasium
import numpy as np

OUT = pathlib.Path(__file__).parent.parent / "tests" / "control_tasks"
PENDULUMS = [(1, 1, 10), (0.4, 0.5, 15), (4, 10, 2), (1.5, 4, 12), (3, 7, 5)]
CARS = [(0.07, 0.45, 0.0015), (0.035, 0.55, 0.003), (0.1, 0.25, 0.0005), (0.05, 0.35, 0.002)]


def pendulum(context):
    env = gymnasium.make("Pendulum-v1").unwrapped
    env.m, env.l, env.g = context
    return env, 3.0, 200, np.float64


def car(context):
    env = gymnasium.make("MountainCarContinuous-v0").unwrapped
    env.max_speed, env.goal_position, env.power = context
    return env, 1.5, 999, np.float32


def rows(make, context, steps, seed):
    env, largest, horizon, kind = make(context)
    draw = random.Random(seed)
    left, action = 0, 0.0
    for _ in range(steps):
        start = left == 0
        if start:
            env.reset(seed=draw.randrange(2**31))
            left = horizon
        before = [float(s) for s in env.state]
        # Pushes that last take the car up the hill.
        if draw.random() < 0.1 or start:
            action = draw.uniform(-largest, largest)
        if before[1] and draw.random() < 0.8:
            action = abs(action) * np.sign(before[1])
        action = float(kind(action))
        _, reward, terminated, _, _ = env.step(np.array([action], dtype=kind))
        after = [float(s) for s in env.state]
        yield [*context, int(start), *before, float(action), *after, float(np.asarray(reward).item()), int(terminated)]
        left = 0 if terminated else left - 1


def write(name, features, make, contexts):
    OUT.mkdir(exist_ok=True)
    with (OUT / f"{name}.csv").open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow([*features, "start", "position", "velocity", "action", "position_after", "velocity_after", "reward", "terminated"])
        for seed, context in enumerate(contexts):
            out.writerows(rows(make, context, 1000 if seed == 0 else 50, seed))


def main():
    write("pendulum", ["mass_kg", "length_m", "gravity_mps2"], pendulum, PENDULUMS)
    write("mountain-car", ["max_speed", "goal_position", "power"], car, CARS)


if __name__ == "__main__":
    main()
