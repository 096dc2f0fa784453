#!/usr/bin/env python3
"""Which SUMO scenarios run as they are, which with options of the command, and which are refused, and why.

    scripts/public-scenarios.py recreate FOLDER           small scenarios of the kinds that people publish
    scripts/public-scenarios.py fetch FOLDER              those of packages, by `pip download` and `apt-get download`
    scripts/public-scenarios.py try PROGRAM PATH...       a table of all configurations beneath these paths
    scripts/public-scenarios.py all PROGRAM FOLDER        all three, and counts by source; the table is FOLDER/table.csv

For each configuration the table has what `run --dry-run` and `signals` say, whether the options that the message has are
enough, whether plain `sumo` loads it and says why not, and, with --seconds N, whether `program` gives the delay of plain
`sumo` over N seconds. Configurations are tried in a copy, where `sumo` may write. Only the standard library, `sumo` and
`netgenerate` on the PATH, and for `fetch` `pip`, `apt-get` and `dpkg`.
"""

import argparse
import collections
import csv
import gzip
import json
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

PATIENCE_S = 300
COLUMNS = ["scenario", "taken", "options", "sumo_loads", "equal", "reason"]
WHEELS = ["sumo-rl==1.4.5", "sumo-experiments==5.8.4", "eclipse-sumo==1.28.0"]
DEBIAN = ["sumo-tools"]
NAMES = ["*.sumocfg", "*.sumo.cfg"]


def recreate(folder: Path) -> None:
    """Writes a scenario of every kind, on one network of four signals."""
    folder.mkdir(parents=True)
    net = folder / "n.net.xml"
    grid = "netgenerate --grid --grid.number 2 --grid.length 150 --grid.attach-length 150 --default.lanenumber 2"
    signals = "--tls.set A0,A1,B0,B1 --tls.cycle.time 60 --no-turnarounds"
    subprocess.run([*grid.split(), *signals.split(), "-o", net], check=True, capture_output=True)
    edges = [e for e in ET.parse(net).getroot().iter("edge") if not e.get("function")]
    lane = next(e for e in edges if e.get("to") == "A0").find("lane").get("id")
    edge = lane.rsplit("_", 1)[0]
    logic = ET.parse(net).getroot().find("tlLogic")
    tls = logic.get("id")
    starts = [e.get("id") for e in edges if len(e.get("from")) > 2 or not re.fullmatch(r"[AB][01]", e.get("from"))]
    ends = [e.get("id") for e in edges if not re.fullmatch(r"[AB][01]", e.get("to"))]
    flows = [
        f'<flow id="f{i}" begin="0" end="600" vehsPerHour="300" from="{a}" to="{b}"/>'
        for i, (a, b) in enumerate((a, b) for a in starts for b in ends[:3] if a.strip("-") != b.strip("-"))
    ][:12]
    routes = "<routes>" + "".join(flows) + "</routes>"
    (folder / "r.rou.xml").write_text(routes)
    night = "".join(f'<phase duration="9" state="{p.get("state")}"/>' for p in logic.iter("phase"))
    own = logic.get("programID")
    phases = [p.get("state") for p in logic.iter("phase")]
    whole = f'<e1Detector id="d1" lane="{lane}" pos="5" freq="60" file="e1.xml"/>'
    kinds: dict[str, tuple[str, str, str]] = {}  # options, additional file, route file

    def kind(name, options="", add="", rou="", end="<end value='600'/>"):
        kinds[name] = (options + end, add, rou)

    kind("plain")
    kind("e1", add=whole)
    kind("instant-e1", add=f'<instantInductionLoop id="i" lane="{lane}" pos="5" file="i.xml"/>')
    kind("e2", add=f'<laneAreaDetector id="d2" lane="{lane}" pos="5" endPos="40" period="60" file="e2.xml"/>')
    kind("e3", add=f'<e3Detector id="d3" period="60" file="e3.xml"><detEntry lane="{lane}" pos="5"/><detExit lane="{lane}" pos="40"/></e3Detector>')
    kind("edge-data", add='<edgeData id="m" freq="60" file="edges.xml"/>')
    kind("lane-data", add='<laneData id="m" freq="60" file="lanes.xml" withInternal="true"/>')
    kind("edges-file", add=f'<edgeData id="m" file="edges.xml" edgesFile="list.txt"/>')
    kind("tls-states", add=f'<timedEvent type="SaveTLSStates" source="{tls}" dest="tls.xml"/>')
    kind("tls-switches", add=f'<timedEvent type="SaveTLSSwitchTimes" source="{tls}" dest="tls.xml"/>')
    kind("route-probe", add=f'<routeProbe id="p" edge="{edge}" freq="60" file="probe.xml"/>')
    kind("type-probe", add='<vTypeProbe id="p" type="DEFAULT_VEHTYPE" freq="60" file="types.xml"/>')
    kind("safety-devices", "<device.ssm.probability value='0.1'/>", rou='<vType id="t"><param key="device.ssm.file" value="ssm.xml"/></vType>')
    kind("actuated-with-file", add=f'<tlLogic id="{tls}" type="actuated" programID="act"><param key="file" value="det.xml"/>' + "".join(f'<phase duration="20" minDur="5" maxDur="40" state="{s}"/>' for s in phases) + "</tlLogic>")
    kind("no-end", end="")
    kind("end-of-minus-one", end="<end value='-1'/>")
    kind("max-depart-delay", "<max-depart-delay value='60'/>")
    kind("teleports", "<time-to-teleport value='120'/><max-num-teleports value='50'/><time-to-teleport.highways value='60'/>")
    kind("collisions-remove", "<collision.action value='remove'/><collision.check-junctions value='true'/>")
    kind("validation", "<xml-validation value='local'/><xml-validation.net value='never'/>")
    kind("for-traci", "<remote-port value='8813'/><num-clients value='1'/>")
    kind("outputs-of-options", "<tripinfo-output value='t.xml'/><summary-output value='s.xml'/><fcd-output value='f.xml'/><queue-output value='q.xml'/><statistic-output value='st.xml'/><output-prefix value='x_'/><log value='l.txt'/>")
    kind("window", "<gui_only><start value='true'/><delay value='100'/><gui-settings-file value='v.xml'/></gui_only>")
    kind("day-plan", add=f'<tlLogic id="{tls}" type="static" programID="night" offset="0">{night}</tlLogic><WAUT id="w" refTime="0" startProg="night"><wautSwitch time="200" to="{own}"/></WAUT><wautJunction wautID="w" junctionID="{tls}"/>')
    kind("calibrator", add=f'<calibrator id="c" lane="{lane}" pos="0" output="cal.xml"><flow begin="0" end="600" vehsPerHour="400" speed="10"/></calibrator>')
    kind("vaporizer", add=f'<vaporizer id="{edge}" begin="0" end="60"/>')
    kind("mesoscopic", "<mesosim value='true'/>")
    kind("step-of-a-tenth", "<step-length value='0.1'/>")
    kind("step-that-does-not-divide", "<step-length value='0.3'/>")
    kind("like-bologna", "<max-depart-delay value='0'/><tripinfo-output value='t.xml'/>", add=whole + '<edgeData id="m" file="edges.xml"/><vType id="bus" vClass="bus"/>', end="")
    kind("like-a-tutorial", "<report><no-step-log value='true'/></report>", add='<edgeData id="m" file="edges.xml"/>', end="")
    kind("rerouter", add=f'<route id="x" edges="{edge}"/><rerouter id="r" edges="{edge}"><interval begin="0" end="60"><routeProbReroute id="x" probability="0"/></interval></rerouter>')
    kind("speed-sign", add=f'<variableSpeedSign id="v" lanes="{lane}"><step time="0" speed="8"/></variableSpeedSign>')
    kind("unsorted", rou=f'<trip id="b" depart="90" from="{starts[0]}" to="{ends[1]}"/><trip id="a" depart="5" from="{starts[0]}" to="{ends[1]}"/>')
    kind("phemlight", rou='<vType id="p" emissionClass="PHEMlight/PC_G_EU4"/>')
    kind("without-tripinfo", rou='<vType id="p"><param key="has.tripinfo.device" value="false"/></vType>')
    kind("newer-header", add="<!-- generated by Eclipse SUMO Version 1.30.0 -->")
    kind("bus-stops", add=f'<busStop id="s" lane="{lane}" startPos="10" endPos="30"/>')
    kind("unreached-phases", add=f'<tlLogic id="{tls}" type="static" programID="zz">' + "".join(f'<phase duration="15" state="{s}" next="{(i + 1) % len(phases)}"/>' for i, s in enumerate(phases)) + f'<phase duration="15" state="{"r" * len(phases[0])}"/><phase duration="9" state="G{"r" * (len(phases[0]) - 1)}"/></tlLogic>')
    kind("latin-1", add="<!-- Straße -->")
    kind("rail-option", "<railsignal-moving-block value='false'/><device.rerouting.probability value='0.2'/><device.rerouting.period value='60'/>")
    kind("sublane", "<lateral-resolution value='0.8'/>")
    kind("scaled", "<scale value='1.5'/>")
    kind("file-that-is-missing", "<weight-files value='w.xml'/>")
    kind("route-on-an-unknown-edge", rou='<vehicle id="x" depart="0"><route edges="nowhere"/></vehicle>')
    kind("option-that-sumo-does-not-know", "<new-option value='1'/>")
    kind("xml-that-is-not-closed", rou="</broken>")
    for name, (options, add, rou) in kinds.items():
        at = folder / name
        at.mkdir()
        shutil.copy(net, at / "n.net.xml")
        (at / "r.rou.xml").write_text(routes.replace("<routes>", "<routes>" + (rou if rou.startswith("<vType") else "")).replace("</routes>", ("" if rou.startswith("<vType") else rou) + "</routes>"))
        encoding = "iso-8859-1" if name == "latin-1" else "utf-8"
        (at / "a.add.xml").write_text(f'<?xml version="1.0" encoding="{encoding}"?>\n<additional>{add}</additional>', encoding=encoding)
        inputs = "<net-file value='n.net.xml'/><route-files value='r.rou.xml'/><additional-files value='a.add.xml'/>"
        (at / f"{name}.sumocfg").write_text(f"<configuration>{inputs}{options}</configuration>")
    packed = folder / "compressed"
    shutil.copytree(folder / "e1", packed)
    for file in ["n.net.xml", "r.rou.xml"]:
        (packed / f"{file}.gz").write_bytes(gzip.compress((packed / file).read_bytes()))
        (packed / file).unlink()
    text = (packed / "e1.sumocfg").read_text().replace("n.net.xml", "n.net.xml.gz").replace("r.rou.xml", "r.rou.xml.gz")
    (packed / "compressed.sumocfg").write_text(text)
    (packed / "e1.sumocfg").unlink()
    included = folder / "included"
    shutil.copytree(folder / "e1", included)
    (included / "sub").mkdir()
    shutil.move(included / "a.add.xml", included / "sub/b.add.xml")
    (included / "a.add.xml").write_text("<additional><include href='sub/b.add.xml'/></additional>")
    (included / "e1.sumocfg").rename(included / "included.sumocfg")


def call(arguments, cwd, patience=PATIENCE_S):
    """Returns exit code and standard error; 124 when it took too long."""
    try:
        done = subprocess.run([str(a) for a in arguments], cwd=cwd, capture_output=True, text=True, errors="replace", timeout=patience)
        return done.returncode, done.stderr
    except subprocess.TimeoutExpired:
        return 124, "it took too long"


def error(said: str) -> str:
    """Returns what stands behind the last `error:`."""
    return said.rsplit("error: ", 1)[-1].strip()


def why_sumo_does_not_load(config: Path) -> str:
    """Returns the first error of plain `sumo`; nothing where it loads a configuration."""
    options = "--no-step-log --no-warnings --xml-validation never --remote-port 0 --num-clients 1 --duration-log.disable"
    begin = re.search(r"<(?:begin|b)\b[^>]*(?:value|v)=[\"']([^\"']+)", config.read_text(errors="replace"))
    end = float(begin.group(1)) + 1 if begin and re.fullmatch(r"[\d.]+", begin.group(1)) else 1
    code, said = call(["sumo", "-c", config, *options.split(), "--end", end], config.parent)
    errors = [line.removeprefix("Error: ") for line in said.splitlines() if line.startswith("Error: ")]
    return "" if code == 0 else (errors or [f"exit code {code}"])[0]


def equal(program, config: Path, passed, seconds: float) -> str:
    """Whether `program` gives the delay of plain `sumo` over some seconds."""
    begin = re.search(r"<(?:begin|b)\b[^>]*(?:value|v)=[\"']([\d.]+)[\"']", config.read_text(errors="replace"))
    begin = float(begin.group(1)) if begin else 0.0
    with tempfile.TemporaryDirectory() as scratch:
        passed = [word for before, word in zip(["", *passed], passed) if "--end" not in (before, word)]
        options = [*passed, "--end", begin + seconds, "--begin", begin]
        command = [program, "run", "--sumocfg", config, "--methods", "program", "--eval-seeds", 1, "--quiet", "--out", "r", *options]
        code, said = call(command, scratch)
        if code != 0:
            return f"no: {error(said)[:200]}"
        lines = (Path(scratch) / "r/done/000/1.jsonl").read_text().splitlines()
        row = json.loads(lines[1])
        sumo = f"--no-step-log --no-warnings --xml-validation never --seed {row['seed']} --begin {begin} --end {begin + seconds}"
        sumo += " --time-to-teleport -1 --max-depart-delay -1 --max-num-teleports -1 --remote-port 0 --mesosim false"
        sumo += " --tls.all-off false" if "signals-on" in passed else ""
        sumo += f" --step-length {passed[passed.index('--step-length') + 1]}" if "--step-length" in passed else ""
        sumo += " --time-to-teleport.highways 0 --duration-log.disable"
        sumo += " --tripinfo-output.write-unfinished --tripinfo-output.write-undeparted"
        trips = Path(scratch) / "trips.xml"
        command = ["sumo", "-c", config, *sumo.split(), "--output-prefix", "", "--tripinfo-output", trips]
        code, said = call(command, config.parent)
        if code != 0 or not trips.exists():
            return f"sumo: {said.strip()[-200:]}"
        delays = [float(t.get("timeLoss")) + float(t.get("departDelay")) for t in ET.parse(trips).getroot().iter("tripinfo")]
        own = row["metrics"]["delay_s"]
        mean = sum(delays) / len(delays) if delays else float("nan")
        return "equal" if abs(mean - own) < 1e-9 * max(1.0, own) else f"differs: {own} and {mean}"


def judge(program, config: Path, seconds: float):
    """Returns how a configuration is taken, with what options, and why not."""
    with tempfile.TemporaryDirectory() as scratch:
        dry = [program, "run", "--sumocfg", config, "--methods", "program", "--quiet", "--dry-run"]
        codes = [call(dry, scratch), call([program, "signals", config, "--json"], scratch)]
        wrong = [said for code, said in codes if code != 0]
        if not wrong:
            return "as it is", [], "", equal(program, config, [], seconds) if seconds else ""
        options = re.findall(r"pass ((?:--[a-z-]+ \S+ ?)+)", error(wrong[0]))
        passed = options[-1].split() if options else []
        passed = [" ".join(passed[i:i + 2]) for i in range(0, len(passed), 2)]
        flat = [word for option in passed for word in option.split()]
        if passed and all(call([*command, *flat], scratch)[0] == 0 for command in [dry, [program, "signals", config, "--json"]]):
            return f"with {len(passed)} option{'s' if len(passed) > 1 else ''}", passed, "", equal(program, config, flat, seconds) if seconds else ""
        return "refused", passed, error(wrong[0]), ""


def fetch(folder: Path) -> None:
    """Unpacks packages that have scenarios, each in a folder of its name."""
    folder.mkdir(parents=True, exist_ok=True)
    for package in WHEELS:
        with tempfile.TemporaryDirectory() as scratch:
            command = ["pip", "download", "--quiet", "--no-deps", "--only-binary", ":all:", package, "-d", scratch]
            subprocess.run(command, check=True)
            zipfile.ZipFile(next(Path(scratch).glob("*.whl"))).extractall(folder / package.replace("==", "-"))
    for package in DEBIAN:
        with tempfile.TemporaryDirectory() as scratch:
            subprocess.run(["apt-get", "-qq", "download", package], cwd=scratch, check=True)
            subprocess.run(["dpkg", "-x", next(Path(scratch).glob("*.deb")), folder / package], check=True)


def rows(program: Path, root: Path, seconds: float):
    """Yields a row for each configuration of a file's folder or of a folder."""
    with tempfile.TemporaryDirectory() as scratch:
        top = root.resolve() if root.is_dir() else root.resolve().parent
        copy = Path(scratch).resolve() / "copy"
        shutil.copytree(top, copy, symlinks=True)
        names = NAMES if root.is_dir() else [root.name]
        for config in sorted(f for name in names for f in copy.rglob(name)):
            taken, options, reason, same = judge(program, config, seconds)
            why_not = why_sumo_does_not_load(config)
            loads = f"no: {why_not}" if why_not else "yes"
            cells = [str(config.relative_to(copy)), taken, " ".join(options), loads, same, " | ".join(reason.split("\n"))]
            yield [cell.replace(f"{copy}/", "")[:400] for cell in cells]


def kind_of(row) -> str:
    """Returns the column of the counts that a row belongs to."""
    _, taken, _, loads, _, reason = row
    if taken != "refused":
        return taken
    if "it has no traffic signal" in reason or "neither it nor any other signal" in reason:
        return "no signal"
    return "refused by SUMO too" if loads != "yes" else "refused here only"


def reason_of(row) -> str:
    """Returns why a row is refused, without what differs from one scenario to the next."""
    _, _, _, loads, _, reason = row
    said = loads.removeprefix("no: ") if loads != "yes" else reason
    if kind_of(row) == "no signal":
        return "no signal that gives green to cars"
    if re.search("not accessible", said):
        return "a file is missing"
    return re.sub(r"'[^']*'", "'...'", said)


def counts(table) -> str:
    """Returns the counts by source in Markdown, and the reasons of what is refused."""
    kinds = ["as it is", "with 1 option", "with 2 options", "no signal", "refused by SUMO too", "refused here only"]
    lines = [f"| source | scenarios | {' | '.join(kinds)} | equal |", f"| --- |{' ---: |' * (len(kinds) + 2)}"]
    every = [row for of in table.values() for row in of]
    for source, of in [*table.items(), ("all", every)]:
        found = collections.Counter(kind_of(row) for row in of)
        assert set(found) <= set(kinds), found
        equals = sum(row[4] == "equal" for row in of)
        run = sum(row[1] != "refused" for row in of)
        lines.append(f"| {source} | {len(of)} | {' | '.join(str(found[kind]) for kind in kinds)} | {equals} of {run} |")
    refused = [(source, reason_of(row)) for source, of in table.items() for row in of if row[1] == "refused"]
    by = collections.Counter(refused)
    lines += ["", "| source | reason | scenarios |", "| --- | --- | ---: |"]
    lines += [f"| {source} | {reason} | {number} |" for (source, reason), number in by.items()]
    unequal = [(source, row) for source, of in table.items() for row in of if row[1] != "refused" and row[4] not in ("", "equal")]
    lines += ["", *(f"- {source}, {row[0]}: {' '.join(row[4].split())}" for source, row in unequal)]
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    for name in ["recreate", "fetch"]:
        commands.add_parser(name).add_argument("folder", type=Path)
    trial = commands.add_parser("try")
    trial.add_argument("program", type=Path)
    trial.add_argument("paths", type=Path, nargs="+")
    everything = commands.add_parser("all")
    everything.add_argument("program", type=Path)
    everything.add_argument("folder", type=Path)
    for command in [trial, everything]:
        command.add_argument("--seconds", type=float, default=0)
    args = parser.parse_args()
    if args.command in ["recreate", "fetch"]:
        return {"recreate": recreate, "fetch": fetch}[args.command](args.folder)
    program = args.program.resolve()
    if args.command == "try":
        table = csv.writer(sys.stdout)
        table.writerow(COLUMNS)
        for root in args.paths:
            for row in rows(program, root, args.seconds):
                table.writerow(row)
                sys.stdout.flush()
        return None
    fetched, recreated = args.folder / "fetched", args.folder / "recreated"
    if not fetched.exists():
        fetch(fetched)
    if not recreated.exists():
        recreate(recreated)
    found = {folder.name: list(rows(program, folder, args.seconds)) for folder in [*sorted(fetched.iterdir()), recreated]}
    with open(args.folder / "table.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["source", *COLUMNS])
        table.writerows([source, *row] for source, of in found.items() for row in of)
    print(counts(found))
    return None


if __name__ == "__main__":
    main()
