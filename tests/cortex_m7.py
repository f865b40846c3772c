"""Programs for a Cortex-M7 (QEMU's board MPS2 AN500): built bare, run, instructions counted.

QEMU executes one instruction at a time and writes each address down; what a function takes is all
that is executed from its first instruction to its return, callees and libm included.
"""

from __future__ import annotations

import json
import random
import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from packages import c_files, run

M7 = ["arm-none-eabi-gcc", "-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard"]
TOOLS = (M7[0], "arm-none-eabi-nm", "arm-none-eabi-size", "qemu-system-arm")
REACH = (0.5, 3.1, 3.1, 100.0)  # rad: also angles that libm reduces
PLAIN = {"link": "1u", "mass": "2"}
LINK = """
MEMORY { code (rx) : ORIGIN = 0, LENGTH = 4M  ram (rwx) : ORIGIN = 0x20000000, LENGTH = 4M }
ENTRY(reset)
SECTIONS {
  .text : { KEEP(*(.vectors)) *(.text*) *(.rodata*) *(.ARM.exidx*) } > code
  .data : { *(.data*) } > ram
  .bss : { *(.bss*) *(COMMON) } > ram
  end = .;
}
"""
BOOT = """
extern int main(void);
void reset(void)
{
    *(volatile unsigned *)0xE000ED88u |= 0xFu << 20; /* the floating-point unit is on */
    __asm__ volatile("dsb\\n isb");
    (void)main();
    __asm__ volatile("movs r0, #0x18\\n ldr r1, =0x20026\\n bkpt 0xab"); /* exit */
    for (;;) {
    }
}
__attribute__((section(".vectors"), used)) static void (*const vectors[])(void)
    = { (void (*)(void))0x20400000u, reset };
"""


def missing() -> str:
    """Return which tool is not on this machine, or an empty text."""
    return next((tool for tool in TOOLS if shutil.which(tool) is None), "")


def instructions(
    package: Path, folder: Path, reaches: Sequence[float] = REACH
) -> dict[str, list[int]]:
    """Return how many instructions each kernel executes, at one point for each reach.

    Args:
        package: with its C and manifest.json.
        folder: to build in.
        reaches: of q, qd, ... that are drawn, rad, rad/s, ...
    """
    (folder / "link.ld").write_text(LINK)
    (folder / "boot.c").write_text(BOOT)
    (folder / "main.c").write_text(_calls(package, reaches))
    build = [*M7, "-std=gnu99", "-O2", "-ffunction-sections", "-Wl,--gc-sections", "-nostartfiles"]
    build += ["--specs=nosys.specs", "-T", "link.ld", f"-I{package}", "boot.c", "main.c"]
    run([*build, *c_files(package), "-lm", "-o", "program.elf"], folder)
    board = ["qemu-system-arm", "-M", "mps2-an500", "-nographic", "-semihosting"]
    log = ["-singlestep", "-d", "exec,nochain", "-D", "log"]
    run([*board, "-kernel", "program.elf", *log], folder)
    symbols = run(["arm-none-eabi-nm", "program.elf"], folder)
    kernels = "|".join(kernel["name"] for kernel in _manifest(package)["kernels"])
    found = re.finditer(rf"^(\w+) T {package.name}_({kernels})$", symbols, re.MULTILINE)
    return _counted((folder / "log").read_text(), {int(f[1], 16): f[2] for f in found})


def sizes(package: Path, folder: Path) -> dict[str, int]:
    """Return the bytes of code and constants of every source."""
    run([*M7, "-std=c99", "-O2", "-c", *c_files(package)], folder)
    rows = run(["arm-none-eabi-size", *sorted(folder.glob(f"{package.name}_*.o"))], folder)
    listed = [row.split() for row in rows.splitlines()[1:]]
    return {Path(row[5]).stem.removeprefix(f"{package.name}_"): int(row[0]) for row in listed}


def _counted(log: str, starts: dict[int, str]) -> dict[str, list[int]]:
    found: dict[str, list[int]] = {}
    before = end = count = 0
    current = ""
    for match in re.finditer(r"\[[0-9a-f]+/([0-9a-f]+)/", log):
        address = int(match[1], 16)
        if current:
            if address == end:
                found.setdefault(current, []).append(count)
                current = ""
            count += 1
        if not current and address in starts:
            current, end, count = starts[address], before + 4, 1
        before = address
    return found


def _manifest(package: Path) -> Any:
    return json.loads((package / "manifest.json").read_text())


def _calls(package: Path, reaches: Sequence[float]) -> str:
    """Write a program that calls every kernel at every point."""
    name, draw = package.name, random.Random(5)
    manifest = _manifest(package)
    lines = [f'#include "{name}.h"', f"static volatile {name}_real sink;", "int main(void)", "{"]
    for kernel in manifest["kernels"]:
        for reach in reaches:
            lines.append("    {")
            for given in kernel["inputs"]:
                if given["name"] in PLAIN:
                    continue
                size = (
                    given["shape"][0] if given["name"] != "X" else len(manifest["base_parameters"])
                )
                values = (
                    _parameters(manifest)
                    if given["name"] == "X"
                    else [draw.uniform(-reach, reach) for _ in range(size)]
                )
                listed = ", ".join(f"({name}_real){v!r}" for v in values)
                lines.append(f"        static {name}_real {given['name']}[] = {{ {listed} }};")
            known = [given["name"] for given in kernel["inputs"]]
            outputs = []
            for output in kernel["outputs"]:
                if output["name"] in known:
                    continue
                size = 1
                for extent in output["shape"]:
                    size *= extent
                lines.append(f"        static {name}_real {output['name']}[{size}];")
                outputs.append(output["name"])
            arguments = ", ".join([PLAIN.get(key, key) for key in known] + outputs)
            lines.append(f"        (void){name}_{kernel['name']}({arguments});")
            lines += [f"        sink = {output}[0];" for output in outputs]
            lines.append("    }")
    return "\n".join([*lines, "    return 0;", "}", ""])


def _parameters(manifest: Any) -> Sequence[float]:
    """Return X of a robot that can exist: one that cannot stops kernels with a status early."""
    points = manifest["verification"]["points"].get("forward_dynamics")
    return points[0]["X"] if points else [1.0] * len(manifest["base_parameters"])
