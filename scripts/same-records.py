#!/usr/bin/env python3
"""Says how many records and models of two runs are equal, but for wall-clock times and the build: BEFORE AFTER."""

import json
import struct
import sys
from pathlib import Path


def record(data):
    first, *rows = data.decode().splitlines()
    return [{**json.loads(first), "wall": None}, *rows]


def model(data):
    (length,) = struct.unpack("<Q", data[:8])
    header = json.loads(data[8 : 8 + length])
    card = {key: json.loads(value) for key, value in header.pop("__metadata__").items() if key != "git"}
    for value in card.values():
        if isinstance(value, dict):
            value.pop("git", None)
            # Of the file as a whole, and so of the build.
            value.pop("sha256", None)
    return [header, card, data[8 + length :]]


def main():
    before, after = map(Path, sys.argv[1:])
    wrong = 0
    for name, glob, parse in [
        ("records", "done/*/*.jsonl", record),
        ("models", "models/*/*.safetensors", model),
    ]:
        paths = sorted({p.relative_to(d) for d in (before, after) for p in d.glob(glob)})
        if name == "records" and not paths:
            sys.exit("no records")
        both = [(before / p, after / p) for p in paths]
        differ = [b for a, b in both if not (a.exists() and b.exists()) or parse(a.read_bytes()) != parse(b.read_bytes())]
        print(f"{name}: {len(both) - len(differ)} of {len(both)} equal", *differ[:10], sep="\n  ")
        wrong += len(differ)
    sys.exit(1 if wrong else 0)


main()
