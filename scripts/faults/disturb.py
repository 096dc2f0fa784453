"""What happens to processes and to the disk while a run goes on."""

import os
import resource
import shutil
import signal
import subprocess
import threading
import time

from damage import checkpoint, filled, learners, names, undo
from work import kill, wait_until

ENDING = [signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP]


def sleep_while(process, seconds):
    """Sleeps, at most until a process ends."""
    try:
        process.wait(max(seconds, 0))
    except subprocess.TimeoutExpired:
        pass


def networks(work, rng):
    """Lets half of the runs begin with networks that were built before."""
    if rng.random() < 0.7:
        shutil.copytree(work.undisturbed / "networks", work.folder / "networks", symlinks=True)


def ended(work, rng):
    """The program is killed or told to end, several times over."""
    networks(work, rng)
    done = []
    for _ in range(rng.randrange(1, 4)):
        run = work.start(work.arguments())
        sleep_while(run, rng.uniform(0, work.seconds))
        number = rng.choice(ENDING)
        kill(run.pid, number)
        work.end(run)
        # Its workers notice by themselves.
        if not wait_until(lambda: not work.processes(), 10):
            work.wrong.append("workers outlive the program")
        work.look()
        done.append(number.name)
    return " ".join(done)


def stopped(work, rng):
    """The program is stopped for a while, as a laptop that sleeps or Ctrl-Z."""
    networks(work, rng)
    run = work.start(work.arguments("--stall-timeout", "3"))
    sleep_while(run, rng.uniform(0, work.seconds))
    all_of_it = rng.random() < 0.5
    pids = [pid for pid, _ in work.processes()] if all_of_it else [run.pid]
    for pid in pids:
        kill(pid, signal.SIGSTOP)
    time.sleep(rng.uniform(0.1, 2))
    for pid in pids:
        kill(pid, signal.SIGCONT)
    work.end(run)
    return "with its workers" if all_of_it else "alone"


def workers(work, rng):
    """Workers are killed, some of them again and again."""
    networks(work, rng)
    run = work.start(work.arguments())
    killed = 0
    for _ in range(rng.randrange(1, 7)):
        sleep_while(run, rng.uniform(0, work.seconds / 3))
        for pid in rng.sample(found := work.of_kind("worker"), rng.randrange(len(found) + 1)):
            kill(pid, rng.choice(ENDING))
            killed += 1
    work.end(run)
    return f"{killed} workers"


def worker_stopped(work, rng):
    """A worker is stopped and never goes on."""
    shutil.copytree(work.undisturbed / "networks", work.folder / "networks", symlinks=True)
    run = work.start(work.arguments("--stall-timeout", "2"))
    sleep_while(run, rng.uniform(0, work.seconds / 2))
    found = wait_until(lambda: work.of_kind("worker") or run.poll() is not None and [0])
    if found != [0]:
        kill(rng.choice(found), signal.SIGSTOP)
    work.end(run)
    return "too late" if found == [0] else f"of {len(found)} workers"


def zombie(work, rng):
    """A stopped worker goes on when its program is gone and its task is done by another."""
    shutil.copytree(work.undisturbed / "networks", work.folder / "networks", symlinks=True)
    run = work.start(work.arguments())
    sleep_while(run, rng.uniform(0.1, work.seconds))
    found = work.of_kind("worker")
    for pid in found:
        kill(pid, signal.SIGSTOP)
    kill(run.pid, signal.SIGKILL)
    run.wait()
    work.look()
    again = work.start(work.arguments())
    sleep_while(again, rng.uniform(0, work.seconds))
    for pid in found:
        kill(pid, signal.SIGCONT)
    work.end(again)
    wait_until(lambda: not work.processes(), 10)
    return f"{len(found)} workers"


def netconvert(work, rng):
    """netconvert is killed, stopped or crashes."""
    run = work.start(work.arguments())
    done = []
    for _ in range(rng.randrange(1, 4)):
        if not wait_until(lambda: work.of_kind("netconvert") or run.poll() is not None or work.of_kind("worker")):
            break
        time.sleep(rng.uniform(0, 0.02))
        for pid in work.of_kind("netconvert"):
            number = rng.choice([*ENDING, signal.SIGSEGV, signal.SIGABRT, signal.SIGSTOP])
            kill(pid, number)
            done.append(number.name)
            if number == signal.SIGSTOP:
                time.sleep(rng.uniform(0, 1))
                if rng.random() < 0.5:
                    kill(run.pid, signal.SIGKILL)
                    done.append("and the program killed")
                kill(pid, signal.SIGCONT)
        work.look()
    work.end(run)
    wait_until(lambda: not work.processes(), 10)
    return " ".join(done) or "too late"


def all_at_once(work, rng):
    """Everything is killed at once, as by a loss of power without the loss of the disk's memory."""
    networks(work, rng)
    for _ in range(rounds := rng.randrange(1, 4)):
        run = work.start(work.arguments())
        sleep_while(run, rng.uniform(0, work.seconds))
        for pid, _ in work.processes():
            kill(pid, signal.SIGKILL)
        work.end(run)
        wait_until(lambda: not work.processes(), 10)
        work.look()
    return f"{rounds} times"


def learner(work, rng):
    """A training is killed again and again, and goes on from its checkpoints."""
    filled(work, rng)
    task = rng.choice(learners(work))
    undo(work, task)
    for _ in range(kills := rng.randrange(1, 5)):
        path = checkpoint(work, rng, task)
    work.look()
    # One that was killed between its record and the end of its checkpoint has nothing left to do.
    had = path.exists() and not (work.out / "done" / "000" / f"{task}.jsonl").exists()
    code, text = work.call(*work.arguments())
    log = (work.out / "logs" / "000" / f"{task}.log").read_text(errors="replace")
    if had and "training continues after episode" not in log:
        work.wrong.append(f"the checkpoint was not used: {log[-200:]!r}")
    return f"{kills} kills" if had else f"{kills} kills, the last one too late"


def second(work, rng):
    """The same command is given a second time while the first goes on, and one of the two is killed."""
    networks(work, rng)
    first = work.start(work.arguments())
    sleep_while(first, rng.uniform(0, work.seconds / 2))
    work.call(*work.arguments())
    if rng.random() < 0.5:
        kill(first.pid, signal.SIGKILL)
    work.end(first)
    wait_until(lambda: not work.processes(), 10)
    return ""


def limits(work, rng):
    """Limits of memory, files or their size fall on processes that work."""
    networks(work, rng)
    run = work.start(work.arguments())
    done = []
    for _ in range(rng.randrange(1, 4)):
        sleep_while(run, rng.uniform(0, work.seconds / 2))
        for pid, kind in work.processes():
            name, most = rng.choice([("FSIZE", rng.choice([0, 5000, 60000])), ("NOFILE", rng.choice([0, 8, 12])), ("AS", 1 << 20)])
            try:
                resource.prlimit(pid, getattr(resource, f"RLIMIT_{name}"), (most, most))
                done.append(f"{kind} {name} {most}")
            except (ProcessLookupError, PermissionError):
                pass
    work.end(run)
    wait_until(lambda: not work.processes(), 10)
    return ", ".join(done)


def disk(work, rng):
    """A small disk fills and empties at random moments."""
    place, inodes = work.folder, rng.random() < 0.25
    size = sum(p.stat().st_size for p in work.undisturbed.rglob("*") if p.is_file()) + (2 << 20)
    entries = sum(1 for _ in work.undisturbed.rglob("*")) + 400
    mount = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size},nr_inodes={entries}", "tmpfs", place], capture_output=True)
    if mount.returncode:
        return None
    networks(work, rng)
    over, filler = threading.Event(), place / "filler"

    def fill():
        filler.mkdir(exist_ok=True)
        while not over.wait(rng.uniform(0, work.seconds / 4)):
            try:
                if inodes:
                    for number in range(entries):
                        (filler / str(number)).touch()
                else:
                    with open(filler / "full", "wb") as file:
                        for block in (1 << 16, 4096):
                            try:
                                while True:
                                    file.write(bytes(block))
                                    file.flush()
                            except OSError:
                                pass
                        free = rng.choice([0, 0, 4096, 1 << 14, 1 << 17])
                        file.truncate(max(0, file.tell() - free))
            except OSError:
                pass
            over.wait(rng.uniform(0, work.seconds / 4))
            shutil.rmtree(filler, ignore_errors=True)
            filler.mkdir(exist_ok=True)

    thread = threading.Thread(target=fill)
    thread.start()
    tries = rng.randrange(1, 4)
    try:
        for _ in range(tries):
            work.call(*work.arguments())
            work.look()
    finally:
        over.set()
        thread.join()
        shutil.rmtree(filler, ignore_errors=True)
    return f"{tries} tries, {'no files more' if inodes else 'no room'}"
