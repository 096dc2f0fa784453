"""What a page of ours must do in a browser. Each check returns the faults that it finds, in words."""

import re
import time
from pathlib import Path

# Widths in CSS pixels of what is printed, the narrower of A4 and Letter: upright with margins of 15 mm (A4), and the
# pages of the widest tables across with margins of 10 mm (Letter).
UPRIGHT_PX = 680
ACROSS_PX = 980

# Elements that stick out of the page (`width`, within `root` and outside `but`), content that is cut in print, and
# words that stick out of their drawing.
CUT = """([width, root, but, printed]) => {
  const faults = [], name = (e) => {
    const text = e.textContent.trim().replace(/\\s+/g, " ").slice(0, 40);
    return e.tagName.toLowerCase() + (e.id ? "#" + e.id : e.className && e.className.baseVal === undefined ? "." + e.className : "") + ` "${text}"`;
  };
  const shown = (e) => e.getClientRects().length > 0 && (!e.checkVisibility || e.checkVisibility());
  const scrolls = (e) => /auto|scroll|hidden/.test(getComputedStyle(e).overflowX);
  const inside = (e) => {
    for (let up = e.parentElement; up && up !== document.body; up = up.parentElement) if (scrolls(up)) return true;
    return false;
  };
  const all = [...document.querySelectorAll(root + ", " + root + " *")].filter((e) => shown(e) && !(but && e.closest(but)));
  for (const e of all) {
    const svg = e.closest("svg");
    const r = e.getBoundingClientRect();
    if (e.tagName === "text") {
      const frame = svg.getBoundingClientRect();
      if (r.left < frame.left - 1 || r.right > frame.right + 1 || r.top < frame.top - 1 || r.bottom > frame.bottom + 1)
        faults.push("cut in its drawing: " + name(e));
    }
    if (svg && e !== svg) continue;
    if ((r.right > width + 1 || r.left < -1) && r.width > 0 && !inside(e))
      faults.push(`sticks out of the page by ${Math.round(Math.max(r.right - width, -r.left))} px: ` + name(e));
    if (printed && scrolls(e) && (e.scrollWidth > e.clientWidth + 1 || e.scrollHeight > e.clientHeight + 1))
      faults.push("cut in print: " + name(e));
  }
  const wide = document.documentElement.scrollWidth;
  if (!but && wide > width) faults.push(`the page is ${wide} px wide, the window ${width}`);
  return faults;
}"""

# Clicks every head of every sortable table twice, and holds the order against one that is computed here.
SORT = """() => {
  const faults = [];
  for (const table of document.querySelectorAll("table.sortable")) {
    const heads = [...table.querySelectorAll("thead th")];
    heads.forEach((head, column) => {
      const keys = () => [...table.tBodies[0].rows].map((r) => r.cells[column].textContent.trim());
      const isNumber = head.classList.contains("n");
      const value = (k) => {
        const [, side, digits] = k.match(/^([<>]?)([-+]?\\d[\\d,]*\\.?\\d*)/) ?? [];
        return Number(digits?.replaceAll(",", "") ?? NaN) + ({ ">": 0.001, "<": -0.001 }[side] ?? 0);
      };
      const lacks = (k) => (isNumber ? Number.isNaN(value(k)) : k === "" || k === "\\u2013");
      const name = head.textContent.trim();
      const before = keys();
      const distinct = new Set(before.filter((k) => !lacks(k)).map((k) => (isNumber ? value(k) : k))).size;
      const seen = {};
      for (const [way, sign] of [["ascending", 1], ["descending", -1]]) {
        head.click();
        if (head.getAttribute("aria-sort") !== way) faults.push(`"${name}" does not say that it sorts ${way}`);
        const after = keys();
        seen[way] = after.join("|");
        if ([...after].sort().join("|") !== [...before].sort().join("|")) faults.push(`"${name}" loses rows`);
        for (let i = 1; i < after.length; i++) {
          const [a, b] = [after[i - 1], after[i]];
          const order = isNumber ? value(a) - value(b) : a.localeCompare(b, "en", { numeric: true });
          const wrong = lacks(a) || lacks(b) ? lacks(a) && !lacks(b) : sign * order > 0;
          if (wrong) {
            faults.push(`"${name}" sorts ${way}: "${a}" before "${b}"`);
            break;
          }
        }
      }
      if (distinct > 1 && seen.ascending === seen.descending) faults.push(`"${name}" does not sort`);
    });
  }
  return faults;
}"""

# What of a table and of its map is shown.
SHOWN = """(table) => {
  const rows = [...table.tBodies[0].rows];
  const shown = rows.filter((r) => r.getClientRects().length > 0);
  const dots = [...document.querySelectorAll("g[data-row]")].filter((g) => rows.some((r) => r.id === g.dataset.row));
  return {
    all: rows.map((r) => r.textContent.toLowerCase()),
    rows: shown.map((r) => r.textContent.toLowerCase()),
    ids: shown.map((r) => r.id).sort(),
    dots: dots.length,
    lit: dots.filter((g) => Number(getComputedStyle(g).opacity) === 1).map((g) => g.dataset.row).sort(),
  };
}"""

IN_WINDOW = """(e) => {
  const r = e.getBoundingClientRect();
  return r.height > 0 && r.bottom > 0 && r.top < innerHeight && r.right > 0 && r.left < innerWidth;
}"""


def opened(browser, path, width, height=900, scripts=True):
    """Opens a page; the second value gathers what the browser complains of and what the page loads."""
    context = browser.new_context(viewport={"width": width, "height": height}, java_script_enabled=scripts)
    page = context.new_page()
    faults = []
    page.on("console", lambda m: faults.append(f"console: {m.text}") if m.type in ("error", "warning") else None)
    page.on("pageerror", lambda e: faults.append(f"exception: {e}"))
    own = Path(path).resolve().as_uri()
    page.on("request", lambda r: None if r.url.split("#")[0] == own else faults.append(f"loads {r.url}"))
    page.goto(own)
    return page, faults


def overflow(page):
    return page.evaluate(CUT, [page.viewport_size["width"], "body", "", False])


def printed(page):
    """What would be cut on paper."""
    page.emulate_media(media="print")
    faults = []
    for width, root, but in [(UPRIGHT_PX, "body", "#all"), (ACROSS_PX, "#all", "")]:
        page.set_viewport_size({"width": width, "height": 1000})
        faults += page.evaluate(CUT, [width, root, but or None, True]) if page.query_selector(root) else []
    pdf = page.pdf(prefer_css_page_size=True, format="A4")
    if not pdf.startswith(b"%PDF"):
        faults.append("does not print")
    page.emulate_media(media="screen")
    return faults


def links(page, path):
    """Links that lead nowhere, and files that are named and not there."""
    faults, folder = [], Path(path).resolve().parent
    for href in page.eval_on_selector_all("a[href]", "all => all.map((a) => a.getAttribute('href'))"):
        if href.startswith("#"):
            if not page.evaluate("(id) => document.getElementById(id) !== null", href[1:]):
                faults.append(f"no element for the link {href}")
        elif not re.match(r"https://", href) and not (folder / href.split("#")[0]).exists():
            faults.append(f"no file for the link {href}")
    for row in page.eval_on_selector_all("g[data-row]", "all => all.map((g) => g.dataset.row)"):
        if not page.evaluate("(id) => document.getElementById(id) !== null", row):
            faults.append(f"no row {row} for its dot")
    # Settings name files of the run, which are not beside its page.
    text = page.evaluate("() => [...document.querySelectorAll('main > section:not(#provenance), footer')]"
                         ".map((e) => e.textContent).join(' ')")
    for name in sorted(set(re.findall(r"(?<![\w/.*-])[\w-]+\.(?:csv|geojson)\b", text))):
        if not (folder / name).exists():
            faults.append(f"names {name}, which is not beside it")
    return faults


def sorting(page):
    return page.evaluate(SORT)


def filtering(page):
    """Words and choices leave the rows that have them, and their dots on the map."""
    faults = []
    for table in page.query_selector_all("table.filterable"):
        bar = table.evaluate_handle("(t) => t.parentElement.previousElementSibling").as_element()
        words = bar.query_selector("input") if bar else None
        if words is None:
            faults.append("a table that filters has no field for words")
            continue

        def hold(what, test):
            seen = table.evaluate(SHOWN)
            wanted = [row for row in seen["all"] if test(row)]
            if sorted(seen["rows"]) != sorted(wanted):
                faults.append(f"{what}: {len(seen['rows'])} rows are shown, {len(wanted)} have it")
            said = bar.query_selector("output").inner_text()
            if said != f"{len(seen['rows'])} of {len(seen['all'])} rows":
                faults.append(f'{what}: "{said}" is said of {len(seen["rows"])} of {len(seen["all"])} rows')
            if seen["dots"] and seen["lit"] != sorted(i for i in seen["ids"] if i):
                faults.append(f"{what}: {len(seen['lit'])} dots for {len(seen['ids'])} rows")

        rows = table.evaluate(SHOWN)["all"]
        name = table.evaluate("(t) => t.tBodies[0].rows[t.tBodies[0].rows.length >> 1].cells[0].firstChild.textContent")
        for word in [name.split()[0].lower(), "no row has this"]:
            words.fill(word)
            hold(f'"{word}"', lambda row: all(part in row for part in word.split()))
        words.fill("")
        hold("no words", lambda row: True)
        for choice in bar.query_selector_all("select"):
            for value in choice.evaluate("(s) => [...s.options].map((o) => o.value)"):
                choice.select_option(value)
                column = choice.evaluate("(s) => s.parentElement.textContent.trim().split(' ')[0]")
                cells = table.evaluate(
                    "(t, name) => { const i = [...t.querySelectorAll('thead th')].findIndex((h) => h.dataset.filter === name);"
                    " return [...t.tBodies[0].rows].map((r) => [r.textContent.toLowerCase(), r.cells[i].textContent.trim()]); }",
                    column,
                )
                wanted = sorted(row for row, cell in cells if value in ("", cell))
                hold(f"{column} {value}", lambda row: row in wanted)
            choice.select_option("")
        if len(rows) != len(table.evaluate(SHOWN)["rows"]):
            faults.append("rows stay hidden when nothing is asked for")
    return faults


def linked(page):
    """A row leads to its dot on the map and a dot to its row, also to one that is filtered away."""
    faults = []
    ways = page.query_selector_all('table a[href^="#dot-"]')
    if not ways:
        return faults
    way = ways[len(ways) // 2]
    way.scroll_into_view_if_needed()
    way.click()
    dot = page.query_selector(":target")
    if dot is None or not dot.evaluate(IN_WINDOW):
        faults.append(f"{way.get_attribute('href')} leads to no dot that can be seen")
        return faults
    words = page.query_selector(".controls input")
    for hidden in [False, True]:
        if hidden and words:
            words.fill("no row has this")
        dot.dispatch_event("click")
        row = page.query_selector("tr:target")
        if row is None or not row.evaluate(IN_WINDOW):
            faults.append(f"a dot does not lead to its row{', which was filtered away' if hidden else ''}")
        page.evaluate("() => { location.hash = ''; }")
    if words:
        words.fill("")
    return faults


def lay_out(page):
    """Lays out what waits until it comes into view, for its text is not counted before."""
    page.evaluate("() => document.querySelectorAll('.tall').forEach((t) => { t.style.contentVisibility = 'visible'; })")


def plain(browser, path, page):
    """Without scripts the page says the same."""
    lay_out(page)
    with_scripts = page.evaluate(
        "() => { document.querySelectorAll('.controls').forEach((c) => c.remove()); return document.body.innerText; }"
    )
    without, faults = opened(browser, path, 1280, scripts=False)
    lay_out(without)
    said = without.inner_text("body")
    if said.split() != with_scripts.split():
        faults.append(f"{len(said.split())} words can be read without scripts, {len(with_scripts.split())} with them")
    without.context.close()
    return faults


def opening_s(browser, path):
    """How long a page takes to open and to be painted, in seconds: the best of three times."""
    best = float("inf")
    for _ in range(3):
        begun = time.monotonic()
        page, _ = opened(browser, path, 1280)
        page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        best = min(best, time.monotonic() - begun)
        page.context.close()
    return best


def of_page(browser, path):
    """Returns all faults of a page, each with where it was found."""
    found = []

    def note(where, faults):
        found.extend(f"{where}: {fault}" for fault in faults)

    for width, height in [(1280, 900), (390, 844)]:
        page, complaints = opened(browser, path, width, height)
        note(f"{width} px", overflow(page))
        note(f"{width} px, links between map and table", linked(page))
        if width == 1280:
            note("links", links(page, path))
            note("without scripts", plain(browser, path, page))
            page.reload()
            note("in print", printed(page))
            page.set_viewport_size({"width": width, "height": height})
            note("sorting", sorting(page))
        note(f"{width} px, filtering", filtering(page))
        note(f"{width} px", complaints)
        page.context.close()
    return found
