"""Faults that are planted in a report's page, so that each check is seen to fail."""

from dataclasses import dataclass
from typing import Callable

import checks


@dataclass
class Fault:
    """A fault: what of the page is replaced by what, who must find it, and what the finding says."""

    name: str
    instead_of: str
    planted: str
    look: Callable
    says: str


def with_page(look, width=1280, height=900):
    """Returns a look at an open page: what it found, and what the browser complained of."""

    def opened(browser, path):
        page, complaints = checks.opened(browser, path, width, height)
        found = look(page) + complaints
        page.context.close()
        return found

    return opened


def links(browser, path):
    return with_page(lambda page: checks.links(page, path))(browser, path)


def plain(browser, path):
    return with_page(lambda page: checks.plain(browser, path, page))(browser, path)


def nothing(_):
    return []


wide, narrow = with_page(checks.overflow), with_page(checks.overflow, 390, 844)
paper = with_page(checks.printed)
sorting, filtering = with_page(checks.sorting), with_page(checks.filtering)
linked = with_page(checks.linked)
MAIN, READY = "<main>", 'document.addEventListener("DOMContentLoaded", () => {'

FAULTS = [
    Fault("an exception", READY, READY + ' throw new Error("planted");', with_page(nothing), "planted"),
    Fault("an error in the console", READY, READY + ' console.error("planted");', with_page(nothing), "planted"),
    Fault("a picture from elsewhere", MAIN, MAIN + '<img alt="" src="other.png">', with_page(nothing), "loads"),
    Fault("a wide element", MAIN, MAIN + '<p style="width: 1400px; max-width: none">x</p>', wide, "window"),
    Fault("an element for wide windows only", MAIN, MAIN + '<p style="min-width: 500px">x</p>', narrow, "window"),
    Fault("a table that does not scroll", '<div class="scroll">\n<table class="ranking">', '<div>\n<table class="ranking">', narrow, "window"),
    Fault("words outside a drawing", "</svg>", '<text x="2000" y="10">planted</text></svg>', wide, "cut in its drawing"),
    Fault("a wide element in print", MAIN, MAIN + '<p style="width: 800px; max-width: none">x</p>', paper, "sticks out"),
    Fault("a box that scrolls on paper", MAIN, MAIN + '<div style="width: 9rem; overflow: auto; white-space: nowrap">' + "planted " * 9 + "</div>", paper, "cut in print"),
    Fault("a wide table of everything in print", "<th scope=\"col\">Intersection</th>", '<th scope="col" style="min-width: 900px">Intersection</th>', paper, "sticks out"),
    Fault("a link to no element", 'href="#ranking"', 'href="#rankings"', links, "no element for the link #rankings"),
    Fault("a link to no file", 'href="#ranking"', 'href="ranking.html"', links, "no file for the link ranking.html"),
    Fault("a table that is not there", "<code>scores.csv</code>", "<code>score.csv</code>", links, "score.csv"),
    Fault("a dot without its row", 'data-row="row-0"', 'data-row="row-x"', links, "no row row-x"),
    Fault("heads that do not sort", 'head.addEventListener("click", sort)', "void sort", sorting, "does not sort"),
    Fault("one direction of sorting", "(down ? -1 : 1)", "1", sorting, "sorts descending"),
    Fault("numbers as words", "value(a) - value(b)", "(a > b) - (a < b)", sorting, "sorts ascending"),
    Fault("rows that get lost in sorting", ".map(([row]) => row));", ".slice(1).map(([row]) => (row.remove(), row)).slice(1));", sorting, "loses rows"),
    Fault("a filter without effect", "row.hidden = !tests", "row.title = !tests", filtering, "rows are shown"),
    Fault("a filter that shows all of a choice", 'choice.value === "" ||', "true ||", filtering, "rows are shown"),
    Fault("a filter that forgets the map", 'classList.toggle("off", row.hidden)', 'classList.toggle("of", row.hidden)', filtering, "dots for"),
    Fault("a wrong number of rows", '" of " + rows.length', '" of " + shown.length', filtering, "is said of"),
    Fault("no field for words", "table.parentElement.before(bar)", "void bar", filtering, "no field for words"),
    Fault("rows without their dots", 'g class="tt" id="dot-', 'g class="tt" id="spot-', links, "no element for the link #dot-"),
    Fault("dots that lead nowhere", 'closest("g[data-row]")', 'closest("g[data-none]")', linked, "does not lead to its row"),
    Fault("a row that stays filtered away", "row.hidden = false", "row.title = ''", linked, "which was filtered away"),
    Fault("words that scripts write", READY, READY + ' document.querySelector("main").append("planted");', plain, "without scripts"),
]
