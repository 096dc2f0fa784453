"""The same rule on sumo-rl with libsumo: episodes of a network with routes, and the processor time that they take."""

import argparse
import json
import os
import resource
import time

import numpy as np
import sumo

os.environ["LIBSUMO_AS_TRACI"] = "1"
os.environ.setdefault("SUMO_HOME", sumo.SUMO_HOME)

import sumo_rl  # noqa: E402

parser = argparse.ArgumentParser()
parser.add_argument("net")
parser.add_argument("routes")
parser.add_argument("--begin", type=int, default=0)
parser.add_argument("--seconds", type=int, default=3600)
parser.add_argument("--episodes", type=int, default=3)
parser.add_argument("--teleport", default="-1")
args = parser.parse_args()

env = sumo_rl.SumoEnvironment(
    net_file=args.net, route_file=args.routes, use_gui=False, begin_time=args.begin, num_seconds=args.seconds,
    delta_time=5, yellow_time=3, min_green=5, add_system_info=False, sumo_warnings=False,
    time_to_teleport=int(args.teleport),
)
env.reset()
serves = {}
for ts_id, signal in env.traffic_signals.items():
    links = env.sumo.trafficlight.getControlledLinks(ts_id)
    column = {lane: i for i, lane in enumerate(signal.lanes)}
    rows = []
    for phase in signal.green_phases:
        row = np.zeros(len(signal.lanes))
        for letter, link in zip(phase.state, links):
            if letter in "gG" and link:
                row[column[link[0][0]]] = 1
        rows.append(row)
    serves[ts_id] = np.array(rows)

used = lambda: sum(resource.getrusage(resource.RUSAGE_SELF)[:2])  # noqa: E731
cpu, wall, decisions = used(), time.perf_counter(), 0
for _ in range(args.episodes):
    env.reset()
    done = {"__all__": False}
    while not done["__all__"]:
        actions = {}
        for ts_id, signal in env.traffic_signals.items():
            queues = np.array([env.sumo.lane.getLastStepHaltingNumber(lane) for lane in signal.lanes])
            actions[ts_id] = int((serves[ts_id] @ queues).argmax())
        _, _, done, _ = env.step(actions)
        decisions += 1
print(json.dumps({"cpu_s": (used() - cpu) / args.episodes, "wall_s": (time.perf_counter() - wall) / args.episodes,
                  "decisions": decisions / args.episodes}))
env.close()
