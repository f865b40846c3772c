"""One process at a time builds a module: the others wait, and find it built.

What is locked (flock) is the folder that is built in. The lock goes with the process that holds it,
however that ends, so that a kill leaves a folder of a killed build and nothing else. Only who holds
the lock removes the folder; who then gets the lock of a folder that is no longer there, or that
another one has replaced, holds nothing and begins anew.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from symgen.places import locked

_ASKED_SECONDS = 0.05
_STALE_SECONDS = 3600


@contextmanager
def turn(folder: Path, name: str, seconds: float) -> Iterator[Path]:
    """Wait until no other process has the turn of a name; yield an empty folder to build in.

    Where there are no locks, or after the time, the turn is taken beside the others: to build twice
    is slow, never wrong.

    Args:
        folder: in which the folder is made, and removed in the end.
        name: of what is built.
        seconds: to wait.

    Raises:
        OSError: no folder can be made there.
    """
    place = folder / f"build-{name}"
    until = time.monotonic() + seconds
    while True:
        try:
            place.mkdir(mode=0o700, exist_ok=True)
        except FileExistsError:  # no folder, or one that has just gone with the turn before
            if place.is_symlink() or (place.exists() and not place.is_dir()):
                raise
            continue
        lock, others = locked(place)
        if lock is not None or not others or time.monotonic() > until:
            break
        time.sleep(_ASKED_SECONDS)
    if lock is None:
        if not others:
            with suppress(OSError):
                place.rmdir()
        place = Path(tempfile.mkdtemp(prefix="build-", dir=folder))
    try:
        # Within: the compiler of a killed process may still be writing into the one before.
        yield Path(tempfile.mkdtemp(dir=place))
    finally:
        shutil.rmtree(place, ignore_errors=True)
        if lock is not None:
            os.close(lock)


def sweep(folder: Path) -> None:
    """Remove what killed builds left behind an hour ago or earlier."""
    for leftover in folder.glob("build-*"):
        try:
            if time.time() - leftover.lstat().st_mtime <= _STALE_SECONDS:
                continue
            if not leftover.is_dir() or leftover.is_symlink():
                leftover.unlink()
                continue
            lock, others = locked(leftover)
            if not others:
                shutil.rmtree(leftover, ignore_errors=True)
            if lock is not None:
                os.close(lock)
        except OSError:
            continue
