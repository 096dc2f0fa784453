"""Opens pages in Chromium: nothing may complain, load anything, be wider than the window, or link to nothing.

    python scripts/browser.py FOLDER PAGE...     FOLDER gets a screenshot of each page

Exits with 1 where a page has a fault.
"""

import re
import shutil
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

LINKS = "() => [...document.querySelectorAll('a[href]')].map((a) => a.getAttribute('href'))"
THERE = "(id) => document.getElementById(id) !== null"
WIDE = "() => document.documentElement.scrollWidth"


def faults_of(browser, path, picture):
    found = []
    for width in (1280, 390):
        page = browser.new_page(viewport={"width": width, "height": 900})
        page.on("console", lambda m: found.append(f"{m.type}: {m.text}") if m.type in ("error", "warning") else None)
        page.on("pageerror", lambda e: found.append(f"exception: {e}"))
        page.on("request", lambda r: None if r.is_navigation_request() else found.append(f"loads {r.url[:80]}"))
        page.goto(path.resolve().as_uri())
        wide = page.evaluate(WIDE)
        if wide > width:
            found.append(f"the page is {wide} px wide, the window {width}")
        if width == 1280:
            page.screenshot(path=picture, full_page=True)
            for href in set(page.evaluate(LINKS)):
                if href.startswith("#"):
                    is_there = page.evaluate(THERE, href[1:])
                else:
                    is_there = re.match("https://", href) or (path.parent / href.split("#")[0]).exists()
                if not is_there:
                    found.append(f"the link {href} leads nowhere")
        page.close()
    return found


def main():
    folder, pages = Path(sys.argv[1]), [Path(page) for page in sys.argv[2:]]
    folder.mkdir(parents=True, exist_ok=True)
    failed = 0
    with sync_playwright() as playwright:
        chromium = shutil.which("chromium") or sys.exit("chromium is missing")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--disable-dev-shm-usage"])
        for path in pages:
            found = faults_of(browser, path, folder / ("-".join(path.with_suffix(".png").parts)))
            failed += len(found)
            print(f"{path}: {len(found) or 'no'} faults", *found[:10], sep="\n  ")
        browser.close()
    sys.exit(1 if failed else 0)


main()
