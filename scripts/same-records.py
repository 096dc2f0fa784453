#!/usr/bin/env python3
"""Says how many records of two results directories are equal, byte for byte but for wall-clock times.

    scripts/same-records.py BEFORE AFTER

What may differ by build and machine does not count: `wall` in records, `git` on the cards of models, the
manifest's provenance. Ends with 1 if anything else differs, or if a record is in one directory only.
"""

import json
import struct
import sys
from pathlib import Path


class Digits(str):
    """A number as it is written: 1.0 is not 1."""


def read(text):
    return json.loads(text, parse_float=Digits, parse_int=Digits)


def difference(a, b, path=""):
    """Returns the first place where two values differ, or None."""
    if type(a) is not type(b):
        return f"{path}: {a!r} and {b!r}"
    if isinstance(a, dict):
        if list(a) != list(b):
            return f"{path}: the fields {', '.join(a)} and {', '.join(b)}"
        return next(filter(None, (difference(a[k], b[k], f"{path}.{k}") for k in a)), None)
    if isinstance(a, list):
        if len(a) != len(b):
            return f"{path}: {len(a)} and {len(b)} entries"
        pairs = enumerate(zip(a, b))
        return next(filter(None, (difference(x, y, f"{path}[{i}]") for i, (x, y) in pairs)), None)
    return None if a == b else f"{path}: {a!r} and {b!r}"


def record(data):
    rows = [read(line) for line in data.decode().splitlines()]
    rows[0].pop("wall", None)
    return rows


def model(data):
    (length,) = struct.unpack("<Q", data[:8])
    header = read(data[8 : 8 + length])
    card = {key: json.loads(value) for key, value in header["__metadata__"].items()}
    for value in card.values():
        if isinstance(value, dict):
            value.pop("git", None)
            # Of the file as a whole, and so of the build.
            value.pop("sha256", None)
    card.pop("git", None)
    # The rest of the header and the tensors, whose places in the file the header gives.
    header["__metadata__"] = {key: json.dumps(value) for key, value in card.items()}
    return [header, data[8 + length :].hex()]


def compare(name, before, after, glob, parse):
    """Prints how many files are equal, and the first difference of those that are not."""
    names = sorted({p.relative_to(d).as_posix() for d in (before, after) for p in d.glob(glob)})
    equal = 0
    for path in names:
        a, b = before / path, after / path
        if not (a.exists() and b.exists()):
            print(f"{path}: only in {a.parent if a.exists() else b.parent}")
            continue
        a, b = a.read_bytes(), b.read_bytes()
        found = None if a == b else difference(parse(a), parse(b))
        equal += found is None
        if found:
            print(f"{path}: differs at {found}")
    print(f"{name}: {equal} of {len(names)} equal")
    return equal == len(names)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    before, after = map(Path, sys.argv[1:])
    for folder in (before, after):
        if not any((folder / "done").glob("*/*.jsonl")):
            sys.exit(f"{folder} has no records")
    same = [
        compare("manifests, what the run is", before, after, "manifest.json", lambda d: read(d)["identity"]),
        compare("plans", before, after, "plan.jsonl", lambda d: d.decode().splitlines()),
        compare("records", before, after, "done/*/*.jsonl", record),
        compare("models", before, after, "models/*/*.safetensors", model),
    ]
    sys.exit(0 if all(same) else 1)


main()
