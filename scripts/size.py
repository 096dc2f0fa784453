#!/usr/bin/env python3
"""Counts the house: lines of code, tests and comments, types and public functions per part, words of pages, tracked files.

usage: scripts/size.py [--base REVISION] [--check]

  --base REVISION   prints the change since a revision; since the last tag, where there is one, by default
  --check           fails where a figure is above its ceiling in scripts/ceilings.toml

A line is blank, a comment, or code; code within `#[cfg(test)]` items and in folders of tests, benches and fuzz targets
counts as tests. Only files that git tracks count.
"""
import argparse
import collections
import os
import pathlib
import re
import subprocess
import sys
import tomllib

FOLDERS = {
    "evaluation": "crates/evaluation/", "cli": "src/", "signals": "crates/signals/", "signals-report": "crates/signals-report/",
    "osm-signals": "osm-signals/", "sheet": "sheet/", "learners": "crates/learners/", "control-tasks": "crates/control-tasks/",
    "basics": "crates/basics/", "python": "python/", "libsumo-sys": "libsumo-sys/", "tests": "tests/",
}
COLUMNS = ["code", "test", "comment", "types", "public", "files"]
TEST_FILE = re.compile(r"(^|/)(tests?|benches|fuzz|snapshots)(/|$)|(^|/)(tests?|testing)\.rs$")
TEST_MODULE = re.compile(r"#\[cfg\(test\)\]\s*(?:pub(?:\([^)]*\))?\s+)?mod (\w+);")
TYPE = re.compile(r"(pub(\([^)]*\))?\s+)?(struct|enum|trait|union)\s+\w")
PUBLIC = re.compile(r"pub(\([^)]*\))?\s+(const\s+|async\s+|unsafe\s+)*fn\s")
LITERAL = re.compile(r'"(\\.|[^"\\])*"|\'(\\.|[^\'\\])\'')
GENERATED = {"docs/settings.md"}


def git(*words):
    return subprocess.run(["git", *words], check=True, capture_output=True, text=True).stdout


def kinds(text, is_test):
    """Yields the kind of each line that is not blank, and the line."""
    in_block, waits_for_brace, depth = False, False, 0
    for line in map(str.strip, text.splitlines()):
        if in_block or line.startswith(("//", "/*")):
            in_block = (in_block or line.startswith("/*")) and "*/" not in line
            yield "comment", line
        elif line:
            waits_for_brace |= line.startswith("#[cfg(test)]")
            yield "test" if is_test or waits_for_brace or depth > 0 else "code", line
            bare = LITERAL.sub("", line)
            opened = bare.count("{") - bare.count("}")
            if waits_for_brace and ("{" in bare or bare.endswith(";")):
                waits_for_brace, depth = False, max(opened, 0)
            elif depth > 0:
                depth += opened


def count(texts):
    """Returns a counter per part, of the texts of source files by path."""
    tests = set()
    for path, text in texts.items():
        folder = pathlib.PurePath(path)
        stays = folder.stem in ("mod", "lib", "main") or folder.stem == folder.parent.name
        folder = folder.parent if stays else folder.with_suffix("")
        tests.update(str(folder / name) for name in TEST_MODULE.findall(text))
    parts = collections.defaultdict(collections.Counter)
    for path, text in texts.items():
        part = parts[next((name for name, folder in FOLDERS.items() if path.startswith(folder)), "other")]
        part["files"] += 1
        above = [path[: -len(".rs")], *map(str, pathlib.PurePath(path).parents)]
        for kind, line in kinds(text, bool(TEST_FILE.search(path)) or not tests.isdisjoint(above)):
            part[kind] += 1
            part["types"] += kind == "code" and bool(TYPE.match(line))
            part["public"] += kind == "code" and bool(PUBLIC.match(line))
    return parts


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--base", default=(git("tag", "--merged", "HEAD", "--sort=-creatordate").split() or [None])[0])
    arguments.add_argument("--check", action="store_true")
    arguments = arguments.parse_args()
    os.chdir(pathlib.Path(__file__).parent.parent)
    paths = [path for path in git("ls-files").splitlines() if os.path.isfile(path)]
    now = count({path: pathlib.Path(path).read_text("utf-8") for path in paths if path.endswith(".rs")})
    before = None
    if arguments.base:
        old = git("ls-tree", "-r", "--name-only", arguments.base).splitlines()
        before = count({path: git("show", f"{arguments.base}:{path}") for path in old if path.endswith(".rs")})
        before["sum"] = sum(before.values(), collections.Counter())
    rows = {name: now[name] for name in [*FOLDERS, "other"]}
    rows["sum"] = sum(now.values(), collections.Counter())
    print(f"{'part':15}" + "".join(f"{column:>9}" for column in COLUMNS) + ("   code, test since then" if before else ""))
    for name, row in rows.items():
        change = "".join(f"{row[kind] - before[name][kind]:+9}" for kind in ("code", "test")) if before else ""
        print(f"{name:15}" + "".join(f"{row[column]:9}" for column in COLUMNS) + change)
    words = sum(len(pathlib.Path(path).read_text("utf-8").split()) for path in paths if path.endswith(".md") and path not in GENERATED)
    megabytes = sum(map(os.path.getsize, paths)) / 1e6
    print(f"{words} words in pages written by hand, {len(paths)} tracked files of {megabytes:.1f} MB")

    if arguments.check:
        rows["house"] = {"words": words, "files": len(paths), "megabytes": megabytes}
        ceilings = tomllib.loads(pathlib.Path("scripts/ceilings.toml").read_text("utf-8"))
        above = [
            f"{part}: {kind} is {rows[part][kind]:.6g}, above its ceiling of {most} in scripts/ceilings.toml"
            for part, row in ceilings.items()
            for kind, most in row.items()
            if rows[part][kind] > most
        ]
        sys.exit("\n".join(above) or None)


if __name__ == "__main__":
    main()
