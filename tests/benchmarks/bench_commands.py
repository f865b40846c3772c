"""Processor time of each command on the arm of the pages, with an empty cache and again.

    python tests/benchmarks/bench_commands.py --into tests/benchmarks/commands.json

The arm has two joints, its logs 10 s at 200 Hz. The first run of a command derives and compiles the
model; later runs take it from the cache.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))
from figures import keep
from workshop import furnish

#: Commands and their output, which is another one in each turn.
COMMANDS = {
    "generate": "generate arm.toml --into {turn}_package",
    "excite": "excite arm.toml --duration 10 --searches 1 --into {turn}_motion.csv",
    "simulate": "simulate arm.toml --parameters P.toml --duration 10 --into {turn}_made.csv",
    "identify": "identify arm.toml train.csv --validation test.csv --into {turn}_found",
    "predict": "predict arm.toml test.csv --parameters result --into {turn}_tested",
    "diagnose": "diagnose arm.toml train.csv --validation test.csv --into {turn}_why",
    "payload": "payload arm.toml carried.csv --parameters result --into {turn}_load",
    "demo": "demo --into {turn}_demo",
}
#: Exit codes of commands that ran: the answer is yes, or no.
ANSWERS = (0, 1)


def seconds(command: str, folder: Path, cache: Path) -> float:
    """Return the processor time of a command and of its children, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, "-m", "symgen", *command.split()],
        cwd=folder, env=os.environ | {"SYMGEN_CACHE": str(cache)}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    if done.returncode not in ANSWERS:
        raise SystemExit(f"symgen {command}: {done.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--into", type=Path, default=Path("commands.json"))
    options = parser.parse_args()
    figures = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        furnish(folder)
        for command, line in COMMANDS.items():
            cache = folder / f"cache_{command}"
            taken = {
                turn: round(seconds(line.format(turn=turn), folder, cache), 1)
                for turn in ("first", "again")
            }
            figures[command] = taken
            print(command, figures[command], flush=True)
    keep(options.into, {"commands": figures})


if __name__ == "__main__":
    main()
