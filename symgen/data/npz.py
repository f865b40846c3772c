"""Logs as NPZ: arrays that are stored as they are (numpy.savez) are read by rows, others whole."""

from __future__ import annotations

import math
import struct
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from symgen.data.raw import (
    BESIDE,
    KEYS,
    ROLES,
    Arrays,
    Wanted,
    listed,
    one_line,
    refuse,
    refuse_currents,
    require_shapes,
    require_size,
)
from symgen.errors import LogError

_HEADER = struct.Struct("<4s22xHH")  # of a file in an archive: its signature, lengths of two names
_SIGNATURE = b"PK\x03\x04"
_BLOCK = 1 << 20  # bytes that are read at once for a checksum


@dataclass(frozen=True)
class StoredArray:
    """An array that lies in a file, row after row.

    Attributes:
        path: the file.
        offset: of its first byte.
        shape, dtype: of the whole.
    """

    path: Path
    offset: int
    shape: tuple[int, ...]
    dtype: np.dtype[Any]

    def __getitem__(self, rows: slice) -> NDArray[Any]:
        """Read some rows."""
        first, last, _ = rows.indices(self.shape[0])
        size = math.prod(self.shape[1:])
        begin = self.offset + first * size * self.dtype.itemsize
        flat = np.fromfile(self.path, self.dtype, (last - first) * size, offset=begin)
        return flat.reshape(last - first, *self.shape[1:])


def open_npz(path: Path, wanted: Wanted, sound: bool = False) -> Arrays:
    """Open what numpy.savez wrote.

    Args:
        path: the file.
        wanted: what is read of it; columns are names in the file of our arrays.
        sound: whether its checksums were found right before.

    Raises:
        LogError: the file does not hold the arrays of a log.
    """
    if not zipfile.is_zipfile(path):
        refuse(path, "is not an NPZ archive", f"what numpy.savez writes, with {KEYS}")
    columns, poses = wanted.columns, wanted.poses
    left_out = {"t" if poses else "", "" if wanted.currents else "i"}
    left_out |= set(() if wanted.beside else BESIDE)
    roles = [role for role in ROLES if role not in left_out]
    for ours, theirs in columns.items():
        if ours not in ROLES:
            refuse(path, f"--columns {ours}={theirs}: an NPZ has one array for all joints", KEYS)
    names = {role: columns.get(role, role) for role in roles}
    try:
        # allow_pickle stays off: a pickle in a log would run code of whoever wrote it. The file is
        # opened here because numpy leaves it open when the archive is damaged.
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            require_size(path, sum(entry.file_size for entry in archive.zip.infolist()))
            keys = list(archive.files)
            arrays: dict[str, Any] = {}
            for role, key in names.items():
                if key in keys:
                    stored = _stored(path, file, archive.zip, key, sound)
                    arrays[role] = np.asarray(archive[key]) if stored is None else stored
    except LogError:
        raise
    except Exception as error:  # a damaged archive raises one of a dozen kinds
        what = "an array holds Python objects" if "Object arrays" in str(error) else str(error)
        raise LogError(one_line(f"{path}: cannot be read: {what}; accepted: {KEYS}")) from error
    for ours, theirs in columns.items():
        if theirs not in keys:
            refuse(path, f"there is no array {theirs!r} (--columns {ours})", listed(keys))
    if "tau" not in arrays and "i" not in arrays and "i" in keys:
        refuse_currents(path)
    if poses and "q" in arrays:
        arrays["t"] = np.arange((*arrays["q"].shape, 1)[0])
    for role in ("t", "q", "tau"):
        if role not in arrays and not (role == "tau" and "i" in arrays):
            refuse(path, f"there is no array {names[role]} among {listed(keys)}", KEYS)
    require_shapes(path, arrays)
    used = {names[role] for role in arrays if role in names}
    return Arrays(arrays, tuple(key for key in keys if key not in used))


def _stored(
    path: Path, file: BinaryIO, archive: zipfile.ZipFile, key: str, sound: bool
) -> StoredArray | None:
    """Return where an array lies; None where it is packed, not in rows, or not what it says."""
    entry = archive.getinfo(key if key in archive.namelist() else f"{key}.npy")
    found = _place(path, file, entry)
    if found is not None and not sound:
        with archive.open(entry) as stored:  # raises where the checksum is wrong
            while stored.read(_BLOCK):
                pass
    return found


def _place(path: Path, file: BinaryIO, entry: zipfile.ZipInfo) -> StoredArray | None:
    if entry.compress_type != zipfile.ZIP_STORED or entry.flag_bits & 1:
        return None
    try:
        file.seek(entry.header_offset)
        signature, name, extra = _HEADER.unpack(file.read(_HEADER.size))
        begin = entry.header_offset + _HEADER.size + name + extra
        file.seek(begin)
        version = npy.read_magic(file)
        read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, columns_first, dtype = read(file)
    except (OSError, ValueError, struct.error):
        return None
    size = file.tell() - begin + dtype.itemsize * math.prod(shape)
    by_rows = bool(shape) and min(shape) >= 0 and not columns_first and not dtype.hasobject
    if signature != _SIGNATURE or not by_rows or size != entry.file_size or not dtype.itemsize:
        return None
    return StoredArray(path, file.tell(), shape, dtype)


def rows_of_npz(path: Path) -> int:
    """Return the rows of an NPZ; 0 where an array is packed, or it cannot be read."""
    try:
        with path.open("rb") as file, zipfile.ZipFile(file) as archive:
            places = [_place(path, file, entry) for entry in archive.infolist()]
    except (OSError, ValueError, zipfile.BadZipFile):
        return 0
    return max((p.shape[0] if p is not None else 0 for p in places), default=0)
