"""Position errors in MuJoCo of an MJCF and of its identified copy, after 1 s from measured states.

    python tests/benchmarks/bench_export.py [--into tests/benchmarks/export.json]

The commands are those of the tutorial docs/tutorial-simulator.md, in an empty folder.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))
from documented import DOCS, blocks, shell
from figures import EXPORT, figures, keep


def main() -> None:
    """Run the tutorial, and keep the errors of both files."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--into", type=Path, default=EXPORT)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for block in blocks(DOCS / "tutorial-simulator.md"):
            if block.file:
                (folder / block.file).write_text(block.code, "utf-8")
            elif block.kind == "sh":
                done = shell(block.code, folder)
                if done.returncode != block.code_expected:
                    raise SystemExit(done.stderr)
        found = figures(folder / "simulated" / "simulation.json")
    files = {}
    for row in found["files"]:
        last = row["horizons"][-1]
        files[row["file"]] = {
            "seconds": last["seconds"],
            "position_error": last["position_error"],
            "spread": last["spread"],
            "diverged": row["diverged"],
            "windows": found["windows"],
        }
        print(row["file"], files[row["file"]])
    keep(options.into, {"files": files})


if __name__ == "__main__":
    main()
