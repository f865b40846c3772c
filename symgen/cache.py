"""The private folder of what was derived and compiled before, each by the digest of its sources.

Modules from it are run, and sources from it are compiled. So the folder is private (0700), and
nothing is taken from one that somebody else owns or may write; what is taken is a file of this
user's, no link, and its name ends in the SHA-256 of its content, so that one rename puts both in
place.
"""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from symgen.errors import BuildError
from symgen.places import written

_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def cache_folder() -> Path:
    """Return the folder: SYMGEN_CACHE, or symgen's in the user's cache folder."""
    chosen = os.environ.get("SYMGEN_CACHE")
    if chosen:
        return Path(chosen)
    try:
        if sys.platform == "win32":
            base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
        elif sys.platform == "darwin":
            base = Path.home() / "Library" / "Caches"
        else:
            base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError:  # a user without a home
        return _spare()
    return base / "symgen"


def _spare() -> Path:
    """Return this user's folder where there is no other."""
    user = os.environ.get("USER") or os.environ.get("USERNAME") or "user"
    return Path(tempfile.gettempdir()) / f"symgen-{user}"


def private_folder() -> Path:
    """Make and return the folder, or where it cannot be written one in the temporary folder.

    Raises:
        BuildError: there is no folder, or it is a link, somebody else's, or one that others may
            write: what is loaded from it runs with the rights of this user.
    """
    folder = cache_folder()
    try:
        make_private(folder)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError:
        spare = _spare()
        try:
            make_private(spare)
        except OSError as error:
            raise BuildError(
                f"{folder}: no folder for compiled models: {error.strerror}"
            ) from error
        folder = spare
    status = folder.lstat()
    fault = "is a link" if stat.S_ISLNK(status.st_mode) else _foreign(status)
    if fault:
        raise BuildError(
            f"{folder}: {fault}; set SYMGEN_CACHE to a folder that is yours and that nobody else "
            "may write (chmod 700)"
        )
    return folder


def make_private(folder: Path) -> None:
    """Make a folder and those above it that are missing, each for this user alone."""
    for parent in reversed(folder.parents):
        if not parent.exists():
            parent.mkdir(mode=0o700, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)


def kept_name(name: str, content: bytes, suffix: str) -> str:
    """Return the file name of a content."""
    return f"{name}-{hashlib.sha256(content).hexdigest()}{suffix}"


def kept_files(folder: Path, name: str, suffix: str) -> Iterator[Path]:
    """Yield the files of a name that are whole and ours; the others are removed."""
    try:
        found = os.listdir(folder)
    except OSError:
        return
    for known in sorted(n for n in found if n.startswith(f"{name}-") and n.endswith(suffix)):
        if _intact(folder / known, suffix):
            yield folder / known
        else:
            with suppress(OSError):
                (folder / known).unlink()


def kept_text(folder: Path, name: str) -> str | None:
    """Return a text that was kept under a name, or None."""
    for known in kept_files(folder, name, ".json"):
        with suppress(OSError, UnicodeDecodeError):
            return known.read_text("utf-8")
    return None


def keep_text(folder: Path, name: str, text: str) -> None:
    """Keep a text under a name, whole or not at all; nothing is kept where that cannot be done."""
    content = text.encode()
    with suppress(OSError):
        make_private(folder)
        written(folder / kept_name(name, content, ".json"), content, 0o600)


def _intact(kept: Path, suffix: str) -> bool:
    """Whether a file is whole and ours."""
    try:
        with os.fdopen(os.open(kept, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0)), "rb") as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode) or _foreign(status):
                return False
            digest = hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return False
    return kept.name.removesuffix(suffix).endswith(f"-{digest}")


def _foreign(status: os.stat_result) -> str:
    """Return why a file or folder is not this user's alone, "" where it is."""
    if not hasattr(os, "getuid"):  # Windows keeps others out of a user's folders by itself
        return ""
    if status.st_uid != os.getuid():
        return "belongs to another user"
    return "may be written by others" if status.st_mode & _OTHERS_WRITE else ""
