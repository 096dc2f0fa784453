"""Damage to files: at rest, while a run goes on, and files that are exchanged."""

import shutil

from work import kill, read, wait_until

# What lies where, by the word for it in the table.
FILES = {
    "a record": "out/done/*/*.jsonl",
    "a model": "out/models/*/*.safetensors",
    "a checkpoint": "out/ckpt/*/*.safetensors",
    "the manifest": "out/manifest.json",
    "the plan": "out/plan.jsonl",
    "the design": "out/design.json",
    "the list of places": "out/places.json",
    "a network": "networks/*/by-hash/*/*",
    "the index of networks": "networks/*/INDEX.csv",
    "a log, the lock or a report": "out/[lr]*/**/*",
}
# Damage that a disk, a copy or a person does.
WAYS = ["a flipped bit", "a truncation", "emptied", "zeros", "a lost line", "garbage at the end", "deleted"]


def spoil(path, rng, ways=WAYS):
    """Damages a file; returns what was done."""
    content = bytearray(read(path) or b"")
    # Results may come without models, and without places as those of old versions do: what is gone is no damage.
    may_miss = path.name == "places.json" or "models" in path.parts
    what = rng.choice([w for w in ways if not (may_miss and w == "deleted")]) if content else "deleted"
    position = rng.randrange(len(content)) if content else 0
    if what == "a flipped bit":
        content[position] ^= 1 << rng.randrange(8)
    elif what == "a truncation":
        del content[position:]
    elif what == "emptied":
        content.clear()
    elif what == "zeros":
        # As after a loss of power: a block that was never written.
        end = min(len(content), position + rng.choice([1, 64, 4096]))
        content[position:end] = bytes(end - position)
    elif what == "a lost line":
        lines = bytes(content).splitlines(keepends=True)
        del lines[rng.randrange(len(lines))]
        content = bytearray(b"".join(lines))
    elif what == "garbage at the end":
        content += rng.randbytes(rng.choice([1, 40, 5000]))
    elif what == "deleted":
        path.unlink(missing_ok=True)
        return what
    # A file of its own: what is finished elsewhere may be the same file under another name.
    new = path.with_name(path.name + ".new")
    new.write_bytes(content)
    new.rename(path)
    return what


def names(work, path):
    """Notes whose work a file is."""
    if path.suffix in (".jsonl", ".safetensors") and path.stem.isdigit():
        work.damaged.add(int(path.stem))


def filled(work, rng):
    """Lays down a run that is over, or half of one."""
    for part in ("out", "networks"):
        shutil.copytree(work.undisturbed / part, work.folder / part, symlinks=True)
    tasks = sorted(work.out.glob("done/*/*.jsonl"))
    if rng.random() < 0.5:
        for record in rng.sample(tasks, rng.randrange(1, len(tasks))):
            undo(work, int(record.stem))
    return work


def undo(work, task):
    """Takes away what a task left."""
    for pattern in ("done/*/{}.jsonl", "models/*/{}.safetensors"):
        for path in work.out.glob(pattern.format(task)):
            path.unlink()


def learners(work):
    """Returns the tasks that leave models."""
    return sorted(int(p.stem) for p in work.undisturbed.glob("out/models/*/*.safetensors"))


def checkpoint(work, rng, task):
    """Kills the training of a task when it has a checkpoint; returns the checkpoint."""
    path = work.out / "ckpt" / "000" / f"{task}.safetensors"
    networks = str(work.networks.relative_to(work.folder))
    before = read(path)
    worker = work.start(["worker", "out", "--task", str(task), "--prepared", networks, "--checkpoint-every-s", "0"])
    wait_until(lambda: read(path) not in (None, before) or worker.poll() is not None)
    try:
        worker.wait(rng.uniform(0, 0.3))
    except Exception:
        pass
    kill(worker.pid, 9)
    worker.wait()
    return path


def at_rest(kind):
    """Returns the fault that damages files of a kind before the same command is run again."""

    def fault(work, rng):
        filled(work, rng)
        if kind == "a checkpoint":
            task = rng.choice(learners(work))
            undo(work, task)
            checkpoint(work, rng, task)
        paths = sorted(p for p in work.folder.glob(FILES[kind]) if p.is_file())
        done = []
        for path in rng.sample(paths, min(len(paths), rng.choice([1, 1, 2]))):
            if kind != "a checkpoint":
                names(work, path)
            done.append(f"{path.relative_to(work.folder)}: {spoil(path, rng)}")
        work.look()
        work.report()
        work.call("check", "out")
        return ", ".join(done)

    return fault


def everything(work, rng):
    """Damages several files of any kind at once."""
    filled(work, rng)
    paths = sorted(p for pattern in FILES.values() for p in work.folder.glob(pattern) if p.is_file())
    done = []
    for path in rng.sample(paths, rng.randrange(2, 8)):
        names(work, path)
        done.append(f"{path.relative_to(work.folder)}: {spoil(path, rng)}")
    work.look()
    work.report()
    return ", ".join(done)


def exchanged(work, rng):
    """Puts files into the place of others: of another task, of the same run with another seed."""
    filled(work, rng)
    kind = rng.choice(["a record", "a model", "the manifest", "the plan", "the design", "a network"])
    here = sorted(work.folder.glob(FILES[kind]))
    if kind == "a network":
        here = [p for p in here if p.name.endswith(("net.xml", "rou.xml"))]
    there = list(here)
    if rng.random() < 0.5 or len(here) < 2:
        there = sorted(p for other in work.others.glob(f"{work.plan}-*") for p in other.glob(FILES[kind]))
    if not here:
        return "nothing to exchange"
    to, source = rng.choice(here), rng.choice(there)
    if read(to) == read(source):
        return "the same file"
    names(work, to)
    content = read(source)
    to.unlink()
    to.write_bytes(content)
    work.look()
    work.report()
    work.call("check", "out")
    return f"{to.relative_to(work.folder)} from {source.relative_to(work.others if source.is_relative_to(work.others) else work.folder)}"


def meanwhile(work, rng):
    """Damages files while the run goes on."""
    shutil.copytree(work.undisturbed / "networks", work.folder / "networks", symlinks=True)
    run = work.start(work.arguments())
    done = []
    for _ in range(rng.randrange(1, 4)):
        try:
            run.wait(rng.uniform(0, work.seconds / 2))
        except Exception:
            pass
        kinds = [k for k in FILES if k != "a log, the lock or a report"]
        paths = [p for kind in rng.sample(kinds, len(kinds)) for p in sorted(work.folder.glob(FILES[kind])) if p.is_file()]
        if not paths:
            continue
        path = paths[0]
        names(work, path)
        done.append(f"{path.relative_to(work.folder)}: {spoil(path, rng)}")
    work.end(run)
    work.look()
    return ", ".join(done)
