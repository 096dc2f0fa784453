"""Strange places, names, links, builds, libraries and inputs: what is no damage and no disturbance, but is not usual."""

import gzip
import os
import re
import resource
import shutil
import signal
import subprocess
import time
import zlib

from disturb import networks, sleep_while
from work import kill, wait_until

# Memory and time that refusing an input may take.
MOST_BYTES = 2 << 30
MOST_S = 20
# Names of results folders, and whether SUMO can take them as a path.
NAMES = [
    ("a folder of spaces", True),
    ("-dash", True),
    ("été 路口", True),
    ("n" * 200, True),
    ("a&b<c>'d", True),
    ("50%25", True),
    ("a:b", False),
    ("a,b", False),
    ("a\nb", False),
    (os.fsdecode(b"a\xffb"), False),
]


def kept(folder):
    """Returns the bytes of all files beneath a folder."""
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file() and not path.is_symlink()}


def failed(work, out):
    """Returns the tasks of a results folder that have a failed record."""
    return [p.name for p in out.glob("done/*/*.jsonl") if b'"outcome":"failed"' in p.read_bytes()]


def places(work, rng):
    """The results folder has an unusual name, or is reached by a link."""
    networks(work, rng)
    name, fits = rng.choice(NAMES)
    out = work.folder / name
    if fits and rng.random() < 0.3:
        (work.folder / "elsewhere").mkdir()
        out.symlink_to("elsewhere")
    before = set(work.folder.iterdir())
    code, text = work.call(*work.arguments()[:-1], f"./{name}")
    if fits:
        if code != 0:
            work.wrong.append(f"it fails in {name!r}: {text[-200:]}")
        else:
            work.compare_tables(out / "report")
    elif code != 2 or set(work.folder.iterdir()) != before:
        work.wrong.append(f"{name!r} is not refused before anything is written: exit code {code}")
    return repr(name)


def links(work, rng):
    """Files of a results folder are hard or symbolic links to somebody else's; neither may be written through them."""
    networks(work, rng)
    theirs = work.folder / "theirs"
    shutil.copytree(work.undisturbed / "out", theirs)
    for path in theirs.glob("done/*/*.jsonl"):
        if rng.random() < 0.5:
            path.unlink()
    other = work.folder / "document"
    other.write_text("somebody else's\n")
    hard = rng.random() < 0.6
    if hard:
        shutil.copytree(theirs, work.out, copy_function=os.link)
        for name in ("lock.json", "logs/000/0.log"):
            (work.out / name).unlink(missing_ok=True)
            (work.out / name).parent.mkdir(parents=True, exist_ok=True)
            os.link(other, work.out / name)
    else:
        shutil.copytree(theirs, work.out)
        shutil.rmtree(work.out / "logs", ignore_errors=True)
        (work.out / "logs").symlink_to(theirs / "logs")
    before = kept(theirs) | {other: other.read_bytes()}
    work.call(*work.arguments())
    for path, found in before.items():
        if not path.exists() or path.read_bytes() != found:
            work.wrong.append(f"{path.name} of somebody else's was written through a link")
    if not hard:
        (work.out / "logs").unlink()
    return "hard links" if hard else "a symbolic link"


def builds(work, rng):
    """Another build begins the run; the one that goes on has to say so."""
    if work.other is None:
        return None
    networks(work, rng)
    told = re.search(r"\(([0-9a-f]{7}[\w-]*)\)", subprocess.run([work.other, "doctor"], capture_output=True, text=True).stdout)
    mine, work.program = work.program, work.other
    run = work.start(work.arguments())
    sleep_while(run, rng.uniform(0.2, 0.9) * work.seconds)
    kill(run.pid, signal.SIGKILL)
    work.end(run)
    wait_until(lambda: not work.processes(), 10)
    work.program = mine
    work.look()
    total = len(list(work.undisturbed.glob("out/done/*/*.jsonl")))
    there = len(list(work.out.glob("done/*/*.jsonl")))
    _, text = work.call(*work.arguments())
    if 0 < there < total and f"begun by the build {told[1]}" not in text:
        work.wrong.append("nothing is said of another build")
    if 0 < there < total and "Several builds made the records" not in work.call("status", "out")[1]:
        work.wrong.append("status says nothing of several builds")
    # The records of the other build are as good, and name it.
    shutil.rmtree(work.out, ignore_errors=True)
    work.finished.clear()
    return f"{there} of {total} records by another build"


def libraries(work, rng):
    """The system's loader finds another libsumo than that of the build, on the way or from the start."""
    told = work.call("doctor")[1]
    name = re.search(r"^libsumo +(\S+)", told, re.M)
    compiler = shutil.which("cc")
    if name is None or compiler is None:
        return None
    networks(work, rng)
    other = work.folder / "libraries"
    other.mkdir()
    (other / "nothing.c").write_text("int nothing;\n")
    name = os.path.basename(name[1])
    command = [compiler, "-shared", "-fPIC", "-o", other / name, f"-Wl,-soname,{name}", other / "nothing.c"]
    subprocess.run(command, check=True)
    if rng.random() < 0.5:
        (other / name).write_bytes(b"\x7fELF")
    begun = rng.random() < 0.5
    if begun:
        run = work.start(work.arguments())
        sleep_while(run, work.seconds / 2)
        kill(run.pid, signal.SIGTERM)
        work.end(run)
        work.look()
    os.environ["LD_LIBRARY_PATH"] = str(other)
    try:
        code, text = work.call(*work.arguments())
    finally:
        del os.environ["LD_LIBRARY_PATH"]
    whole = code == 0
    if not whole and code != 4:
        work.wrong.append(f"another libsumo gives exit code {code}: {text[-200:]}")
    if broken := failed(work, work.out):
        work.wrong.append(f"another libsumo is charged to tasks: {broken}")
    return "after a start" if begun else "from the start"


def block(kind, payload):
    """Returns a block of a PBF file."""
    def field(number, wire, data):
        head = bytes([number << 3 | wire])
        return head + (varint(len(data)) + data if wire == 2 else varint(data))

    blob = field(2, 0, len(payload)) + field(3, 2, zlib.compress(payload, 9))
    header = field(1, 2, kind) + field(3, 0, len(blob))
    return len(header).to_bytes(4, "big") + header + blob


def varint(number):
    """Returns a number as PBF has it."""
    out = bytearray()
    while number >= 0x80:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    return bytes([*out, number])


def inputs(work, rng):
    """A small file unpacks to a large one, or is nested without end: it is refused soon, and without much memory."""
    networks(work, rng)
    at = work.folder
    depth = rng.choice([2_000, 200_000])
    (at / "n.net.xml").write_text("<net/>")
    (at / "a.sumocfg").write_text("<configuration><net-file value='n.net.xml'/><route-files value='r.rou.xml'/><end value='9'/></configuration>")
    kinds = {
        "nested routes": lambda: (at / "r.rou.xml").write_text("<routes>" + "<a>" * depth),
        "routes that include themselves": lambda: (at / "r.rou.xml").write_text("<routes><include href='r.rou.xml'/></routes>"),
        "an attribute without end": lambda: (at / "r.rou.xml").write_text("<routes a='" + "x" * (64 << 20)),
        "a nested map": lambda: (at / "m.osm").write_text("<osm>" + "<node>" * depth),
        "an inflated map in XML": lambda: (at / "m.osm.gz").write_bytes(gzip.compress(b"<osm><way id='1'>" + b"<nd ref='1'/>" * 9_000_000)),
        "an inflated map in PBF": lambda: (at / "m.osm.pbf").write_bytes(
            block(b"OSMHeader", b"\x22\x0eOsmSchema-V0.6") + block(b"OSMData", b"\x0a\x00\x12" + varint(30 << 20) + bytes(30 << 20))
        ),
        "a list that is zipped many times": lambda: (at / "t.csv").write_bytes(gzip.compress(bytes(200 << 20))),
    }
    kind = rng.choice(list(kinds))
    kinds[kind]()
    if "routes" in kind or "attribute" in kind:
        arguments = ["run", "--sumocfg", "a.sumocfg", "--methods", "program", "--dry-run"]
    elif "map" in kind:
        arguments = ["build-networks", "--osm", next(p.name for p in at.glob("m.osm*")), "--out", "city"]
    else:
        (at / "t.toml").write_text('[family]\napproaches = "t.csv"\n')
        arguments = ["list", "t.toml"]
    start = time.monotonic()
    old = resource.getrlimit(resource.RLIMIT_AS)
    # Children inherit it; this process itself is small.
    resource.setrlimit(resource.RLIMIT_AS, (MOST_BYTES, old[1]))
    try:
        run = work.start(arguments)
    finally:
        resource.setrlimit(resource.RLIMIT_AS, old)
    code = run.wait(120)
    took = time.monotonic() - start
    text = run.said.read_text(errors="replace")
    if code != 2 or "error: " not in text:
        work.wrong.append(f"{kind}: exit code {code}: {text[-200:]}")
    if took > MOST_S:
        work.wrong.append(f"{kind}: refused after {took:.0f} s")
    return kind
