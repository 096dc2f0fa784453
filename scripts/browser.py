"""Opens pages in Chromium: nothing may complain, load anything, be wider than the window, or link to nothing.

    python scripts/browser.py FOLDER PAGE...     FOLDER gets a screenshot and PDF files of each page

On paper (A4 and Letter; landscape where the page asks for it) no column may be cut off, and an intersection takes at most
two sheets.

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
FURTHEST = "() => Math.max(...[...document.querySelectorAll('th, td, .box, svg')].map((e) => e.getBoundingClientRect().right))"
LANDSCAPE = "() => /@page \\{ size: landscape/.test(document.head.textContent)"
# Long and short side, millimetres.
PAPER = {"A4": (297, 210), "Letter": (279.4, 215.9)}
MARGINS_MM = 2 * 10


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


def faults_on_paper(browser, path, pdf):
    """Of pages in landscape, which are the sheets, columns have to end within the margins; at 96 pixels an inch."""
    found = []
    page = browser.new_page()
    page.goto(path.resolve().as_uri())
    page.emulate_media(media="print")
    landscape = page.evaluate(LANDSCAPE)
    for name, (long_mm, short_mm) in PAPER.items():
        width_mm = (long_mm if landscape else short_mm) - MARGINS_MM
        page.set_viewport_size({"width": int(width_mm / 25.4 * 96), "height": 900})
        wide, has = page.evaluate(FURTHEST), page.viewport_size["width"]
        if landscape and wide > has + 1:
            found.append(f"on {name} columns end at {wide:.0f} px, the paper at {has}")
        page.pdf(path=pdf.with_suffix(f".{name}.pdf"), format=name, landscape=landscape, print_background=True)
        sheets = pdf.with_suffix(f".{name}.pdf").read_bytes().count(b"/Type /Page\n")
        if path.parent.name == "intersections" and sheets > 2:
            found.append(f"on {name} it takes {sheets} sheets")
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
            picture = folder / "-".join(path.with_suffix(".png").parts)
            found = faults_of(browser, path, picture) + faults_on_paper(browser, path, picture)
            failed += len(found)
            print(f"{path}: {len(found) or 'no'} faults", *found[:10], sep="\n  ")
        browser.close()
    sys.exit(1 if failed else 0)


main()
