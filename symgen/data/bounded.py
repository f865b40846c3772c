"""Read a log in a separate process with limits on memory, time and disk.

Libraries unpack a bag before its size is known: a chunk of 34 kB can become 1 GB, ten lines of YAML
10^9 words, and SQLite can compute a column. Limits on a process stop all of these.
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

#: Limit on memory and unpacked files, bytes: minimum, and for each byte on the disk. In a bag of a
#: robot at rest, ten bytes can be a message that takes 2 kB, and 0.2 ms to read.
_LEAST, _TIMES = 1 << 30, 200
#: Limit on processor time, s: minimum, and for each byte on the disk.
_SECONDS, _SECONDS_A_BYTE = 20.0, 2e-5
_PATIENCE = 10  # elapsed time over processor time, on a busy machine
_PROGRAM = (
    "import pickle, sys; sys.path[:] = pickle.load(sys.stdin.buffer); "
    "from symgen.data import bounded; bounded.answer()"
)


def read_bounded(read: Callable[..., Raw], path: Path, *given: object) -> Raw:
    """Call a function of a module for a path in a separate process, and return its result.

    Memory is limited on Linux, processor time and files on POSIX. On Windows only the elapsed time
    is limited.

    Args:
        read: the function.
        path: the file or folder.
        given: further arguments.

    Raises:
        LogError: the function raised it, or the process exceeded a limit.
    """
    parts = path.rglob("*") if path.is_dir() else (path,)
    size = sum(part.stat().st_size for part in parts if part.is_file())
    memory, seconds = _LEAST + _TIMES * size, round(_SECONDS + _SECONDS_A_BYTE * size)
    # The question has no content of the file. The answer has, so it is not a pickle.
    question = pickle.dumps([p for p in sys.path if p])
    question += pickle.dumps((read, path, given, memory, seconds))
    with tempfile.TemporaryDirectory(prefix="symgen-", ignore_cleanup_errors=True) as folder:
        # Removing the folder removes all unpacked files, even if the process is killed.
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
    ignored, notes = map(tuple, told)
    return Raw(arrays, ignored, notes)


def answer() -> None:
    """Read the question on standard input, call the function, and write its result."""
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
    """Limit memory and processor time of this process from now on."""
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
