"""Pages under test: their elements, and what a browser that can reach no host does with them."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

BROWSER = next(filter(None, map(shutil.which, ("chromium", "google-chrome", "chrome"))), None)
HOSTILE = "</script><script>console.error(1)</script><img src=http://a.invalid/x onerror=alert(1)>"


class Page(HTMLParser):
    """The elements of a page, the titles of the plots of each figure, and its text."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.figures: list[list[str]] = []
        self.text = ""
        self._inside = ""
        self.feed(html)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._inside = tag
        if tag == "figcaption":
            self.figures[-1].append("")
        if ("class", "curves") in attrs:
            self.figures.append([])

    def handle_endtag(self, tag: str) -> None:  # noqa: ARG002
        self._inside = ""

    def handle_data(self, data: str) -> None:
        if self._inside == "figcaption":
            self.figures[-1][-1] += data
        elif self._inside not in ("script", "style"):
            self.text += data


WIDTHS = (1400, 800, 390)
#: Whatever stands outside the window, or outside its own box, is clipped.
_MEASURE = """<script>addEventListener("load", () => setTimeout(() => {
  const said = [], name = (e) => e.tagName + "." + e.className + " " + e.textContent.slice(0, 40);
  for (const e of document.querySelectorAll("main *")) {
    if (e.closest("script, svg")) continue;
    const box = e.getBoundingClientRect();
    if (box.width && (box.right > innerWidth + 1 || box.left < -1)) said.push("out: " + name(e));
    const wider = e.clientWidth && e.scrollWidth > e.clientWidth + 1;
    if (wider && e.matches(".scroll, td, th, dd, p, figcaption"))
      said.push("cut: " + name(e));
  }
  const wide = document.scrollingElement.scrollWidth;
  if (wide > innerWidth) said.push("scrolls sideways: " + wide + " px");
  for (const area of document.querySelectorAll(".area")) {
    const box = area.getBoundingClientRect();
    let before = -1;  // of ticks from left to right, none may touch the next
    for (const tick of area.querySelectorAll(".x")) {
      const own = tick.getBoundingClientRect();
      if (own.width && own.left < before) said.push("touches: " + tick.textContent);
      before = own.right;
    }
    if (box.width && box.width < 100) said.push("narrow: " + area.textContent);
  }
  parent.postMessage(JSON.stringify([innerWidth, said]), "*");
}, 400));</script>"""


def _measured(html: str, script: str) -> str:
    """Return a page with a script, which its own policy forbids."""
    allowed = html.replace("default-src 'none';", "default-src 'none'; script-src 'unsafe-inline';")
    return allowed.replace("</body>", f"{script}</body>")


def clipped(html: str, folder: Path) -> dict[int, list[str]]:
    """Return what a browser shows only a part of, by the width of the window in pixels."""
    (folder / "seen.html").write_text(_measured(html, _MEASURE), "utf-8")
    frames = "".join(  # a window cannot be as narrow as a phone, a frame can
        f"<iframe src='seen.html' style='border:0;width:{width}px;height:900px'></iframe>"
        for width in WIDTHS
    )
    answer = {int(width): list(said) for width, said in _answers(frames, folder)}
    assert set(answer) == set(WIDTHS), answer
    return answer


def below_first_screen(
    html: str, folder: Path, sizes: Iterable[tuple[int, int]]
) -> dict[tuple[int, int], list[str]]:
    """Return what of the verdict and of the open plots is below the first screen, by its size.

    Args:
        html: the page.
        folder: for the page.
        sizes: widths and heights of the screen, in pixels.
    """
    (folder / "first.html").write_text(_measured(html, _FIRST), "utf-8")
    frames = "".join(
        f"<iframe src='first.html' style='border:0;width:{width}px;height:{height}px'></iframe>"
        for width, height in sizes
    )
    return {(width, height): list(below) for width, height, below in _answers(frames, folder)}


_FIRST = """<script>addEventListener("load", () => setTimeout(() => {
  const wanted = document.querySelectorAll(".headline, .verdict, section .curves > div .area");
  const below = [...wanted].filter((e) => e.getBoundingClientRect().bottom > innerHeight);
  const texts = below.map((e) => e.textContent.slice(0, 40));
  parent.postMessage(JSON.stringify([innerWidth, innerHeight, texts]), "*");
}, 400));</script>"""


#: What a phone shows of a page of the documentation; blocks and tables may scroll by themselves.
_ON_A_PHONE = """<script>addEventListener("load", () => setTimeout(() => {
  const said = [], name = (e) => e.tagName + " " + e.textContent.slice(0, 40);
  const moves = (e) => e && (/auto|scroll/.test(getComputedStyle(e).overflowX) ||
    moves(e.parentElement === document.body ? null : e.parentElement));
  const wide = document.scrollingElement.scrollWidth;
  if (wide > innerWidth) said.push("scrolls sideways: " + wide + " px");
  for (const e of document.querySelectorAll("article *")) {
    const box = e.getBoundingClientRect();
    if (box.width > 1 && (box.right > innerWidth + 1 || box.left < -1) && !moves(e))
      said.push("out: " + name(e));
  }
  const text = document.querySelector("article").cloneNode(true);
  for (const e of text.querySelectorAll("pre, code, script, style")) e.remove();
  const raw = text.textContent.match(/\\\\[a-zA-Z]+|[$][$]|[`]{3}|<!--/);
  if (raw) said.push("markup: " + raw[0]);
  for (const e of document.querySelectorAll("math"))
    if (!e.getBoundingClientRect().height) said.push("not drawn: " + name(e));
  for (const e of document.querySelectorAll("article img"))
    if (!e.naturalWidth) said.push("no picture: " + e.src);
  parent.postMessage(JSON.stringify([PAGE, innerWidth, said]), "*");
}, 400));</script>"""


def seen_on_a_phone(
    site: Path, folder: Path, names: Iterable[str]
) -> dict[str, tuple[int, list[str]]]:
    """Return for some pages of a site how wide their window is, and what is wrong in them."""
    shutil.copytree(site, folder, dirs_exist_ok=True)
    pages = [folder / name for name in names]
    for page in pages:
        measure = _ON_A_PHONE.replace("PAGE", json.dumps(str(page.relative_to(folder))))
        page.write_text(page.read_text("utf-8").replace("</body>", measure + "</body>"), "utf-8")
    frames = "".join(
        f"<iframe src='{page.relative_to(folder)}' style='border:0;width:390px;height:844px'>"
        "</iframe>"
        for page in pages
    )
    answers = _answers(frames, folder)
    return {page: (width, list(said)) for page, width, said in answers}


def _answers(frames: str, folder: Path) -> list[list[Any]]:
    """Open frames in one window, and return the messages that they post to it."""
    page = (
        f"<body>{frames}<script>const all = []; addEventListener('message', (e) => {{"
        "all.push(JSON.parse(e.data)); document.body.dataset.said = JSON.stringify(all)})</script>"
    )
    dom = visit(page, folder, "--window-size=1500,900").dom
    found = re.search(r'data-said="([^"]*)"', dom)
    assert found, dom[:2000]
    return list(json.loads(unescape(found[1])))


def sheets(html: str, folder: Path) -> int:
    """Return on how many sheets of paper a browser prints a page."""
    assert BROWSER is not None
    page, paper = folder / "printed.html", folder / "printed.pdf"
    page.write_text(html, encoding="utf-8")
    options = (
        *("--headless", "--no-sandbox", "--disable-gpu", "--no-first-run"),
        *("--disable-background-networking", "--host-resolver-rules=MAP * ~NOTFOUND"),
        *("--virtual-time-budget=5000", f"--user-data-dir={folder / 'profile'}"),
        f"--print-to-pdf={paper}",
    )
    subprocess.run([BROWSER, *options, page.as_uri()], capture_output=True, timeout=180, check=True)
    return len(re.findall(rb"/Type\s*/Page\b(?!s)", paper.read_bytes()))


@dataclass(frozen=True)
class Visit:
    """What a browser did with a page: its elements after the scripts, messages, requests."""

    dom: str
    console: tuple[str, ...]
    requests: tuple[str, ...]


def visit(html: str, folder: Path, *more: str) -> Visit:
    """Open `html` from a file in a browser that can reach no host, with more options of it."""
    assert BROWSER is not None
    page, log = folder / "page.html", folder / "net.json"
    page.write_text(html, encoding="utf-8")
    options = (
        *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
        *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
        *("--host-resolver-rules=MAP * ~NOTFOUND", "--virtual-time-budget=5000"),
        *("--enable-logging=stderr", "--v=0", f"--log-net-log={log}"),
        *(f"--user-data-dir={folder / 'profile'}", "--dump-dom", *more),
    )
    done = subprocess.run(
        [BROWSER, *options, page.as_uri()], capture_output=True, text=True, timeout=180, check=True
    )
    # What the browser itself asks for (clock, updates) has no origin; a page's request has one.
    requests = [
        event["params"]["url"]
        for event in json.loads(log.read_text(encoding="utf-8"))["events"]
        if event.get("params", {}).get("initiator", "not an origin") != "not an origin"
        and not event["params"].get("url", "file:").startswith(("file:", "data:", "blob:"))
    ]
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    return Visit(done.stdout, tuple(console), tuple(requests))
