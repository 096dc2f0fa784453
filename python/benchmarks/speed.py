"""What a controller of one's own costs: the same rule in Rust, in Python in process, as a command, and on sumo-rl.

    python speed.py SUMOCFG [SUMOCFG ...] --repeats 7 --episodes 10 [--sumo-rl PYTHON]

Variants take turns in one run; figures are medians over the repeats, ratios are of medians. Processor time is that of a
whole worker process with all it starts, its start included; `sumo` is the plain binary on the same scenario, as many
episodes.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from pathlib import Path

HERE = Path(__file__).parent
OWN = {
    "max-pressure-resco": [],
    "pressure-python": ["--controller", f"pressure-python={HERE / 'pressure.py'}:MaxPressure"],
    "pressure-exec": ["--controller", f"pressure-exec=exec:{sys.executable} {HERE / 'pressure_exec.py'}"],
}
COMMAND = [sys.executable, "-m", "tsc_family"]


def measured(command, **kwargs):
    """Runs a command and returns its wall and processor time, seconds, with that of all it has waited for."""
    begin = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, stdin=subprocess.PIPE, **kwargs)
    errors = process.stderr.read()
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.perf_counter() - begin
    if status != 0:
        sys.exit(f"{command}: {errors.decode()}")
    return wall, usage.ru_utime + usage.ru_stime


def value(config, name):
    """Returns a value of a SUMO configuration."""
    for element in ET.parse(config).iter():
        if element.tag in name:
            return element.get("value") or element.get("v")
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("configs", nargs="+", type=Path)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--episodes", type=int, default=10)
    parser.add_argument("--sumo-rl", help="a Python that has sumo-rl")
    parser.add_argument("--sumo", default="sumo", help="SUMO's binary, of the version that tsc-family was built with")
    args = parser.parse_args()
    for config in args.configs:
        with tempfile.TemporaryDirectory() as folder:
            print(json.dumps(compare(config.resolve(), Path(folder), args)), flush=True)


def compare(config, folder, args):
    out, episodes = folder / "results", args.episodes
    # 5 s between decisions, as sumo-rl has it; the same rule in all.
    run = ["run", "--sumocfg", str(config), "--methods", "max-pressure-resco", "--eval-seeds", str(episodes),
           "--set", "signal.delta_time_s=5", "--out", str(out), "--quiet", *sum(OWN.values(), [])]
    subprocess.run([*COMMAND, *run], check=True)
    plan = [json.loads(line) for line in (out / "plan.jsonl").read_text().splitlines()]
    tasks = {task["method"]: task["task"] for task in plan}
    records = {m: [json.loads(line) for line in (out / f"done/000/{k}.jsonl").read_text().splitlines()] for m, k in tasks.items()}
    delays = {m: [row["metrics"]["delay_s"] for row in record[1:]] for m, record in records.items()}
    assert delays["max-pressure-resco"] == delays["pressure-python"] == delays["pressure-exec"], "not the same rule"
    begin, end = float(value(config, {"begin", "b"}) or 0), float(value(config, {"end", "e"}))
    seen = {}
    for _ in range(args.repeats):
        for method, own in OWN.items():
            (out / f"done/000/{tasks[method]}.jsonl").unlink()
            # In a worker that is given its own controller alone, as a run of it starts one.
            worker = [*COMMAND, "worker", str(out), "--task", str(tasks[method]), *own]
            seen.setdefault(method, []).append(measured(worker))
        plain = [args.sumo, "-c", str(config), "--no-step-log", "--no-warnings", "--xml-validation", "never",
                 "--tripinfo-output", str(folder / "trips.xml"), "--time-to-teleport", "-1"]
        times = [measured([*plain, "--seed", str(k)]) for k in range(episodes)]
        seen.setdefault("sumo", []).append(tuple(map(sum, zip(*times))))
        if args.sumo_rl:
            net, routes = (config.parent / value(config, names) for names in ({"net-file", "n", "net"}, {"route-files", "r"}))
            command = [args.sumo_rl, str(HERE / "sumo_rl_pressure.py"), str(net), str(routes), "--begin", str(int(begin)),
                       "--seconds", str(int(end - begin)), "--episodes", str(episodes)]
            seen.setdefault("sumo-rl", []).append(measured(command))
    medians = {name: [statistics.median(column) for column in zip(*values)] for name, values in seen.items()}
    decisions = episodes * (end - begin) / 5
    ours = medians["max-pressure-resco"]
    return {
        "scenario": config.stem, "repeats": args.repeats, "episodes": episodes,
        **{name: {"decisions_per_s": round(decisions / wall), "cpu_s": round(cpu, 3),
                  "cpu_to_rust": round(cpu / ours[1], 3), "cpu_to_sumo": round(cpu / medians["sumo"][1], 3),
                  "wall_to_rust": round(wall / ours[0], 3)}
           for name, (wall, cpu) in medians.items()},
    }


if __name__ == "__main__":
    main()
