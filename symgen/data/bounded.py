"""A log read in a process of its own, which may take so much memory, time and disk and no more.

Libraries unpack what a bag holds before anybody can look at its size: a chunk of 34 kB to 1 GB, ten
lines of YAML to 10^9 words, a column that SQLite computes. What a process takes has a bound.
"""

from __future__ import annotations

import io
import json
import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from symgen.data.raw import Raw, refuse
from symgen.errors import LogError

#: Bytes of memory, and of a file that is unpacked: at least, and for each byte on the disk. Where a
#: robot rests, ten bytes of a packed bag are a message, which takes 2 kB.
_LEAST, _TIMES = 1 << 30, 200
#: Seconds of computing: at least, and for each byte on the disk.
_SECONDS, _SECONDS_A_BYTE = 20.0, 2e-5
_PATIENCE = 10  # times that by the clock, since a machine may be busy
_PROGRAM = (
    "import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); "
    "from symgen.data import bounded; bounded.answer()"
)


def read_bounded(read: Callable[..., Raw], path: Path, *given: object) -> Raw:
    """Return what a function of a module returns for a path, called in a process of its own.

    The bounds are those of POSIX (of memory, those of Linux): on Windows time alone is bounded.

    Args:
        read: the function.
        path: the file, or the folder.
        given: what it is called with beside the path.

    Raises:
        LogError: as the function does, or the process took more than it may.
    """
    parts = path.rglob("*") if path.is_dir() else (path,)
    size = sum(part.stat().st_size for part in parts if part.is_file())
    memory, seconds = _LEAST + _TIMES * size, round(_SECONDS + _SECONDS_A_BYTE * size)
    # Nothing in it is of the file. What comes back is, and is no pickle.
    question = pickle.dumps([p for p in sys.path if p])
    question += pickle.dumps((read, path, given, memory, seconds))
    with tempfile.TemporaryDirectory(prefix="symgen-", ignore_cleanup_errors=True) as folder:
        # What is unpacked to the disk goes with the folder, even where the process is killed.
        environment = {**os.environ, "TMPDIR": folder, "OPENBLAS_NUM_THREADS": "1"}
        try:
            done = subprocess.run(
                [sys.executable, "-I", "-c", _PROGRAM],
                input=question,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                timeout=_PATIENCE * seconds,
                env=environment,
                check=True,
            )
        except subprocess.SubprocessError:
            what = f"takes more than {memory / 1e9:.3g} GB or {seconds} s to read"
            refuse(what, f"what is worth its {size / 1e6:.3g} MB on the disk")
    with np.load(io.BytesIO(done.stdout), allow_pickle=False) as found:
        told = json.loads(found["told"].tobytes())
        if isinstance(told, str):
            raise LogError(told)
        arrays = {name: found[name] for name in found if name != "told"}
    return Raw(arrays, *map(tuple, told))


def answer() -> None:
    """Read the question on standard input, call the function, and write what it returns."""
    read, path, given, memory, seconds = pickle.load(sys.stdin.buffer)
    _bound(memory, seconds)
    arrays: Mapping[str, Any] = {}
    try:
        raw = read(path, *given)
        told: Any = [raw.ignored, raw.notes]
        arrays = raw.arrays
    except LogError as error:
        told = str(error)
    file = io.BytesIO()
    np.savez(file, told=np.frombuffer(json.dumps(told).encode(), dtype=np.uint8), **arrays)
    sys.stdout.buffer.write(file.getvalue())
    sys.stdout.flush()


def _bound(memory: int, seconds: int) -> None:
    """Take no more than so many bytes and seconds from now on."""
    try:
        import resource
    except ImportError:  # Windows
        return
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (memory, memory))
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    if sys.platform == "linux":
        held = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (held + memory, held + memory))
