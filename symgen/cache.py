"""The private cache folder of derived and compiled models.

A key, the digest of the sources, names a module, or the folder of a robot's derivations. The name
of each file ends in the SHA-256 of its content. symgen loads no file whose content does not match
its name, and makes it again. symgen runs modules from this folder. The folder is therefore private
(0700), and symgen refuses one that another user owns or may write. A file gets its name only when
it is complete. If two processes write the same file at once, the second one replaces the first; if
their contents differ, both files stay.
"""

from __future__ import annotations

import hashlib
import os
import stat
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

from symgen.errors import BuildError

_OTHERS_WRITE = stat.S_IWGRP | stat.S_IWOTH


def digest(*parts: str | bytes) -> str:
    """Return the SHA-256 of some texts, each with its length, in hexadecimal."""
    sha = hashlib.sha256()
    for part in parts:
        content = os.fsencode(part)
        sha.update(f"{len(content)}:".encode())
        sha.update(content)
    return sha.hexdigest()


def name_in_cache(key: str, content: bytes, suffix: str) -> str:
    """Return the name of a file: its key, the SHA-256 of its content, and its suffix."""
    return f"{key}-{hashlib.sha256(content).hexdigest()}{suffix}"


def unchanged(folder: Path, key: str, suffix: str) -> Path | None:
    """Return the file with a key whose content matches its name, or None.

    Files with this key whose content does not match are removed.
    """
    with suppress(OSError):  # another process removed a file, for example
        for path in folder.glob(f"{key}-*"):
            if path.name == name_in_cache(key, path.read_bytes(), suffix):
                return path
            path.unlink()
    return None


def cache_folder() -> Path:
    """Return the folder: SYMGEN_CACHE, or a folder in the user's cache folder."""
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
    except RuntimeError:  # a user without a home folder
        return _spare()
    return base / "symgen"


def _spare() -> Path:
    """Return a folder for this user in the temporary folder."""
    user = os.environ.get("USER") or os.environ.get("USERNAME") or "user"
    return Path(tempfile.gettempdir()) / f"symgen-{user}"


def private_folder() -> Path:
    """Create and return the folder; if it is not writable, one in the temporary folder.

    Raises:
        BuildError: there is no folder, or it is a link, or another user owns it or may write it.
            Modules from the folder run with the rights of this user.
    """
    folder = cache_folder()
    try:
        _make_private(folder)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError:
        spare = _spare()
        try:
            _make_private(spare)
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


def _make_private(folder: Path) -> None:
    """Create a folder and its missing parents, each for this user alone."""
    for parent in reversed(folder.parents):
        if not parent.exists():
            parent.mkdir(mode=0o700, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)


def _foreign(status: os.stat_result) -> str:
    """Return why other users can change a folder; "" if they cannot."""
    if not hasattr(os, "getuid"):  # Windows protects the folders of a user by default
        return ""
    if status.st_uid != os.getuid():
        return "belongs to another user"
    return "may be written by others" if status.st_mode & _OTHERS_WRITE else ""
