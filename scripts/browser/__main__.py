"""Looks at pages in Chromium, then plants faults in the first one and looks whether they are found.

    python scripts/browser --large PAGE PAGE...

Exits with 1 where a page has a fault or a planted one is not found.
"""

import argparse
import shutil
import sys
import tempfile
import time
from pathlib import Path

import checks
from planted import FAULTS
from playwright.sync_api import sync_playwright

# Longest opening of the page of a large family, seconds. It is meant to be below 2 on an idle machine; a busy one
# took 9 s for a page that took 4 minutes later, so that this finds only what opens many times slower.
OPENS_WITHIN_S = 15.0

# Faults of a page that are printed.
SHOWN = 10


def of_pages(browser, paths):
    """Prints the faults of pages and returns how many there are."""
    count = 0
    for path in paths:
        begun = time.monotonic()
        faults = checks.of_page(browser, path)
        count += len(faults)
        print(f"{path}: {len(faults) or 'no'} faults ({time.monotonic() - begun:.1f} s)")
        for fault in faults[:SHOWN]:
            print(f"  {fault}")
    return count


def of_planted(browser, path):
    """Plants one fault after the other in copies of a page; returns how many were not found."""
    missed, words = 0, Path(path).read_text()
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "report"
        shutil.copytree(Path(path).parent, copy, ignore=shutil.ignore_patterns("against-*", "plans"))
        page = copy / "index.html"
        for fault in FAULTS:
            if words.count(fault.instead_of) == 0:
                print(f"planting {fault.name}: the page has no {fault.instead_of!r}")
                missed += 1
                continue
            page.write_text(words.replace(fault.instead_of, fault.planted, 1))
            found = fault.look(browser, page)
            if not any(fault.says in f for f in found):
                print(f"planted and not found: {fault.name}; found {found[:3]}")
                missed += 1
    print(f"{len(FAULTS) - missed} of {len(FAULTS)} planted faults are found")
    return missed


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--large", help="page of a large family, whose opening is timed")
    parser.add_argument("pages", nargs="+", help="pages to look at; faults are planted in the first")
    given = parser.parse_args()
    with sync_playwright() as playwright:
        chromium = shutil.which("chromium") or sys.exit("chromium is missing")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--disable-dev-shm-usage"])
        failed = of_pages(browser, given.pages) + of_planted(browser, given.pages[0])
        if given.large:
            took = checks.opening_s(browser, given.large)
            megabytes = Path(given.large).stat().st_size / 1e6
            print(f"{given.large}: opens in {took:.1f} s, {megabytes:.1f} MB")
            failed += took > OPENS_WITHIN_S
        browser.close()
    sys.exit(1 if failed else 0)


main()
