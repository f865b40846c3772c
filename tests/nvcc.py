"""nvcc of the machine, or of its packages of PyPI, and what it tells of a file."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from importlib.util import find_spec
from pathlib import Path

#: Of GPUs from 2020, 2022 and 2025.
ARCHITECTURES = ("sm_80", "sm_90", "sm_120")


def nvcc() -> str | None:
    """Return the path of nvcc; None without it."""
    spec = find_spec("nvidia")
    folders = spec.submodule_search_locations or () if spec else ()
    packaged = [path for folder in folders for path in sorted(Path(folder).glob("*/bin/nvcc"))]
    return str(packaged[0]) if packaged else shutil.which("nvcc")


def compiled(source: Path, architecture: str) -> dict[str, tuple[int, int]]:
    """Compile a .cu file; return registers of a thread and bytes of spills, by kernel.

    Kernels with an X for each state have " each" behind their name.
    """
    command = [str(nvcc()), "-O3", "-std=c++17", f"-arch={architecture}", "-Xptxas", "-v"]
    done = subprocess.run(
        [*command, "-c", str(source), "-o", os.devnull],
        cwd=source.parent, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = {}
    for part in re.split(r"Compiling entry function '", done.stderr)[1:]:
        mangled, _, about = part.partition("'")
        name = re.match(r"_ZN\d+\w+?_cuda\d+(\w+?)_states", mangled)
        registers = re.search(r"Used (\d+) registers", about)
        spills = re.search(r"(\d+) bytes spill stores", about)
        assert name
        assert registers
        assert spills
        each = " each" if "4EachE" in mangled else ""
        found[name[1] + each] = (int(registers[1]), int(spills[1]))
    return found
