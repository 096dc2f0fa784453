#!/usr/bin/env python3
"""What an executor adds to 60 short tasks: workers of this machine, and packs of `--executor script` by xargs.

    scripts/overhead.py PROGRAM

Both take turns, three times. Printed are medians: the wall time from the command until every task has its record, what the
workers say the tasks took, and the difference per task and place of work.
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PLACES = 2
RUN = "run --budget 20 --methods max-pressure,actuated --eval-seeds 2 --quiet --networks networks --set demand.horizon_s=300"


def main():
    program = str(Path(sys.argv[1]).resolve())
    with tempfile.TemporaryDirectory() as folder:

        def tsc(words):
            subprocess.run([program, *words.split()], cwd=folder, check=True, stdout=subprocess.DEVNULL)

        def local(out):
            tsc(f"{RUN} --out {out} --jobs {PLACES}")

        def packs(out):
            tsc(f"{RUN} --out {out} --executor script --job-minutes 0.1")
            job = Path(folder) / out / "jobs/000"
            numbers = "\n".join(map(str, range(len((job / "packs.jsonl").read_text().splitlines()))))
            command = ["xargs", "-P", str(PLACES), "-n", "1", str(job / "job.sh")]
            subprocess.run(command, input=numbers, text=True, check=True, stdout=subprocess.DEVNULL)

        tsc(f"{RUN} --out first")
        seen = {}
        for k in range(3):
            for do in (local, packs):
                out, begin = f"{do.__name__}-{k}", time.monotonic()
                do(out)
                wall_s = time.monotonic() - begin
                records = (Path(folder) / out).glob("done/*/*.jsonl")
                tasks = [json.loads(p.read_text().splitlines()[0])["wall"]["wall_s"] for p in records]
                seen.setdefault(do.__name__, []).append((wall_s, sum(tasks), len(tasks)))
        for name, values in seen.items():
            wall_s, tasks_s, tasks = (statistics.median(column) for column in zip(*values))
            overhead = (PLACES * wall_s - tasks_s) / tasks
            print(f"{name}: {wall_s:.2f} s, tasks {tasks_s:.2f} s, overhead per task {overhead:.3f} s")


main()
