#!/usr/bin/env python3
"""What an executor adds to short tasks, and how it scales: workers of this machine, GNU parallel, Slurm.

    scripts/overhead.py PROGRAM [--repeats 3] [--tasks 60]     with SLURM_CONF set (scripts/slurm.sh up DIR), Slurm too

All variants take turns in one run. Per variant: the wall time from before the command until every task has its record
(median), and the overhead per task: places of work times that time, less what the workers say the tasks took (`wall_s`),
per task. Slurm's time is that from submission, with its queue.
"""

import argparse
import json
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

RUN = ["run", "--methods", "max-pressure,actuated", "--eval-seeds", "2", "--quiet", "--networks", "networks",
       "--set", "demand.horizon_s=300"]


def finished(out, tasks):
    """Waits until every task has its record."""
    while sum(1 for _ in out.glob("done/*/*.jsonl")) < tasks:
        time.sleep(0.02)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--tasks", type=int, default=60)
    args = parser.parse_args()
    program = str(args.program.resolve())
    points = args.tasks // 3
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        here.chmod(0o755)

        def tsc(*words):
            subprocess.run([program, *words], cwd=here, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

        run = [*RUN, "--budget", str(points)]
        tsc(*run, "--out", "first")
        tasks = len((here / "first/plan.jsonl").read_text().splitlines())

        def local(workers, out):
            tsc(*run, "--out", out, "--jobs", str(workers))

        def parallel(workers, out):
            tsc(*run, "--out", out, "--executor", "script", "--job-minutes", "0.1")
            job = next((here / out / "jobs").glob("*"))
            packs = len((job / "packs.jsonl").read_text().splitlines())
            numbers = "\n".join(map(str, range(packs)))
            command = ["parallel", f"-j{workers}", str(job / "job.sh")]
            subprocess.run(command, input=numbers, text=True, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

        def slurm(nodes, out):
            tsc(*run, "--out", out, "--executor", "slurm", "--job-minutes", "0.1")
            finished(here / out, tasks)

        variants = [("this machine", local, 1), ("this machine", local, 2)]
        if shutil.which("parallel"):
            variants += [("GNU parallel", parallel, 1), ("GNU parallel", parallel, 2)]
        nodes = 0
        if shutil.which("sinfo"):
            said = subprocess.run(["sinfo", "-h", "-o", "%D"], capture_output=True, text=True)
            nodes = int(said.stdout.split()[0]) if said.returncode == 0 and said.stdout.split() else 0
        if nodes:
            variants.append(("Slurm", slurm, nodes))
        seen = {}
        for k in range(args.repeats):
            for name, do, places in variants:
                out = f"{name.replace(' ', '-')}-{places}-{k}"
                begin = time.monotonic()
                do(places, out)
                wall = time.monotonic() - begin
                records = (path.read_text().splitlines()[0] for path in (here / out).glob("done/*/*.jsonl"))
                walls = [json.loads(line)["wall"]["wall_s"] for line in records]
                if len(walls) != tasks:
                    sys.exit(f"{out} has {len(walls)} records of {tasks}")
                seen.setdefault((name, places), []).append((wall, sum(walls)))
        for (name, places), values in seen.items():
            wall, within = (statistics.median(column) for column in zip(*values))
            print(json.dumps({"executor": name, "places": places, "tasks": tasks, "repeats": len(values),
                              "wall_s": round(wall, 2), "tasks_s": round(within, 2),
                              "overhead_per_task_s": round((places * wall - within) / tasks, 3)}))


if __name__ == "__main__":
    main()
