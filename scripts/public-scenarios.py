#!/usr/bin/env python3
"""Which public SUMO scenarios run as they are, which with options of the command, and which are refused, and why.

    scripts/public-scenarios.py PROGRAM FOLDER [--seconds N]

A folder that does not exist gets the scenarios of packages, by `pip download` and `apt-get download`. For each configuration the
table on standard output has what `run --dry-run` and `signals` say, whether the options that the message has are enough, whether
plain `sumo` loads it, and, with --seconds, whether `program` gives the delay of plain `sumo` over so many seconds.
Configurations are tried in a copy, where `sumo` may write.
"""

import argparse
import collections
import csv
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
        copy = Path(scratch).resolve() / "copy"
        shutil.copytree(root, copy, symlinks=True)
        for config in sorted(f for name in NAMES for f in copy.rglob(name)):
            taken, options, reason, same = judge(program, config, seconds)
            why_not = why_sumo_does_not_load(config)
            loads = f"no: {why_not}" if why_not else "yes"
            cells = [str(config.relative_to(copy)), taken, " ".join(options), loads, same, " | ".join(reason.split("\n"))]
            yield [cell.replace(f"{copy}/", "")[:400] for cell in cells]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=0)
    args = parser.parse_args()
    if not args.folder.exists():
        fetch(args.folder)
    table = csv.writer(sys.stdout)
    table.writerow(["source", *COLUMNS])
    taken = collections.Counter()
    for source in sorted(args.folder.iterdir()):
        for row in rows(args.program.resolve(), source, args.seconds):
            table.writerow([source.name, *row])
            sys.stdout.flush()
            taken[row[1]] += 1
    print(dict(taken), file=sys.stderr)


if __name__ == "__main__":
    main()
