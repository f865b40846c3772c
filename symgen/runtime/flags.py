"""Choose the fastest compiler flags for this machine by measurement, and remember them.

The best instruction set depends on the processor: wide registers lower the clock of some, and
vectorised stores stall others. symgen compiles the same kernels with a few sets of flags, and times
them. The cache folder keeps the name of the fastest set, under a digest of the processor, the
compiler and the sets. The file holds no flags, so a changed file cannot add any.

SYMGEN_FLAGS selects a set instead ("plain": code that every processor of this kind can run).
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from symgen.cache import cache_folder, make_private
from symgen.codegen.kernels import Kernel
from symgen.codegen.model import derive
from symgen.codegen.package import library
from symgen.distributed import digest
from symgen.errors import BuildError
from symgen.places import written
from symgen.robot.toml_io import read_robot
from symgen.runtime import race
from symgen.runtime.build import _FLAGS, Compiler, native, unpacked
from symgen.runtime.turns import turn

_TIMEOUT_SECONDS = 60
_TURN_SECONDS = 300
_AS_GOOD = 1.01  # within this of the best, the simpler set is taken
_SAMPLES = 64  # outputs that stay in the cache
_ROBOT, _KERNELS = "puma560", ("energy_regressor", "torque_regressor")


@dataclass(frozen=True)
class FlagSet:
    """Flags with a name, and the instruction sets that the processor must have for them.

    Attributes:
        name: name in SYMGEN_FLAGS and in the cache.
        flags: flags of the compiler.
        needs: macros that the compiler predefines for such a processor.
    """

    name: str
    flags: tuple[str, ...]
    needs: tuple[str, ...] = ()


_FMA, _AVX2 = ("__FMA__",), ("__AVX2__", "__FMA__")
_STRAIGHT = "-fno-tree-slp-vectorize"  # gcc and clang: straight code stays as it is
#: The simpler ones first.
SETS = (
    FlagSet("plain", ()),
    FlagSet("fma", ("-mfma",), _FMA),
    FlagSet("fma-straight", ("-mfma", _STRAIGHT), _FMA),
    FlagSet("avx2", ("-mavx2", "-mfma"), _AVX2),
    FlagSet("native", ("-march=native",)),
    FlagSet("native-straight", ("-march=native", _STRAIGHT)),
)

_AVX512 = ("__AVX512F__", "__AVX512DQ__", "__AVX512VL__", "__AVX512BW__")
_WIDE = "-mprefer-vector-width=512"
#: For panels of samples, whose width follows from the instruction set: 2, 4 or 8.
PANEL_SETS = (
    FlagSet("plain", ()),
    FlagSet("avx2", ("-mavx2", "-mfma"), _AVX2),
    FlagSet(
        "avx512",
        ("-mavx512f", "-mavx512dq", "-mavx512vl", "-mavx512bw", "-mfma", _WIDE),
        _AVX512,
    ),
    FlagSet("native", ("-march=native",)),
    FlagSet("native-wide", ("-march=native", _WIDE), _AVX512),
)


@dataclass(frozen=True)
class Chosen:
    """The set that was chosen.

    Attributes:
        flags: the set.
        ratios: time of every measured set, relative to the first; empty without measurements.
        origin: a text: measured, remembered, or requested.
    """

    flags: FlagSet
    ratios: Mapping[str, float]
    origin: str


def chosen_flags(compiler: Compiler) -> Chosen:
    """Return the flags for single calls on this machine.

    Raises:
        BuildError: SYMGEN_FLAGS names no set.
    """
    return _asked() or _measured("kernels", SETS, compiler, _contest)


def panel_flags(compiler: Compiler) -> Chosen:
    """Return the flags for panels of samples on this machine.

    Raises:
        BuildError: SYMGEN_FLAGS names no set.
    """
    return _asked() or _measured("panels", PANEL_SETS, compiler, _panel_contest)


def _asked() -> Chosen | None:
    """Return the set that SYMGEN_FLAGS names."""
    wanted = os.environ.get("SYMGEN_FLAGS", "").strip()
    sets = {known.name: known for known in (*SETS, *PANEL_SETS)}
    if wanted and wanted not in sets:
        raise BuildError(f"SYMGEN_FLAGS is {wanted!r}; accepted: {', '.join(sets)}")
    return Chosen(sets[wanted], {}, "asked for by SYMGEN_FLAGS") if wanted else None


#: What is compiled and raced: the sources, and functions as `race.race` takes them.
Contest = tuple[Mapping[str, bytes], Sequence[Mapping[str, Any]]]


def _contest() -> Contest:
    """Return two kernels of an arm: one that computes much, one that stores much."""
    model = derive(read_robot(_ROBOT), _KERNELS)
    return library(model), [_entry(kernel, "batch", (_SAMPLES,)) for kernel in model.kernels]


def _panel_contest() -> Contest:
    """Return the first of them on panels, outputs in panels and in rows."""
    model = derive(read_robot(_ROBOT), _KERNELS[:1])
    (kernel,) = model.kernels
    entries = [_entry(kernel, layout, (0, _SAMPLES, 0)) for layout in ("panels", "rows")]
    return library(model, panels=True), entries


def _entry(kernel: Kernel, form: str, leading: tuple[int, ...]) -> dict[str, Any]:
    return {
        "name": f"{_ROBOT}_{kernel.name}_{form}",
        "leading": leading,
        "inputs": [_SAMPLES * a.size for a in kernel.inputs],
        "outputs": [_SAMPLES * output.size for output in kernel.outputs],
    }


def fastest(
    name: str, sets: Sequence[FlagSet], compiler: Compiler, contest: Callable[[], Contest]
) -> Chosen:
    """Return the fastest of some sets, from the cache folder or by a race.

    Sets that the processor or the compiler does not support are left out. If nothing can be
    measured, the result is the first set.

    Args:
        name: part of the name of the cache file.
        sets: sets to compare, simpler ones first.
        compiler: from `find_compiler`.
        contest: makes the kernels to compare; called only if the cache has no result.
    """
    _, macros = native(compiler)
    defined = {line.split()[1] for line in macros.splitlines() if len(line.split()) > 1}
    able = [s for s in sets if defined.issuperset(s.needs)]
    memory = _memory(name, able, compiler, macros)
    if (remembered := _remembered(memory, able)) is not None:
        return remembered
    with ExitStack() as stack:
        with suppress(OSError):  # a cache folder that cannot be written: nobody else waits
            make_private(memory.parent)
            stack.enter_context(turn(memory.parent, memory.stem, _TURN_SECONDS))
        if (remembered := _remembered(memory, able)) is not None:  # by another process meanwhile
            return remembered
        ratios = _race(able, compiler, contest())
        if not ratios:
            return Chosen(sets[0], {}, "nothing could be measured")
        best = min(ratios.values())
        winner = next(s for s in able if ratios.get(s.name, best * 2) <= best * _AS_GOOD)
        kept = {"winner": winner.name, "ratios": {k: round(v, 4) for k, v in ratios.items()}}
        with suppress(OSError):  # a folder that cannot be written costs a race a process
            written(memory, json.dumps(kept).encode())
    return Chosen(winner, ratios, "measured now")


_measured = cache(fastest)


def _memory(name: str, sets: Sequence[FlagSet], compiler: Compiler, macros: str) -> Path:
    """Return the file for this processor, compiler and sets."""
    key = digest(*compiler.command, compiler.version, macros, _processor(), *_FLAGS, repr(sets))
    return cache_folder() / f"flags-{name}-{key[:32]}.json"


@cache
def _processor() -> str:
    """Return the name of the processor: equal instruction sets can differ in speed."""
    try:
        lines = Path("/proc/cpuinfo").read_text("utf-8", "replace").splitlines()
    except OSError:
        return platform.processor()
    return next((line for line in lines if line.startswith("model name")), platform.processor())


def _remembered(memory: Path, sets: Sequence[FlagSet]) -> Chosen | None:
    try:
        kept = json.loads(memory.read_text("utf-8"))
        winner = next(s for s in sets if s.name == kept["winner"])
        ratios = {str(k): float(v) for k, v in kept["ratios"].items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, StopIteration):
        return None  # none yet, or damaged: a race makes it anew
    return Chosen(winner, ratios, "measured before")


def _race(sets: Sequence[FlagSet], compiler: Compiler, contest: Contest) -> dict[str, float]:
    """Compile with every set and race those that compiled; empty where that fails."""
    files, functions = contest
    with tempfile.TemporaryDirectory(prefix="symgen-", ignore_cleanup_errors=True) as folder:
        work = Path(folder)
        sources = unpacked(files, work)

        def compiled(one: FlagSet) -> bool:
            command = [*compiler.command, *_FLAGS, *one.flags, *sources]
            command += ["-o", f"{one.name}.so", "-lm"]
            return _run(command, work) is not None and (work / f"{one.name}.so").is_file()

        with ThreadPoolExecutor(os.cpu_count()) as pool:
            built = [s for s, done in zip(sets, pool.map(compiled, sets), strict=True) if done]
        libraries = {s.name: str(work / f"{s.name}.so") for s in built}
        given = json.dumps({"libraries": libraries, "functions": functions})
        told = _run([sys.executable, "-I", "-S", race.__file__], work, given) if built else None
    try:
        ratios = json.loads(told or "{}")
    except ValueError:
        return {}
    return {str(name): float(ratio) for name, ratio in ratios.items()}


def _run(command: list[str], folder: Path, given: str = "") -> str | None:
    """Return what a command prints, or None where it fails."""
    try:
        return subprocess.run(
            command,
            cwd=folder,
            input=given,
            capture_output=True,
            text=True,
            timeout=_TIMEOUT_SECONDS,
            check=True,
        ).stdout
    except (OSError, subprocess.SubprocessError):
        return None
