"""Evaluate a .casadi file of unknown origin in a process that can only compute.

CasADi loads shared libraries that such a file names, and a damaged file can end the process.
Therefore a separate process reads it. A filter of system calls (seccomp, Linux) denies it files,
programs, network and processes; it can only compute, and answer on its standard output.
"""

from __future__ import annotations

import ctypes
import json
import os
import platform
import struct
import subprocess
import sys
from collections.abc import Sequence
from typing import Any

_TIMEOUT_SECONDS = 120
_MEMORY = 4 << 30  # bytes of address space
_CPU_SECONDS = 60

# Numbers of linux/audit.h, linux/filter.h, linux/seccomp.h and linux/prctl.h.
_NO_NEW_PRIVILEGES, _SET_SECCOMP, _FILTER = 38, 22, 2
_LOAD, _JUMP_IF_EQUAL, _RETURN = 0x20, 0x15, 0x06
_ALLOW, _REFUSE, _KILL = 0x7FFF0000, 0x00050000 | 1, 0x80000000
_NUMBER, _ARCHITECTURE = 0, 4  # where struct seccomp_data has them
#: Machine: its number in the kernel, and of read, write, fstat, lseek, mmap, mprotect, munmap, brk,
#: rt_sigaction, rt_sigprocmask, rt_sigreturn, sched_yield, mremap, madvise, getpid, exit, gettid,
#: futex, clock_gettime, exit_group, getrandom.
_CALLS = {
    "x86_64": (
        0xC000003E,
        (0, 1, 5, 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 28, 39, 60, 186, 202, 228, 231, 318),
    ),
    "aarch64": (
        0xC00000B7,
        (63, 64, 80, 62, 222, 226, 215, 214, 134, 135, 139)
        + (124, 216, 233, 172, 93, 178, 98, 113, 94, 278),
    ),
}


def available() -> bool:
    """Whether this system can confine a process in this way."""
    return sys.platform == "linux" and platform.machine() in _CALLS


def values(
    content: bytes, points: Sequence[Sequence[Sequence[float]]]
) -> tuple[list[list[int]], list[list[float]]] | None:
    """Return the values of a .casadi file at some points, computed in a confined process.

    Args:
        content: content of the file.
        points: for each point the inputs, each as a flat list.

    Returns:
        The sizes (rows, columns) of all inputs and outputs, and for each point all outputs in one
        list, column by column. None if the file holds no function, if evaluating it ends the
        process, or after the time limit.
    """
    question = {"path": [p for p in sys.path if p], "content": content.hex(), "points": points}
    try:
        done = subprocess.run(
            [sys.executable, "-I", __file__],
            input=json.dumps(question).encode(),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=_TIMEOUT_SECONDS,
            check=True,
            # One thread: the filter holds for the thread that asks for it.
            env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        )
        # Not trusted either: whoever took over that process could answer anything.
        sizes, rows = json.loads(done.stdout)
        return [[int(v) for v in size] for size in sizes], [[float(v) for v in row] for row in rows]
    except (OSError, subprocess.SubprocessError, ValueError, TypeError, RecursionError):
        return None


def _confine() -> None:
    """Give up all system calls but those of computing; this cannot be undone."""
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (_CPU_SECONDS, _CPU_SECONDS))
    number, calls = _CALLS[platform.machine()]
    rules = [(_LOAD, 0, 0, _ARCHITECTURE), (_JUMP_IF_EQUAL, 1, 0, number), (_RETURN, 0, 0, _KILL)]
    rules.append((_LOAD, 0, 0, _NUMBER))
    for left, call in enumerate(reversed(calls)):
        rules.insert(4, (_JUMP_IF_EQUAL, left + 1, 0, call))
    rules += [(_RETURN, 0, 0, _REFUSE), (_RETURN, 0, 0, _ALLOW)]
    program = ctypes.create_string_buffer(b"".join(struct.pack("=HBBI", *rule) for rule in rules))

    class Program(ctypes.Structure):
        _fields_ = (("length", ctypes.c_ushort), ("rules", ctypes.c_void_p))

    libc = ctypes.CDLL(None, use_errno=True)
    filter_ = ctypes.byref(Program(len(rules), ctypes.addressof(program)))
    if libc.prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0) or libc.prctl(_SET_SECCOMP, _FILTER, filter_):
        raise OSError(ctypes.get_errno(), "the process cannot be confined")


def _answer() -> None:
    """Read the question on stdin, confine this process, and write the answer to stdout."""
    question = json.loads(sys.stdin.buffer.read())
    sys.path[:] = question["path"]
    import casadi

    _confine()
    function = casadi.StringDeserializer(
        bytes.fromhex(question["content"]).decode("ascii")
    ).unpack()
    answers = (function.call([casadi.DM(v) for v in point]) for point in question["points"])
    rows = [
        [float(v) for out in answer for v in casadi.densify(out).nonzeros()] for answer in answers
    ]
    sys.stdout.write(json.dumps([sizes(function), rows]))
    sys.stdout.flush()
    os._exit(0)


def sizes(function: Any) -> list[list[int]]:
    """Return rows and columns of all inputs, then of all outputs of a CasADi function."""
    return [
        *(list(function.size_in(i)) for i in range(function.n_in())),
        [-1, -1],
        *(list(function.size_out(i)) for i in range(function.n_out())),
    ]


if __name__ == "__main__":
    _answer()
