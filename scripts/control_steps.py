#!/usr/bin/env python3
"""Writes tests/control_tasks/*.csv: steps of gymnasium's environments.

    python3 -m venv /tmp/gymnasium && /tmp/gymnasium/bin/pip install 'gymnasium[mujoco]==1.4.0' mujoco==4.0.0
    /tmp/gymnasium/bin/python scripts/control_steps.py

1,000 steps of gymnasium's own constants and 50 of each of some contexts, set as CARL does (attributes of a made
environment) and, for CartPole's `physical`, with what gymnasium derives from them derived again. Actions are random, some of
them beyond the limits, in double precision for the pendulum and in single precision for the car; an episode that is over is
followed by a new one, whose row says `start`.

For half cheetah and swimmer, every tenth state: so small differences would have grown. There a context, of which there are 30
steps, is set in the model that gymnasium has loaded (cheetah), or in a copy of its file (swimmer).
"""

import csv
import pathlib
import random
import tempfile

import gymnasium
import mujoco
import numpy as np

OUT = pathlib.Path(__file__).parent.parent / "tests" / "control_tasks"
POLES = [
    (0.5, 1.0, 0.1, 10.0, 9.8),
    (0.05, 10.0, 1.0, 100.0, 0.1),
    (0.05, 0.1, 0.01, 1.0, 19.6),
    (3.0, 6.0, 0.5, 50.0, 9.8),
    (5.0, 0.1, 1.0, 100.0, 19.6),
    (0.5, 1.0, 0.01, 1.0, 0.1),
]
PENDULUMS = [(1, 1, 10), (0.4, 0.5, 15), (4, 10, 2), (1.5, 4, 12), (3, 7, 5)]
ACROBOTS = [(1, 1, 1, 1), (0.5, 1.5, 2, 0.5), (1.5, 0.5, 1, 2)]
# Gravity, shares of the torso's mass and of friction.
CHEETAHS = [(9.81, 1, 1), (2, 0.5, 0.25)]
SWIMMERS = [(0.1, 0.1, 0.1), (0.1, 0.1125, 0.1), (0.05, 0.05, 0.05)]
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


def poles():
    with (OUT / "cartpole.csv").open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        names = ["x", "x_velocity", "angle", "angle_velocity"]
        out.writerow(["variant", "length_m", "masscart_kg", "masspole_kg", "force_n", "gravity_mps2", "start", *names,
                      "action", *(f"{name}_after" for name in names), "reward", "terminated"])
        for seed, context in enumerate(POLES):
            for variant in ["carl-compat", "physical"] if seed else ["carl-compat"]:
                env = gymnasium.make("CartPole-v1").unwrapped
                env.length, env.masscart, env.masspole, env.force_mag, env.gravity = context
                if variant == "physical":
                    env.total_mass = env.masspole + env.masscart
                    env.polemass_length = env.masspole * env.length
                draw, start = random.Random(seed), True
                for _ in range(50 if seed else 1000):
                    if start:
                        env.reset(seed=draw.randrange(2**31))
                    before = [float(s) for s in env.state]
                    action = draw.randrange(2)
                    _, reward, terminated, _, _ = env.step(action)
                    out.writerow([variant, *context, int(start), *before, action, *map(float, env.state), reward, int(terminated)])
                    start = terminated


def acrobot():
    with (OUT / "acrobot.csv").open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        names = ["first", "second", "first_speed", "second_speed"]
        out.writerow(["first_length_m", "second_length_m", "first_mass_kg", "second_mass_kg", "start", "action", *names,
                      *(f"{name}_after" for name in names), "terminated"])
        for seed, context in enumerate(ACROBOTS):
            env = gymnasium.make("Acrobot-v1").unwrapped
            env.LINK_LENGTH_1, env.LINK_LENGTH_2, env.LINK_MASS_1, env.LINK_MASS_2 = context
            env.LINK_COM_POS_1, env.LINK_COM_POS_2 = context[0] / 2, context[1] / 2
            draw, left = random.Random(seed), 0
            for _ in range(1000 if seed == 0 else 50):
                start = left == 0
                if start:
                    env.reset(seed=draw.randrange(2**31))
                    left = 500
                before = [float(s) for s in env.state]
                # A pump, which reaches the goal.
                action = (0 if before[2] > 0 else 2) if draw.random() < 0.8 else draw.randrange(3)
                _, _, terminated, _, _ = env.step(action)
                out.writerow([*context, int(start), action, *before, *map(float, env.state), int(terminated)])
                left = 0 if terminated else left - 1


def cheetah(context):
    env = gymnasium.make("HalfCheetah-v5").unwrapped
    gravity, torso, friction = context
    model = env.model
    model.opt.gravity[2] = -gravity
    model.geom_friction[:, 0] *= friction
    if torso != 1:
        model.body_mass[1] *= torso
        model.body_inertia[1] *= torso
        mujoco.mj_setConst(model, mujoco.MjData(model))
    return env


def swimmer(context):
    asset = pathlib.Path(gymnasium.__file__).parent / "envs/mujoco/assets/swimmer.xml"
    text = asset.read_text()
    for radius in context:
        text = text.replace('size="0.1"', f'size = "{radius}"', 1)
    with tempfile.NamedTemporaryFile("w", suffix=".xml") as file:
        file.write(text)
        file.flush()
        return gymnasium.make("Swimmer-v5", xml_file=file.name).unwrapped


def models(name, features, make, contexts):
    with (OUT / f"{name}.csv").open("w", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        for seed, context in enumerate(contexts):
            env = make(context)
            env.reset(seed=seed)
            count, actions = 2 * env.model.nv, env.model.nu
            if seed == 0:
                out.writerow([*features, "step", *(f"state_{i}" for i in range(count)), "reward"])
            reward, number = 0.0, seed
            for step in range(1001 if seed == 0 else 31):
                if step % 10 == 0:
                    state = [*map(float, env.data.qpos), *map(float, env.data.qvel)]
                    out.writerow([*context, step, *state, float(reward)])
                action = []
                for _ in range(actions):
                    # The numbers that tests/control_tasks/steps.rs draws; each is one in single precision.
                    number = (1103515245 * number + 12345) % 2**31
                    action.append((number >> 8) / 2**22 - 1)
                _, reward, _, _, _ = env.step(np.array(action))


def main():
    poles()
    write("pendulum", ["mass_kg", "length_m", "gravity_mps2"], pendulum, PENDULUMS)
    write("mountain-car", ["max_speed", "goal_position", "power"], car, CARS)
    acrobot()
    models("half-cheetah", ["gravity_mps2", "torso_share", "friction_share"], cheetah, CHEETAHS)
    models("swimmer", ["head_radius_m", "middle_radius_m", "tail_radius_m"], swimmer, SWIMMERS)


if __name__ == "__main__":
    main()
