"""Memory of functions on microcontrollers: code and stack of float packages, without libm.

    python tests/benchmarks/bench_firmware.py [--into tests/benchmarks/firmware.json]

It compiles with -O2 for a Cortex-M4 and with -Os for an ATmega2560, and reads the sections of the
objects and what -fstack-usage prints.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "docs"))
from figures import FIRMWARE, keep
from packages import run

import symgen

ROBOTS = ("planar2r", "ur10e", "panda")
KERNELS = ("gravity_torque", "inverse_dynamics", "forward_dynamics")
COMPILERS = {
    "cortex_m4": "arm-none-eabi-gcc -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard -O2",
    "atmega2560": "avr-gcc -mmcu=atmega2560 -Os",
}


def memory(compiler: str, source: Path, folder: Path) -> dict[str, int]:
    """Return the bytes of code, of data and of stack of the function in a file."""
    words = compiler.split()
    run([*words, "-std=c99", "-fstack-usage", "-c", source, "-o", "kernel.o"], folder)
    size = words[0].replace("-gcc", "-size")
    text, data, bss = map(int, run([size, "kernel.o"], folder).splitlines()[1].split()[:3])
    used = [line.split("\t") for line in (folder / "kernel.su").read_text().splitlines()]
    (stack,) = (int(row[1]) for row in used if row[0].endswith(f":{source.stem}"))
    return {"code": text, "data": data + bss, "stack": stack}


def main() -> None:
    """Compile each function for each processor, and keep its memory."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--into", type=Path, default=FIRMWARE)
    options = parser.parse_args()
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for robot in ROBOTS:
            model = symgen.derive(symgen.read_robot(robot), KERNELS)
            tree = symgen.generate(model, target="firmware", dtype="float")
            symgen.write_package(tree, folder / robot)
            for kernel in KERNELS:
                source = folder / robot / f"{tree.name}_{kernel}.c"
                found = {part: memory(c, source, folder) for part, c in COMPILERS.items()}
                rows.append({"robot": robot, "joints": model.robot.n, "kernel": kernel, **found})
                print(rows[-1])
        programs = [compiler.split()[0] for compiler in COMPILERS.values()]
        names = [f"{name} {run([name, '-dumpversion'], folder).strip()}" for name in programs]
    keep(options.into, {"compiler": ", ".join(names), "rows": rows})


if __name__ == "__main__":
    main()
