import json, sys

serves = []
for line in sys.stdin:
    question = json.loads(line)
    if question["event"] == "begin":
        serves = [[p["lanes"] for p in s["phases"]] for s in question["signals"]]
        answer = {}
    elif question["event"] == "act":
        phases = []
        for lanes_of, seen in zip(serves, question["signals"]):
            queues = [sum(seen["queue"][l] for l in lanes) for lanes in lanes_of]
            phases.append(queues.index(max(queues)))
        answer = {"phases": phases}
    else:
        break
    print(json.dumps(answer), flush=True)
