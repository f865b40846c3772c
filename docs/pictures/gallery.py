"""Draw report*.png from the FOLDER of the gallery's commands: python gallery.py FOLDER

It needs Chromium or Chrome. The pictures are screenshots of report pages.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

WIDTH = 880
#: Picture, the page in the folder, and the height in pixels that keeps the file below 150 kB.
PAGES = (
    ("report.png", "symgen-demo/better/report.html", 940),
    ("report_diagnosis.png", "symgen-demo/diagnosis/report.html", 1090),
    ("report_payload.png", "load/report.html", 1020),
    ("report_study.png", "study/report.html", 1104),
    ("report_comparison.png", "comparison.html", 790),
)
BROWSERS = ("chromium", "google-chrome", "chrome")


def take(page: Path, picture: Path, height: int) -> None:
    """Write a screenshot of the top of a page."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        raise SystemExit(f"gallery.py: none of {', '.join(BROWSERS)} is on the PATH")
    with tempfile.TemporaryDirectory() as profile:
        subprocess.run(
            [browser, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
             "--virtual-time-budget=5000", "--host-resolver-rules=MAP * ~NOTFOUND",
             f"--user-data-dir={profile}", f"--window-size={WIDTH},{height}",
             f"--screenshot={picture.resolve()}", page.resolve().as_uri()],
            check=True, capture_output=True, timeout=180,
        )  # fmt: skip


if __name__ == "__main__":
    for picture, page, height in PAGES:
        take(Path(sys.argv[1]) / page, Path(picture), height)
