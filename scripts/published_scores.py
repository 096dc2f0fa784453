#!/usr/bin/env python3
"""Writes the published scores that come with the program: they assist samples, and reports and Python compare with them.

    scripts/published_scores.py data/published/salt-lake-city-resco.json results/salt-lake-city/{resco,nema-resco,learners-validated,ippo-validated-20}

Every folder is a results directory, packed or not, of one scenario and preset; its report is made where it has none. The
settings are those of the second folder, of which the others may lack only what they did not know yet: `--settings DIR` names
another one, such as a new run of the baseline on one point MDP. `--assisting` names the methods whose scores assist beside the
baseline. The default are those of the study in results/salt-lake-city/analyses.md: of near twins one is enough, and with `nema`
errors of learners were up to twice as large. BINARY is the program [default: tsc-family].
"""

import argparse
import csv
import json
import lzma
import os
import pathlib
import shutil
import subprocess
import tempfile

# Sections that no score of a method without learning depends on.
OTHERS = {"title", "training", "coordinated", "nema_coordinated", "retime", "existing", "program"}


def manifest_of(folder):
    packed = folder / "run.jsonl.xz"
    if packed.exists():
        with lzma.open(packed, "rt") as file:
            return json.loads(json.loads(file.readline())["manifest.json"])
    return json.loads((folder / "manifest.json").read_text())


def tables(folder, program, work):
    """Returns the rows of summary.csv and scores.csv; the report is made in a copy."""
    copy = work / folder.name
    shutil.copytree(folder, copy)
    subprocess.run([program, "report", copy], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return [list(csv.DictReader((copy / "report" / name).open())) for name in ("summary.csv", "scores.csv")]


def section(method):
    return method.replace("-", "_")


def without_learners(settings, learners):
    return {key: value for key, value in settings.items() if key not in OTHERS and not key.startswith(learners)}


def agree(known, given, where):
    """Checks that two settings agree in all that both have."""
    for key in known.keys() & given.keys():
        if isinstance(known[key], dict) and isinstance(given[key], dict):
            agree(known[key], given[key], f"{where}.{key}")
        elif known[key] != given[key]:
            raise SystemExit(f"{where}.{key} is {given[key]!r}, and {known[key]!r} in the settings that count")


def number(text, digits):
    return float(f"{float(text):.{digits}g}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("folders", type=pathlib.Path, nargs="+")
    parser.add_argument("--settings", type=pathlib.Path)
    parser.add_argument("--assisting", default="fixed-time,max-pressure,actuated")
    args = parser.parse_args()
    program = os.environ.get("BINARY", "tsc-family")
    version = subprocess.run([program, "--version"], check=True, capture_output=True, text=True).stdout.split()[1]
    counts = manifest_of(args.settings or args.folders[min(1, len(args.folders) - 1)])["identity"]
    learners = ("idqn", "ippo", "mplight")
    settings = without_learners(counts["settings"], learners)
    rows, inputs, values, importance = [], [], {}, {}
    with tempfile.TemporaryDirectory() as work:
        for folder in args.folders:
            identity = manifest_of(folder)["identity"]
            agree(settings, without_learners(identity["settings"], learners), str(folder))
            for key in ("scenario", "simulator", "objective", "baseline"):
                if identity[key] != counts[key]:
                    raise SystemExit(f"{folder}: {key} is {identity[key]}, not {counts[key]}")
            summary, scores = tables(folder, program, pathlib.Path(work))
            for row in summary:
                method = row["method"]
                if not row["rank"] or any(method == known["method"] for known in rows):
                    continue
                learns = method.startswith(learners)
                known = {"method": method, "score": number(row["overall"], 6), "points": int(row["points"])}
                known |= {"low": number(row["overall_low"], 6), "high": number(row["overall_high"], 6), "learns": learns}
                if method not in [identity["baseline"], *args.assisting.split(",")]:
                    own, read = identity["settings"], [section(method), *(["training"] if learns else [])]
                    known["settings"] = {key: own[key] for key in read if key in own}
                    settings.pop(section(method), None)
                rows.append(known)
                if method != identity["baseline"] and method not in args.assisting.split(","):
                    continue
                if learns or int(row["points"]) != int(row["family_size"]):
                    raise SystemExit(f"{method} cannot assist: it learns, or has not all point MDPs")
                own = [s for s in scores if s["method"] == method and s["replicate"] == "0"]
                importance.update((s["point"], number(s["importance"], 10)) for s in own)
                measure = identity["objective"] if method == identity["baseline"] else "score"
                # The baseline comes first.
                place = 0 if method == identity["baseline"] else len(inputs)
                inputs.insert(place, method)
                for s in own:
                    values.setdefault(s["point"], []).insert(place, number(s[measure], 6))
    if inputs[:1] != [counts["baseline"]] or any(len(v) != len(inputs) for v in values.values()):
        raise SystemExit("not every method has a score on every point MDP, or the baseline is missing")
    order = [point["point"] for point in manifest_of(args.folders[0])["identity"]["points"]]
    head = {"version": version, "scenario": counts["scenario"], "simulator": counts["simulator"], "settings": settings}
    lines = [f'"{key}":{json.dumps(value, sort_keys=True, separators=(",", ":"))}' for key, value in head.items()]
    of = lambda rows: "[\n" + ",\n".join(json.dumps(row, separators=(",", ":")) for row in rows) + "\n]"  # noqa: E731
    lines += [f'"methods":{of(sorted(rows, key=lambda row: row["score"]))}', f'"inputs":{json.dumps(inputs)}']
    lines += [f'"points":{of([[point, importance[point], *values[point]] for point in order])}']
    args.out.write_text("{" + ",\n".join(lines) + "}\n")


if __name__ == "__main__":
    main()
