"""What 1,000 training steps of Stable-Baselines3's DQN take on Signal-v0 and on sumo-rl with libsumo.

    python sb3_training.py SUMOCFG [SUMOCFG ...] [--episodes 3] [--repeats 3]

In one environment with tsc-family, stable-baselines3, sumo-rl and libsumo of the same version as SUMO. Both have a
decision every 5 s and the same network sizes, batches and updates; what they observe and how they reward is their own.
Variants take turns in processes of their own; figures are medians over the repeats of the time within `learn`, which
contains the simulation, without the start of the process.
"""

import argparse
import json
import os
import resource
import statistics
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from pathlib import Path


def value(config, names):
    """Returns a value of a SUMO configuration."""
    return next(e.get("value") or e.get("v") for e in ET.parse(config).iter() if e.tag in names)


def ours(config):
    import gymnasium
    import tsc_family  # noqa: F401

    return gymnasium.make("tsc_family/Signal-v0", sumocfg=config, settings={"signal.delta_time_s": 5})


def sumo_rl(config):
    import sumo

    os.environ["LIBSUMO_AS_TRACI"] = "1"
    os.environ["SUMO_HOME"] = sumo.SUMO_HOME
    from sumo_rl import SumoEnvironment

    begin, end = (int(float(value(config, names))) for names in ({"begin", "b"}, {"end", "e"}))
    return SumoEnvironment(
        net_file=str(config.parent / value(config, {"net-file", "n", "net"})),
        route_file=str(config.parent / value(config, {"route-files", "r"})),
        use_gui=False, begin_time=begin, num_seconds=end - begin, delta_time=5, yellow_time=3, min_green=5,
        add_system_info=False, sumo_warnings=False, single_agent=True,
    )  # fmt: skip


def train(env, decisions, episodes):
    """Trains, and prints what 1,000 steps have taken."""
    import torch
    from stable_baselines3 import DQN

    torch.set_num_threads(1)
    model = DQN("MlpPolicy", env, seed=1, learning_rate=5e-4, buffer_size=50_000, learning_starts=decisions,
                batch_size=64, train_freq=1, target_update_interval=500, exploration_fraction=0.6, device="cpu")  # fmt: skip
    used = lambda: sum(resource.getrusage(resource.RUSAGE_SELF)[:2])  # noqa: E731
    steps = decisions * episodes
    cpu, wall = used(), time.perf_counter()
    model.learn(steps)
    print(json.dumps([1000 * (time.perf_counter() - wall) / steps, 1000 * (used() - cpu) / steps]))
    env.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("configs", nargs="+", type=Path)
    parser.add_argument("--episodes", type=int, default=3)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--on", choices=["ours", "sumo_rl"], help=argparse.SUPPRESS)
    args = parser.parse_args()
    for config in map(Path.resolve, args.configs):
        decisions = int(float(value(config, {"end", "e"})) - float(value(config, {"begin", "b"}))) // 5
        if args.on:
            train({"ours": ours, "sumo_rl": sumo_rl}[args.on](config), decisions, args.episodes)
            continue
        seen = {"ours": [], "sumo_rl": []}
        for _ in range(args.repeats):
            for name, values in seen.items():
                command = [sys.executable, __file__, str(config), "--episodes", str(args.episodes), "--on", name]
                done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True)
                values.append(json.loads(done.stdout.splitlines()[-1]))
        medians = {name: [round(statistics.median(column), 3) for column in zip(*values)] for name, values in seen.items()}
        print(json.dumps({"scenario": config.stem, "repeats": args.repeats, "steps": decisions * args.episodes,
                          **{name: {"wall_s": wall, "cpu_s": cpu} for name, (wall, cpu) in medians.items()},
                          "cpu_ratio": round(medians["sumo_rl"][1] / medians["ours"][1], 2)}), flush=True)


if __name__ == "__main__":
    main()
