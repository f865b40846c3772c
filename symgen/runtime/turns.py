"""Let one process at a time build a module; the others wait and then load it.

The lock (flock) is on the build folder. It ends with the process that holds it, so a killed build
leaves only its folder. Only the holder of the lock removes the folder. A process that then gets the
lock of a folder that is gone or replaced starts again.
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
    """Wait until no other process builds this name, and yield an empty folder to build in.

    Without locks, or after the waiting time, the process builds at the same time as others. Two
    builds are slow, but not wrong.

    Args:
        folder: parent of the build folder, which is removed at the end.
        name: name of the module.
        seconds: longest time to wait.

    Raises:
        OSError: the folder cannot be made.
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
    """Remove folders of killed builds that are at least an hour old."""
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
