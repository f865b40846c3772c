"""Draw report*.webp from pages of results: python screenshots.py FOLDER

FOLDER is one in which `symgen demo` and the `symgen payload` of the page on payloads ran. It needs
Chromium or Chrome. The pictures are screenshots of report pages.
"""

from __future__ import annotations

import base64
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

WIDTH = 880
#: Picture, the page in the folder, and the height in pixels.
PAGES = (
    ("report.webp", "symgen-demo/better/report.html", 944),
    ("report_diagnosis.webp", "symgen-demo/diagnosis/report.html", 1180),
    ("report_payload.webp", "load/report.html", 1020),
)
BROWSERS = ("chromium", "google-chrome", "chrome")
#: Writes a picture again as WebP, which is a third of its size.
SMALLER = """<img src="data:image/png;base64,{}"><script>onload = () => {{
  const seen = document.querySelector("img"), drawn = document.createElement("canvas");
  [drawn.width, drawn.height] = [seen.naturalWidth, seen.naturalHeight];
  drawn.getContext("2d").drawImage(seen, 0, 0);
  document.body.textContent = drawn.toDataURL("image/webp", 0.9);
}}</script>"""


def take(page: Path, height: int) -> bytes:
    """Return a screenshot of the top of a page as WebP."""
    with tempfile.TemporaryDirectory() as folder:
        shot, smaller = Path(folder) / "shot.png", Path(folder) / "smaller.html"
        browse(folder, f"--window-size={WIDTH},{height}", f"--screenshot={shot}", page.as_uri())
        smaller.write_text(SMALLER.format(base64.b64encode(shot.read_bytes()).decode()))
        found = re.search(
            "data:image/webp;base64,([^<]+)<", browse(folder, "--dump-dom", smaller.as_uri())
        )
    assert found
    return base64.b64decode(found[1])


def browse(folder: str, *options: str) -> str:
    """Run a browser without a window and a network, and return what it prints."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise SystemExit(f"screenshots.py: none of {', '.join(BROWSERS)} is on the PATH")
    own = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
           "--virtual-time-budget=5000", "--host-resolver-rules=MAP * ~NOTFOUND",
           f"--user-data-dir={folder}/profile")  # fmt: skip
    done = subprocess.run(
        [browser, *own, *options], check=True, capture_output=True, text=True, timeout=180
    )
    return done.stdout


if __name__ == "__main__":
    for picture, page, height in PAGES:
        Path(picture).write_bytes(take((Path(sys.argv[1]) / page).resolve(), height))
