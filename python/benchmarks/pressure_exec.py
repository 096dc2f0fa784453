"""RESCO's max pressure as a command: see docs/own-controller.md."""

import json
import sys

signals = []
for line in sys.stdin:
    question = json.loads(line)
    if question["event"] == "begin":
        signals = question["signals"]
        answer = {}
    elif question["event"] == "act":
        phases = []
        for s, seen in zip(signals, question["signals"]):
            queue, ahead = seen["queue"], seen["downstream_queue"]
            pressure = [
                sum(queue[lane] for lane in m["lanes"]) - sum(ahead[lane] for lane in m["downstream"])
                for m in s["movements"]
            ]
            of_phases = [sum(pressure[m] for m in phase["pair"]) for phase in s["phases"]]
            phases.append(of_phases.index(max(of_phases)))
        answer = {"phases": phases}
    else:
        break
    print(json.dumps(answer), flush=True)
