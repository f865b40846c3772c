"""Worst-case stack of C functions, as a given compiler builds them.

`-fstack-usage` writes the frame size of every function that is not inlined. The assembly shows
which functions it calls or jumps to. There is no recursion, and no call through a pointer. Thus

    worst(f) = frame(f) + max of worst(g) over all g that f mentions

bounds the stack, except that of libm and of the compiler's memcpy and memset.
"""

from __future__ import annotations

import re
import subprocess
import tempfile
from collections.abc import Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

from symgen.runtime.build import Compiler, unpacked

FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-S", "-fstack-usage")
_TIMEOUT_SECONDS = 300
_FRAME = re.compile(r"(\w[\w.]*)\t(\d+)\t(?:static|dynamic,bounded)$")  # of FILE:LINE[:COLUMN]:NAME
_LABEL = re.compile(r"_?([A-Za-z][\w.]*):")


def worst_case_stack(sources: Mapping[str, bytes], compiler: Compiler) -> dict[str, int] | None:
    """Return the worst-case stack of every function that is not inlined, in bytes.

    Args:
        sources: name and content of every .c and .h file.
        compiler: from `find_compiler`, or a cross compiler.

    Returns:
        None if the compiler does not report frames, does not build, or if there is no bound.
    """
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        files = unpacked(sources, work)
        try:
            # x86-64 lets a leaf use 128 bytes that no frame counts, unless told otherwise.
            machine = _run([*compiler.command, "-dumpmachine"], work)
            red_zone = ["-mno-red-zone"] if machine.startswith("x86_64") else []
            _run([*compiler.command, *FLAGS, *red_zone, *files], work)
            usage = [(work / f"{Path(name).stem}.su").read_text() for name in files]
            assembly = [(work / f"{Path(name).stem}.s").read_text() for name in files]
        except (OSError, UnicodeError, subprocess.SubprocessError):
            return None
    # Static functions of two files may share a name: the larger frame stands for both.
    frames: dict[str, int] = {}
    for line in "".join(usage).splitlines():
        found = _FRAME.search(line)
        if found is None:
            return None  # a frame without bound
        frames[found[1]] = max(int(found[2]), frames.get(found[1], 0))
    calls = _calls("".join(assembly), frames)
    # gcc counts the return address in the frame of the function called, clang does not.
    hidden = 8 if "clang" in compiler.version else 0
    worst: dict[str, int] = {}
    try:
        for name in TopologicalSorter(calls).static_order():
            deeper = max((worst[g] for g in calls[name]), default=0)
            worst[name] = hidden + frames[name] + deeper
    except CycleError:
        return None
    return worst


def _calls(assembly: str, frames: Mapping[str, int]) -> dict[str, set[str]]:
    """Return which functions the instructions of each function name."""
    calls: dict[str, set[str]] = {name: set() for name in frames}
    current: set[str] = set()
    for line in assembly.splitlines():
        label = _LABEL.match(line)
        if label is not None and label[1] in calls:
            current = calls[label[1]]
        elif label is None and not line.lstrip().startswith("."):
            words = {word.lstrip("_") for word in re.findall(r"\w[\w.]*", line)}
            current |= words.intersection(frames)
    return calls


def _run(command: list[str], folder: Path) -> str:
    return subprocess.run(
        command, cwd=folder, capture_output=True, text=True, timeout=_TIMEOUT_SECONDS, check=True
    ).stdout
