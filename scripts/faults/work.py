"""A folder in which a run goes on: its commands, its processes, what is in it, and what has been seen there."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

SAME_RECORDS = Path(__file__).resolve().parent.parent / "same-records.py"
# Seconds after which a command that says nothing counts as hanging.
PATIENCE_S = 120
# Short plans with a learner. Of the second one the intersections are known.
PLANS = {
    "smoke": "smoke --methods baseline,max-pressure,idqn --episodes 12 --eval-seeds 2 --budget 2",
    "salt-lake-city": "salt-lake-city --methods baseline,max-pressure,idqn --episodes 4 --eval-seeds 1 --budget 2"
    " --set demand.horizon_s=120",
}
# What a message may tell to do; the first that fits is done.
WAYS = [
    (r"check [^;]*--repair|--repair sets", "repair"),
    (r"delete (it|the file|these files|them)\b", "delete"),
    (r"build-networks.{0,30}--force", "rebuild"),
    (r"restore", "restore"),
    (r"remove it\b", "delete"),
    (r"same command|run again|is the disk full|No space left|repeat the first command|try again|is in use by|raise it", "again"),
    # The system's words for a limit say what is used up, as those for a disk do.
    (r"Too many open files|Cannot allocate memory|File too large", "again"),
    (r"--retry-failed", "retry"),
    (r"install SUMO", "again"),
    # A folder that SUMO cannot take as a path.
    (r"another (folder|--out)|rename", "again"),
]


def read(path):
    try:
        return path.read_bytes()
    except OSError:
        return None


class Work:
    """A folder with `out` and `networks`, and all that was observed there."""

    def __init__(self, folder, program, plan, others):
        self.folder, self.program, self.plan, self.others = Path(folder), program, plan, others
        self.out, self.networks = self.folder / "out", self.folder / "networks" / plan
        # Finished work: path within the folder to bytes.
        self.finished = {}
        # Tasks whose files the fault damaged, which may be done again.
        self.damaged = set()
        self.said, self.without_way, self.hangs, self.wrong = [], [], 0, []
        self.started = 0

    @property
    def undisturbed(self):
        """The same plan, never disturbed."""
        return self.others / self.plan

    def arguments(self, *more):
        return ["run", *PLANS[self.plan].split(), "--jobs", "2", "--out", "out", *more]

    def start(self, arguments):
        """Starts a command in a session of its own."""
        # Beside the folder, which may be full.
        self.started += 1
        path = self.folder.with_suffix(f".said-{self.started}")
        process = subprocess.Popen(
            [self.program, *arguments],
            cwd=self.folder,
            stdin=subprocess.DEVNULL,
            stdout=open(path, "wb"),
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env={**os.environ, "NO_COLOR": "1", "RUST_BACKTRACE": "0"},
        )
        process.said, process.command = path, arguments[0]
        return process

    def end(self, process):
        """Waits for a command; returns its exit code and what it said. One that fails has to say what to do."""
        try:
            code = process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.hangs += 1
            code = None
            for pid, _ in self.processes():
                kill(pid, signal.SIGKILL)
            process.wait()
        text = (read(process.said) or b"").decode(errors="replace")
        # Without memory nothing can be said.
        crashed = "panicked" in text or (code or 0) > 130
        if crashed and not re.search(r"allocate memory|memory allocation of", text):
            self.wrong.append(f"a panic or crash: {text[-300:]}")
        # That records are missing is what `check` was asked for.
        elif (code or 0) > 0 and (process.command, code) != ("check", 6):
            error = message(text)
            self.said.append(error)
            if not way(text):
                self.without_way.append(f"{process.command}: {error}")
        return code, text

    def call(self, *arguments):
        """Runs a command to its end, which nothing from outside brings about."""
        code, text = self.end(self.start(arguments))
        if (code or 0) < 0:
            self.wrong.append(f"{arguments[0]} was ended by signal {-code}")
        return code, text

    def processes(self):
        """Returns process id and kind of what works in the folder: `run`, `worker`, `netconvert`."""
        found = []
        for entry in os.listdir("/proc"):
            if not entry.isdigit():
                continue
            try:
                if not Path(os.readlink(f"/proc/{entry}/cwd")).is_relative_to(self.folder):
                    continue
                line = Path(f"/proc/{entry}/cmdline").read_bytes().split(b"\0")
            except (OSError, ValueError):
                continue
            name = os.path.basename(line[0])
            if name == b"netconvert":
                found.append((int(entry), "netconvert"))
            elif len(line) > 1 and name == os.path.basename(self.program).encode():
                found.append((int(entry), "worker" if line[1] == b"worker" else "run"))
        return found

    def of_kind(self, kind):
        return [pid for pid, found in self.processes() if found == kind]

    def look(self):
        """Remembers the finished work that is there: records and models that are not damaged."""
        for record in self.out.glob("done/*/*.jsonl"):
            task = int(record.stem)
            if task in self.damaged:
                continue
            for path in (record, self.out / "models" / record.parent.name / f"{task}.safetensors"):
                found = read(path)
                if found is not None:
                    self.finished.setdefault((task, path), found)

    def lost(self):
        """Returns the finished work that is gone or was done again."""
        return [
            str(path.relative_to(self.folder))
            for (task, path), found in self.finished.items()
            if task not in self.damaged and read(path) != found
        ]

    def report(self):
        """Reports what is there, elsewhere; what is accepted has to be what an undisturbed run's report says."""
        shutil.rmtree(self.folder / "believed", ignore_errors=True)
        code, text = self.call("report", "out", "--out", "believed")
        if code == 0:
            self.compare(self.folder / "believed")
        return code

    def compare_tables(self, report):
        """Compares the tables of a whole run elsewhere with those of an undisturbed one."""
        for expected in sorted((self.undisturbed / "out/report").glob("*.csv")):
            if read(report / expected.name) != expected.read_bytes():
                self.wrong.append(f"{report.parent.name}/report/{expected.name} differs")

    def compare(self, report):
        whole = len(list(self.out.glob("done/*/*.jsonl"))) == len(list(self.undisturbed.glob("out/done/*/*.jsonl")))
        for expected in sorted((self.undisturbed / "out/report").glob("*.csv")):
            found = read(report / expected.name)
            if whole and found != expected.read_bytes():
                self.wrong.append(f"report/{expected.name} differs")
            elif expected.name == "episodes.csv" and found:
                strange = set(found.splitlines()) - set(expected.read_bytes().splitlines())
                self.wrong.extend(f"report/episodes.csv has {row[:80]!r}" for row in sorted(strange)[:1])

    def recover(self):
        """Does what the messages say until the run is whole; returns whether it is."""
        self.look()
        more = []
        for _ in range(8):
            code, text = self.call(*self.arguments(*more))
            self.look()
            if code == 0:
                self.compare(self.out / "report")
                code, text = self.call("check", "out", "--networks", str(self.networks.relative_to(self.folder)))
                if code == 0:
                    return True
            if code is None:
                return False
            self.follow(text)
            more = ["--retry-failed"] if way(text) == "retry" else []
        self.without_way.append(f"still after 8 attempts: {message(text)}")
        for pid, _ in self.processes():
            kill(pid, signal.SIGKILL)
        return False

    def follow(self, text):
        """Does what a message says."""
        does = way(text)
        named = [self.folder / name for name in re.findall(r"(?:out|networks)/[\w./+-]+?\.(?:[a-z.]*[a-z])\b", text)]
        if does == "repair":
            self.call("check", "out", "--repair", "--networks", str(self.networks.relative_to(self.folder)))
        elif does == "delete":
            for path in named:
                path.unlink(missing_ok=True)
        elif does == "rebuild":
            words = PLANS[self.plan].split()
            settings = words[words.index("--set") :] if "--set" in words else []
            self.call("build-networks", self.plan, "--force", *settings)
        elif does == "restore":
            for path in named:
                kept = self.undisturbed / path.relative_to(self.folder)
                if kept.is_file():
                    path.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copyfile(kept, path)

    def judge(self):
        """Compares what the run ended with to what an undisturbed one ended with."""
        if left := [kind for _, kind in self.processes()]:
            self.wrong.append(f"processes are left: {left}")
            for pid, _ in self.processes():
                kill(pid, signal.SIGKILL)
        compared = subprocess.run(
            [sys.executable, SAME_RECORDS, self.undisturbed / "out", self.out], capture_output=True, text=True
        )
        if compared.returncode:
            self.wrong.append("; ".join(l for l in compared.stdout.splitlines() if "differs" in l or "only in" in l)
                              or compared.stdout + compared.stderr[-300:])


def message(text):
    """Returns what a command said when it failed."""
    errors = [line for line in text.splitlines() if "error: " in line or re.match(r"(out|networks)/.*: .*; ", line)]
    return " ".join((errors or text.strip().splitlines() or ["(nothing)"])[-1].split())[:300]


def way(text):
    """Returns what a message tells to do."""
    return next((does for pattern, does in WAYS if re.search(pattern, text)), None)


def kill(pid, number):
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        pass


def wait_until(holds, seconds=20.0):
    """Waits until something holds; returns whether it does."""
    end = time.monotonic() + seconds
    while not (held := holds()) and time.monotonic() < end:
        time.sleep(0.002)
    return held
