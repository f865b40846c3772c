"""Pages under test: their elements, and what a browser that can reach no host does with them."""

from __future__ import annotations

import json
import shutil
import subprocess
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

BROWSER = next(filter(None, map(shutil.which, ("chromium", "google-chrome", "chrome"))), None)
HOSTILE = "</script><script>console.error(1)</script><img src=http://a.invalid/x onerror=alert(1)>"


class Page(HTMLParser):
    """The elements of a page, its figures, and its text outside scripts and styles."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.figures: list[dict[str, Any]] = []
        self.scripts: list[str] = []
        self.text = ""
        self._inside = ""
        self.feed(html)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        self._inside = tag
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag: str) -> None:
        if tag == "script" and "data-figure" in self.tags[-1][1]:
            self.figures.append(json.loads(self.scripts[-1]))
        self._inside = ""

    def handle_data(self, data: str) -> None:
        if self._inside == "script":
            self.scripts[-1] += data
        elif self._inside != "style":
            self.text += data


@dataclass(frozen=True)
class Visit:
    """What a browser did with a page: its elements after the scripts, messages, requests."""

    dom: str
    console: tuple[str, ...]
    requests: tuple[str, ...]


def visit(html: str, folder: Path) -> Visit:
    """Open `html` from a file in a browser that can reach no host."""
    assert BROWSER is not None
    page, log = folder / "page.html", folder / "net.json"
    page.write_text(html, encoding="utf-8")
    options = (
        *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
        *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
        *("--host-resolver-rules=MAP * ~NOTFOUND", "--virtual-time-budget=3000"),
        *("--enable-logging=stderr", "--v=0", f"--log-net-log={log}"),
        *(f"--user-data-dir={folder / 'profile'}", "--dump-dom"),
    )
    done = subprocess.run(
        [BROWSER, *options, page.as_uri()], capture_output=True, text=True, timeout=60, check=True
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
