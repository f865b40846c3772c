"""Folders written whole or not at all, and the place of the templates."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping
from pathlib import Path

from symgen.errors import PackageError


def write_folder(folder: Path, files: Mapping[str, bytes], marker: str) -> None:
    """Write a folder of files in one step; an older one of the same kind is replaced.

    Args:
        folder: where; its parents are made.
        files: relative path and content of each file.
        marker: the file that tells that an existing folder is one of ours and may be replaced.

    Raises:
        PackageError: the folder holds something else, or cannot be written.
    """
    check_replaceable(folder, marker)
    parent = folder.absolute().parent
    try:
        parent.mkdir(parents=True, exist_ok=True)
        fresh = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=parent))
    except OSError as error:
        raise PackageError(f"{folder}: cannot be written: {error.strerror}") from error
    try:
        for name, content in files.items():
            path = fresh / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        fresh.chmod(0o777 & ~_umask())
        if folder.exists():
            old = Path(tempfile.mkdtemp(prefix=f".{folder.name}-old-", dir=parent))
            folder.rename(old / folder.name)
            fresh.rename(folder)
            shutil.rmtree(old, ignore_errors=True)
        else:
            fresh.rename(folder)
    except OSError as error:
        raise PackageError(f"{folder}: cannot be written: {error.strerror}") from error
    finally:
        shutil.rmtree(fresh, ignore_errors=True)


def check_replaceable(folder: Path, marker: str) -> None:
    """Raise PackageError where `folder` holds something that symgen did not write."""
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise PackageError(f"{folder}: exists and is not a folder")
    if folder.is_dir() and any(folder.iterdir()) and not (folder / marker).is_file():
        raise PackageError(
            f"{folder}: exists and is not ours (no {marker} in it); "
            "accepted: a new or empty folder, or one that symgen wrote"
        )


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def templates() -> Path:
    """Return the folder of the templates: inside an installed package, beside it in a checkout."""
    here = Path(__file__).resolve().parent
    for place in (here / "templates", here.parent / "templates"):
        if place.is_dir():
            return place
    raise PackageError("symgen's templates are missing: install it again")
