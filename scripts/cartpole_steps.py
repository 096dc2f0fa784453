#!/usr/bin/env python3
"""Writes tests/cartpole/gymnasium.csv: steps of gymnasium's CartPole-v1.

    python3 -m venv /tmp/gymnasium && /tmp/gymnasium/bin/pip install gymnasium==1.4.0
    /tmp/gymnasium/bin/python scripts/cartpole_steps.py

1,000 steps of gymnasium's own constants, and 50 each of contexts of the family, set as CARL does (attributes
of a made environment) and, under `physical`, with what gymnasium derives from them derived again. Actions
are random; an episode that is over is followed by a new one, whose row says `start`.
"""

import csv
import pathlib
import random

import gymnasium

OUT = pathlib.Path(__file__).parent.parent / "tests" / "cartpole" / "gymnasium.csv"
OWN = (0.5, 1.0, 0.1, 10.0, 9.8)
FAMILY = [
    (0.05, 10.0, 1.0, 100.0, 0.1),
    (0.05, 0.1, 0.01, 1.0, 19.6),
    (3.0, 6.0, 0.5, 50.0, 9.8),
    (5.0, 0.1, 1.0, 100.0, 19.6),
    (0.5, 1.0, 0.01, 1.0, 0.1),
]


def environment(variant, context):
    env = gymnasium.make("CartPole-v1").unwrapped
    env.length, env.masscart, env.masspole, env.force_mag, env.gravity = context
    if variant == "physical":
        env.total_mass = env.masspole + env.masscart
        env.polemass_length = env.masspole * env.length
    return env


def rows(variant, context, steps, seed):
    env = environment(variant, context)
    draw = random.Random(seed)
    start = True
    for _ in range(steps):
        if start:
            env.reset(seed=draw.randrange(2**31))
        before = [float(s) for s in env.state]
        action = draw.randrange(2)
        _, reward, terminated, _, _ = env.step(action)
        after = [float(s) for s in env.state]
        yield [variant, *context, int(start), *before, action, *after, reward, int(terminated)]
        start = terminated


def main():
    header = "variant,length_m,masscart_kg,masspole_kg,force_n,gravity_mps2,start"
    states = ["x", "x_velocity", "angle", "angle_velocity"]
    with OUT.open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow([*header.split(","), *states, "action", *(f"{s}_after" for s in states), "reward", "terminated"])
        out.writerows(rows("carl-compat", OWN, 1000, 0))
        for seed, context in enumerate(FAMILY, start=1):
            for variant in ["carl-compat", "physical"]:
                out.writerows(rows(variant, context, 50, seed))


if __name__ == "__main__":
    main()
