#!/usr/bin/env python3
"""Does random faults over short plans with a learner, and says what became of them.

    python3 scripts/faults PROGRAM [--faults 200] [--seed 0] [--dir faults] [--kinds WORD,...] [--other PROGRAM] [--table FILE]

After every fault the same command is run again, and what its messages say is done, until the run is whole; what it
ends with is compared with an undisturbed run's, byte for byte but for wall-clock times. Counted are finished work
that is lost (records and models that were whole, and are gone or were done again), wrong results (anything that was
accepted and differs), commands that hang, and messages that do not say what to do. Killed itself, the same command
goes on after the last fault. Only root can mount small disks, another libsumo takes a C compiler, and
another build has to be given; without them these faults are left out.
"""

import argparse
import collections
import json
import random
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import damage  # noqa: E402
import disturb  # noqa: E402
import strange  # noqa: E402
from work import PLANS, Work  # noqa: E402

KINDS = {
    "the program is killed or told to end": disturb.ended,
    "the program is stopped for a while": disturb.stopped,
    "workers are killed": disturb.workers,
    "a worker is stopped for good": disturb.worker_stopped,
    "a worker goes on beside its copy": disturb.zombie,
    "netconvert is killed, stopped or crashes": disturb.netconvert,
    "everything is killed at once": disturb.all_at_once,
    "a training is killed between checkpoints": disturb.learner,
    "the command is given twice": disturb.second,
    "limits of memory and files": disturb.limits,
    "a small disk fills and empties": disturb.disk,
    **{f"{kind} is damaged": damage.at_rest(kind) for kind in damage.FILES},
    "files are exchanged": damage.exchanged,
    "files are damaged while tasks run": damage.meanwhile,
    "several files are damaged": damage.everything,
    "the results folder has a strange name": strange.places,
    "files are links to somebody else's": strange.links,
    "another build begins the run": strange.builds,
    "another libsumo is found": strange.libraries,
    "an input is nested or inflated": strange.inputs,
}


def prepare(folder, program):
    """Does the plans undisturbed, and once more with another seed; returns how long each takes, seconds."""
    known = folder / "seconds.json"
    if known.exists():
        return json.loads(known.read_text())
    seconds = {}
    for plan in PLANS:
        for name, more in ((plan, []), (f"{plan}-seed-1", ["--seed", "1"])):
            shutil.rmtree(folder / "undisturbed" / name, ignore_errors=True)
            work = Work(folder / "undisturbed" / name, program, plan, folder / "undisturbed")
            work.folder.mkdir(parents=True)
            for _ in range(2):
                shutil.rmtree(work.out, ignore_errors=True)
                start = time.monotonic()
                code, text = work.call(*work.arguments(*more))
                if code != 0:
                    sys.exit(f"the undisturbed run failed: {text}")
            seconds[plan] = time.monotonic() - start
    known.write_text(json.dumps(seconds))
    return seconds


def one(folder, programs, seed, number, names, seconds):
    """Does one fault and returns what became of it."""
    rng = random.Random(f"{seed}/{number}")
    kind = names[number % len(names)]
    # Only the second plan has places.
    plan = "salt-lake-city" if "places" in kind else rng.choice(list(PLANS))
    place = folder / f"fault-{number}"
    subprocess.run(["umount", place], capture_output=True)
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    work = Work(place, programs[0], plan, folder / "undisturbed")
    work.other = programs[1]
    work.seconds = seconds[plan]
    start = time.monotonic()
    what = KINDS[kind](work, rng)
    if what is not None:
        if work.recover():
            work.judge()
    lost = work.lost() if what is not None else []
    result = {
        "number": number, "kind": kind, "plan": plan, "what": what, "lost": lost, "wrong": work.wrong,
        "hangs": work.hangs, "without_way": work.without_way, "said": work.said,
        "seconds": round(time.monotonic() - start, 1),
    }  # fmt: skip
    subprocess.run(["umount", place], capture_output=True)
    if not (lost or work.wrong or work.hangs or work.without_way):
        shutil.rmtree(place)
        for said in folder.glob(f"fault-{number}.said-*"):
            said.unlink()
    return result


def plain(said):
    """Returns a message without what differs from one fault to the next."""
    said = re.sub(r"(?:out|networks)/[\w./+-]+", lambda m: "…/" + m[0].rstrip(".").rsplit("/", 1)[-1], said)
    return re.sub(r"\b[0-9a-f]{12,}\b|\b\d+(\.\d+)?\b", "N", said).replace("|", "\\|")


def table(results):
    """Returns the table of faults."""
    rows = ["| fault | times | finished work lost | wrong results | hangs | no way out | said most often |",
            "| --- | ---: | ---: | ---: | ---: | ---: | --- |"]  # fmt: skip
    by_kind = collections.defaultdict(list)
    for result in results:
        by_kind[result["kind"]].append(result)
    total = [0] * 5
    for kind, found in by_kind.items():
        done = [r for r in found if r["what"] is not None]
        counts = [len(done), sum(len(r["lost"]) for r in done), sum(len(r["wrong"]) for r in done),
                  sum(r["hangs"] for r in done), sum(len(r["without_way"]) for r in done)]  # fmt: skip
        total = [a + b for a, b in zip(total, counts)]
        said = collections.Counter(plain(s) for r in done for s in r["said"])
        often = said.most_common(1)[0][0] if said else ""
        rows.append(f"| {kind} | {' | '.join(map(str, counts))} | {often} |")
    rows.append(f"| all | {' | '.join(map(str, total))} | |")
    return "\n".join(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--faults", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--dir", type=Path, default=Path("faults"))
    parser.add_argument("--kinds", default="", help="only kinds with one of these words")
    parser.add_argument("--other", type=Path, help="another build of the program, which begins some runs")
    parser.add_argument("--table", type=Path, help="also write the table there")
    args = parser.parse_args()
    program, folder = args.program.resolve(), args.dir.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    names = [k for k in KINDS if not args.kinds or any(word in k for word in args.kinds.split(","))]
    if not names:
        sys.exit(f"no such kind; there are: {', '.join(KINDS)}")
    seconds = prepare(folder, program)
    journal = folder / f"seed-{args.seed}{'-' + args.kinds if args.kinds else ''}.jsonl"
    results = [json.loads(line) for line in journal.read_text().splitlines()] if journal.exists() else []
    done = {result["number"] for result in results}
    for number in range(args.faults):
        if number in done:
            continue
        result = one(folder, (program, args.other and args.other.resolve()), args.seed, number, names, seconds)
        with journal.open("a") as file:
            file.write(json.dumps(result) + "\n")
        results.append(result)
        bad = {k: result[k] for k in ("lost", "wrong", "hangs", "without_way") if result[k]}
        state = "left out: something that it takes is missing" if result["what"] is None else bad or "whole"
        print(f"{number} {result['kind']} ({result['plan']}: {result['what']}), {result['seconds']} s: {state}", flush=True)
    text = table(results)
    print(text)
    if args.table:
        args.table.write_text(text + "\n")
    bad = [r for r in results if r["lost"] or r["wrong"] or r["hangs"] or r["without_way"]]
    print(f"{len(bad)} of {len(results)} faults did what they must not" + (f"; see {folder}" if bad else ""))
    sys.exit(1 if bad else 0)


main()
