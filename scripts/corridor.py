#!/usr/bin/env python3
"""Compares plans of a street of four signals: without coordination, with existing offsets, ours, and those of SUMO's tools.

    python3 scripts/corridor.py target/release/tsc-family corridor --tools /usr/share/sumo/tools

writes the street and its demand into the folder `corridor`, lets each tool make its plan from vehicles of training seeds,
plays every plan in plain `sumo` with the same seeds, and prints a table in Markdown. `sumo` and `netconvert` must be on the
PATH. --tools is the folder of tlsCycleAdaptation.py and tlsCoordinator.py, from Debian's sumo-tools or the package eclipse-sumo.
"""

import argparse
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

# Where the signals are, metres.
AT_M = [0, 320, 720, 1060]
# Length of the streets that lead to them, metres.
ARM_M = 400
MAIN_MPS, SIDE_MPS = 13.89, 11.11
# The plan that the street has: seconds of green for the main and the side street with 4 s of yellow and 1 s of all-red
# after each. Its offsets are the travel times eastbound.
GREENS_S, YELLOW_S, RED_S = (50, 30), 4, 1
OFFSETS_S = [0, 23, 52, 76]
# Vehicles per hour that drive along the street, eastbound and westbound.
ALONG_VPH = (620, 480)
# Vehicles per hour from both side streets of each signal, and their turns.
SIDE_VPH = [360, 520, 440, 320]
ACROSS, OUT_EAST, OUT_WEST = 0.5, 0.25, 0.25
# Vehicles per hour that leave the street at each signal, per direction and side.
LEAVE_VPH = 30
HORIZON_S = 3600
# Seed of the vehicles that SUMO's tools see, and the first of the comparison.
TOOL_SEED, FIRST_SEED = 7, 1001
# Quantiles of Student's t for 95% intervals, by degrees of freedom.
STUDENT = {1: 12.71, 2: 4.30, 3: 3.18, 4: 2.78, 5: 2.57, 7: 2.36, 9: 2.26, 14: 2.14, 19: 2.09, 29: 2.05}


def call(*words, **options):
    """Runs a program, and ends with its output if it fails."""
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, **options)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, words))} failed:\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
    return done


def write_network(folder):
    """Writes the street as plain XML and lets netconvert build it."""
    last = len(AT_M) - 1
    nodes = [f'<node id="W" x="{-ARM_M}" y="0"/>', f'<node id="E" x="{AT_M[last] + ARM_M}" y="0"/>']
    edges = []
    for i, x in enumerate(AT_M):
        nodes.append(f'<node id="J{i}" x="{x}" y="0" type="traffic_light"/>')
        for side, y in (("N", ARM_M), ("S", -ARM_M)):
            nodes.append(f'<node id="{side}{i}" x="{x}" y="{y}"/>')
            for name, a, b in ((f"{side}{i}in", f"{side}{i}", f"J{i}"), (f"{side}{i}out", f"J{i}", f"{side}{i}")):
                edges.append(f'<edge id="{name}" from="{a}" to="{b}" numLanes="1" speed="{SIDE_MPS}"/>')
    names = ["W", *(f"J{i}" for i in range(len(AT_M))), "E"]
    for a, b in zip(names, names[1:]):
        for u, v in ((a, b), (b, a)):
            edges.append(f'<edge id="{u}{v}" from="{u}" to="{v}" numLanes="2" speed="{MAIN_MPS}"/>')
    (folder / "street.nod.xml").write_text("<nodes>\n" + "\n".join(nodes) + "\n</nodes>\n")
    (folder / "street.edg.xml").write_text("<edges>\n" + "\n".join(edges) + "\n</edges>\n")
    call("netconvert", "-n", "street.nod.xml", "-e", "street.edg.xml", "-o", "street.net.xml", "--no-turnarounds",
         "--tls.left-green.time", "0", "--xml-validation", "never", cwd=folder)
    retime(folder, OFFSETS_S)


def retime(folder, offsets_s):
    """Gives the programs of the network the existing greens and these offsets."""
    tree = ET.parse(folder / "street.net.xml")
    for logic in tree.getroot().iter("tlLogic"):
        greens = [p.get("state") for p in logic if "y" not in p.get("state").lower()]
        # The main street is the one whose states have more greens.
        greens.sort(key=lambda state: -state.count("G"))
        yellows = {p.get("state") for p in logic if "y" in p.get("state").lower()}
        for phase in list(logic):
            logic.remove(phase)
        for state, green_s in zip(greens, GREENS_S):
            yellow = next(y for y in yellows if all((a in "Gg") == (b in "yY") for a, b in zip(state, y)))
            for text, seconds in ((state, green_s), (yellow, YELLOW_S), ("r" * len(state), RED_S)):
                ET.SubElement(logic, "phase", duration=str(seconds), state=text)
        logic.set("offset", str(offsets_s[int(logic.get("id")[1:])]))
    tree.write(folder / "street.net.xml")


def write_demand(folder):
    """Writes flows of vehicles that come at random."""
    last = len(AT_M) - 1
    flows = []

    def flow(a, b, vph):
        flows.append(f'<flow id="{a}_{b}" begin="0" end="{HORIZON_S}" from="{a}" to="{b}" '
                     f'probability="{vph / 3600:.5f}" departLane="best" departSpeed="max"/>')

    flow("WJ0", f"J{last}E", ALONG_VPH[0])
    flow(f"EJ{last}", "J0W", ALONG_VPH[1])
    for i, vph in enumerate(SIDE_VPH):
        for side, other in (("N", "S"), ("S", "N")):
            flow(f"{side}{i}in", f"{other}{i}out", vph / 2 * ACROSS)
            flow(f"{side}{i}in", f"J{last}E", vph / 2 * OUT_EAST)
            flow(f"{side}{i}in", "J0W", vph / 2 * OUT_WEST)
            flow("WJ0", f"{side}{i}out", LEAVE_VPH)
            flow(f"EJ{last}", f"{side}{i}out", LEAVE_VPH)
    (folder / "street.rou.xml").write_text("<routes>\n" + "\n".join(flows) + "\n</routes>\n")
    (folder / "street.sumocfg").write_text(
        '<configuration><input><net-file value="street.net.xml"/><route-files value="street.rou.xml"/></input>'
        f'<time><begin value="0"/><end value="{HORIZON_S}"/></time></configuration>\n')


def sumo(folder, seed, plan, *more):
    """Plays a plan in plain sumo."""
    load = ["-a", plan] if plan else []
    call("sumo", "-c", "street.sumocfg", "--seed", seed, "--time-to-teleport", "-1", "--xml-validation", "never",
         "--no-step-log", *load, *more, cwd=folder)


def played(folder, seed, plan):
    """Returns delay of all, and travel time, delay and stops by direction of those who drive along the street."""
    sumo(folder, seed, plan, "--tripinfo-output", "trips.xml", "--tripinfo-output.write-unfinished",
         "--tripinfo-output.write-undeparted")
    last = len(AT_M) - 1
    along = {f"WJ0_J{last}E": "EB", f"EJ{last}_J0W": "WB"}
    everybody, of = [], {"EB": [], "WB": []}
    for trip in ET.parse(folder / "trips.xml").getroot():
        delay_s = float(trip.get("timeLoss")) + float(trip.get("departDelay"))
        everybody.append(delay_s)
        direction = along.get(trip.get("id").rsplit(".", 1)[0])
        if direction and float(trip.get("arrival")) >= 0:
            travel_s = float(trip.get("duration")) + float(trip.get("departDelay"))
            of[direction].append((travel_s, delay_s, float(trip.get("waitingCount"))))
    row = [sum(everybody) / len(everybody)]
    for direction in ("EB", "WB"):
        row += [sum(trip[i] for trip in of[direction]) / len(of[direction]) for i in range(3)]
    return row


def interval(values):
    """Returns the mean and half of its 95% interval."""
    n = len(values)
    mean = sum(values) / n
    variance = sum((v - mean) ** 2 for v in values) / max(n - 1, 1)
    below = max(df for df in STUDENT if df <= max(n - 1, 1))
    return mean, STUDENT[below] * (variance / n) ** 0.5


def with_tools(folder, tools):
    """Lets SUMO's tools make plans from the vehicles of a training seed, and returns what to load by name."""
    sumo(folder, TOOL_SEED, None, "--vehroute-output", "vehicles.rou.xml", "--vehroute-output.write-unfinished")
    environment = {**os.environ, "SUMO_HOME": str(tools.parent)}
    tool = lambda name, *words: call(sys.executable, tools / name, *words, cwd=folder, env=environment)
    tool("tlsCoordinator.py", "-n", "street.net.xml", "-r", "vehicles.rou.xml", "-o", "coordinator.add.xml")
    tool("tlsCycleAdaptation.py", "-n", "street.net.xml", "-r", "vehicles.rou.xml", "-o", "adapted.add.xml",
         "--unified-cycle")
    # The second tool reads cycles from a network, so the adapted programs are put into one.
    programs = {logic.get("id"): logic for logic in ET.parse(folder / "adapted.add.xml").getroot().iter("tlLogic")}
    tree = ET.parse(folder / "street.net.xml")
    for logic in tree.getroot().iter("tlLogic"):
        adapted = programs[logic.get("id")]
        for phase in list(logic):
            logic.remove(phase)
        logic.extend(list(adapted))
    tree.write(folder / "adapted.net.xml")
    tool("tlsCoordinator.py", "-n", "adapted.net.xml", "-r", "vehicles.rou.xml", "-o", "offsets.add.xml")
    offsets = {}
    for element in ET.parse(folder / "offsets.add.xml").getroot().iter("tlLogic"):
        offsets[element.get("id")] = element.get("offset")
    for logic in programs.values():
        logic.set("offset", offsets.get(logic.get("id"), "0"))
        logic.set("programID", "adapted-coordinated")
    both = ET.Element("additional")
    both.extend(programs.values())
    ET.ElementTree(both).write(folder / "both.add.xml")
    return {
        "tlsCoordinator.py on the existing plan": "coordinator.add.xml",
        "tlsCycleAdaptation.py": "adapted.add.xml",
        "tlsCycleAdaptation.py and tlsCoordinator.py": "both.add.xml",
    }


def main():
    """Runs the comparison."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path, help="tsc-family")
    parser.add_argument("folder", type=Path, help="folder for the street, the plans and the results")
    parser.add_argument("--tools", type=Path, required=True, help="folder of SUMO's tools")
    parser.add_argument("--seeds", type=int, default=20, help="seeds of the comparison")
    parser.add_argument("--simulations", type=int, default=24, help="episodes of tuning per signal")
    arguments = parser.parse_args()
    folder = arguments.folder
    folder.mkdir(parents=True, exist_ok=True)
    write_network(folder)
    write_demand(folder)
    call(arguments.program.resolve(), "run", "--sumocfg", "street.sumocfg", "--preset", "field", "--methods",
         "program,fixed-time,coordinated", "--eval-seeds", "5", "--quiet", "--out", "results", "--set",
         f"fixed_time.simulations={arguments.simulations}", "--set", f"coordinated.simulations={arguments.simulations}",
         cwd=folder)
    zero = ET.parse(folder / "street.net.xml").getroot()
    uncoordinated = ET.Element("additional")
    for logic in zero.iter("tlLogic"):
        logic.set("offset", "0")
        logic.set("programID", "uncoordinated")
        uncoordinated.append(logic)
    ET.ElementTree(uncoordinated).write(folder / "uncoordinated.add.xml")
    plans = {
        "existing plan, offsets 0": "uncoordinated.add.xml",
        "existing plan and offsets": None,
        **with_tools(folder, arguments.tools.resolve()),
        "`fixed-time`": "results/report/plans/street.add.xml",
        "`coordinated`": "results/report/plans/street.coordinated.add.xml",
    }
    heads = ["delay of all, s", *(f"{d} {what}" for d in ("EB", "WB") for what in ("travel, s", "delay, s", "stops"))]
    print("| plan | " + " | ".join(heads) + " |\n| --- |" + " ---: |" * len(heads))
    for name, plan in plans.items():
        rows = [played(folder, FIRST_SEED + i, plan) for i in range(arguments.seeds)]
        cells = []
        for i, values in enumerate(zip(*rows)):
            mean, half = interval(values)
            digits = 2 if i in (3, 6) else 1
            cells.append(f"{mean:.{digits}f} ± {half:.{digits}f}")
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
