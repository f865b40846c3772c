"""Temporary folders, each beside what is written, and the locks that tell whose they are.

What symgen writes is first made in a temporary folder, `.symgen-part-*`, in the same parent folder,
and then moved to its place. The process that makes such a folder locks it. The system releases the
lock when the process ends, however it ends: a number of a process, which another one may get later,
plays no part. So a temporary folder without a lock was left by a kill, and nothing in it is needed:
whatever is moved into one has been replaced. The next run that writes there removes it.

Where there are no locks (some network disks), leftovers stay. Windows has no such locks, but does
not remove a file that is open: there an open file in the folder tells that its owner lives.
"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

_PREFIX = ".symgen-part-"
_WAIT, _ASKED = 60.0, 0.01  # s
_OPEN = "open"  # the file that tells on Windows
_HERE, _EXCHANGE, _SWAP = -100, 2, 2  # AT_FDCWD, RENAME_EXCHANGE (Linux), RENAME_SWAP (macOS)


@contextmanager
def place(folder: Path) -> Iterator[Path]:
    """Make a temporary folder in `folder`, lock it, yield it, and remove it in the end.

    Raises:
        OSError: no folder can be made there.
    """
    while True:
        own = Path(tempfile.mkdtemp(prefix=_PREFIX, dir=folder))
        lock, others = locked(own)
        if not others:  # else a sweep came in between: it removes this one
            break
    if fcntl is None:
        lock = os.open(own / _OPEN, os.O_CREAT | os.O_WRONLY)
    try:
        yield own
    finally:
        if fcntl is None and lock is not None:
            os.close(lock)
        shutil.rmtree(own, ignore_errors=True)
        if fcntl is not None and lock is not None:
            os.close(lock)


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Wait until no other process of symgen moves anything in `folder`, and keep it so.

    Where there are no locks, or another one takes unusually long, this goes on beside it.
    """
    lock, until = None, time.monotonic() + _WAIT
    with suppress(OSError):
        while time.monotonic() < until:
            lock, others = locked(folder.resolve())
            if not others:
                break
            time.sleep(_ASKED)
    try:
        yield
    finally:
        if lock is not None:
            os.close(lock)


def sweep(folder: Path) -> None:
    """Remove the temporary folders that killed runs left in `folder`."""
    for left in folder.glob(f"{_PREFIX}*"):
        lock = None
        try:
            if fcntl is None:
                (left / _OPEN).unlink()
            elif left.is_symlink() or (lock := locked(left)[0]) is None:
                continue
            shutil.rmtree(left, ignore_errors=True)
        except OSError:  # of a living process
            continue
        finally:
            if lock is not None:
                os.close(lock)


def written(path: Path, content: bytes, mode: int = 0o666) -> None:
    """Write a file whole or not at all, in place of what is there.

    Args:
        path: of the file.
        content: of it.
        mode: its permissions, less those that the user's umask takes away.

    Raises:
        OSError: it cannot be written.
    """
    with place(path.parent) as own:
        fresh = own / path.name
        fresh.touch(mode)
        fresh.write_bytes(content)
        os.replace(fresh, path)


def locked(place: Path) -> tuple[int | None, bool]:
    """Return the descriptor of a folder that is now locked, or None and whether others hold it."""
    if fcntl is None:
        return None, False
    try:
        lock = os.open(place, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    except FileNotFoundError:  # just removed: who held it has ended
        return None, True
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if os.path.samestat(os.fstat(lock), os.lstat(place)):
            return lock, False
    except (BlockingIOError, FileNotFoundError):
        pass
    except OSError:  # a disk without locks
        os.close(lock)
        return None, False
    os.close(lock)
    return None, True


def exchanged(one: Path, other: Path) -> bool:
    """Exchange two folders in one step; return whether that was possible.

    Linux and macOS can, on most disks.
    """
    import ctypes

    a, b = os.fsencode(one), os.fsencode(other)
    with suppress(AttributeError, OSError, TypeError):  # no such call in this system's library
        library = ctypes.CDLL(None)
        if sys.platform == "darwin":
            return bool(library.renamex_np(a, b, _SWAP) == 0)
        return bool(library.renameat2(_HERE, a, _HERE, b, _EXCHANGE) == 0)
    return False
