"""Which files of a folder symgen wrote, and what becomes of the others.

The record is the SHA-256 of each file of symgen: a file in the folder, as `sha256sum` writes it.
The manifest of a package and the JSON of a diagnosis list these digests themselves, and are the
record of their folder. Only a file that stands in the record, and still has that digest, is
replaced or removed. Everything else was put there, or changed, by somebody. It goes over into the
folder that replaces this one; a file whose name symgen needs gets another name.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import shutil
import stat
from collections.abc import Mapping
from pathlib import Path

RECORD = ".symgen.sha256"
#: They list the digests of the files beside them, robot.toml among these.
_LISTING = ("manifest.json", "diagnosis.json")


def with_record(files: Mapping[str, bytes], marker: str) -> dict[str, bytes]:
    """Return the files of a folder with its record, where its marker is none itself."""
    if marker in _LISTING:
        return dict(files)
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    lines = [f"{digest}  {name}\n" for name, digest in sorted(digests.items())]
    return {**files, RECORD: "".join(lines).encode()}


def read_record(folder: Path, marker: str) -> dict[str, str] | None:
    """Return the digests of the files that symgen wrote into a folder, None without a record.

    Args:
        folder: of files.
        marker: name of the JSON that tells what kind of folder it is.

    Raises:
        OSError: it cannot be read.
    """
    path = folder / RECORD
    if path.is_file() and not path.is_symlink():
        lines = path.read_text("utf-8", errors="replace").split("\n")
        return {name: digest for digest, gap, name in (x.partition("  ") for x in lines) if gap}
    listing = marker in _LISTING and (folder / marker).is_file()
    record, unlisted = _listed((folder / marker).read_bytes()) if listing else ({}, [])
    if "robot.toml" not in record:
        return None
    present = [name for name in (marker, *unlisted) if (folder / name).is_file()]
    return record | {name: _sha256(folder / name) for name in present}


def _listed(marker: bytes) -> tuple[dict[str, str], list[str]]:
    """Return the digests that a JSON lists, and names of files of symgen without a digest.

    Packages had a file NAME_KERNEL.casadi of each kernel before they had NAME_casadi.py; its bytes
    differed from machine to machine.
    """
    try:
        content = json.loads(marker)
        digests = {str(name): str(digest) for name, digest in content["digests"].items()}
    except (ValueError, RecursionError, LookupError, TypeError, AttributeError):
        return {}, []
    try:
        prefix, kernels = content["options"]["prefix"], content["options"]["kernels"]
        old = content["options"]["target"] in ("all", "casadi")
        names = [f"{prefix}_{kernel}.casadi" for kernel in kernels]
    except (LookupError, TypeError):
        return digests, []
    plain = all("/" not in name and "\\" not in name for name in names)
    return digests, names if old and plain and f"{prefix}_casadi.py" not in digests else []


class Carried:
    """What was brought from an older folder into the one that replaces it.

    Attributes:
        renamed: paths of files that have another name now, and that name.
    """

    def __init__(self, marker: str) -> None:
        """Begin with nothing; the marker is the JSON that tells what kind of folder it is."""
        self._marker = marker
        self.renamed: dict[str, str] = {}
        self._brought: set[tuple[str, int, int]] = set()

    def over(self, old: Path, new: Path) -> None:
        """Bring all that symgen did not write, and that was not brought before.

        A file gets a second place on the disk (a hard link): it is not copied, and who has it open
        goes on writing to it. A link stays one: what it leads to does not come into the folder.

        Raises:
            OSError: something cannot be brought.
        """
        self._inside(old, new, read_record(old, self._marker) or {}, "")

    def _inside(self, old: Path, new: Path, record: Mapping[str, str], inside: str) -> None:
        for path in sorted((old / inside).iterdir()):
            name, found = f"{inside}{path.name}", path.lstat()
            folder, file = stat.S_ISDIR(found.st_mode), stat.S_ISREG(found.st_mode)
            known = (name, found.st_dev, found.st_ino)
            ours = file and name in record and record[name] == _sha256(path)
            if ours or name == RECORD or known in self._brought:
                continue
            target, present = new / name, os.path.lexists(new / name)
            if folder and (not present or stat.S_ISDIR(target.lstat().st_mode)):
                if not any(path.iterdir()):
                    target.mkdir(parents=True, exist_ok=True)
                self._inside(old, new, record, f"{name}/")
                if not present and target.is_dir():
                    shutil.copystat(path, target)
                continue
            if present and not folder and os.path.samestat(found, target.lstat()):
                continue
            if present:
                target = _free(path, target)
                self.renamed[name] = target.name
            target.parent.mkdir(parents=True, exist_ok=True)
            _bring(path, target)
            self._brought.add(known)


def _free(path: Path, target: Path) -> Path:
    """Return a name for a file that nothing has, neither where it was nor where it goes."""
    for k in itertools.count(1):
        name = f"{path.name}.kept" + (f"-{k}" if k > 1 else "")
        if not any(os.path.lexists(place.with_name(name)) for place in (path, target)):
            break
    return target.with_name(name)


def _bring(path: Path, target: Path) -> None:
    if path.is_symlink():
        shutil.copy2(path, target, follow_symlinks=False)
    elif path.is_dir():
        shutil.copytree(path, target, symlinks=True)
    else:
        try:
            os.link(path, target)
        except OSError:  # a disk without hard links
            shutil.copy2(path, target)


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
