"""Rows of an NPZ whose arrays are stored as they are (numpy.savez): read without the rest."""

from __future__ import annotations

import struct
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

_HEADER = struct.Struct("<4s22xHH")  # of a file in an archive: its signature, lengths of two names
_SIGNATURE = b"PK\x03\x04"


@dataclass(frozen=True)
class StoredArray:
    """Where an array lies in a file.

    Attributes:
        offset: of its first byte.
        shape: of the whole.
        dtype: of its entries.
    """

    offset: int
    shape: tuple[int, ...]
    dtype: np.dtype[Any]

    def rows(self, path: Path, first: int, last: int) -> NDArray[Any]:
        """Read rows first .. last (exclusive)."""
        size = int(np.prod(self.shape[1:], dtype=int))
        begin = self.offset + first * size * self.dtype.itemsize
        flat = np.fromfile(path, self.dtype, (last - first) * size, offset=begin)
        return flat.reshape(last - first, *self.shape[1:])


def stored_arrays(path: Path) -> Mapping[str, StoredArray] | None:
    """Return where the arrays of an NPZ lie; None where one is packed, or is not in rows."""
    out = {}
    try:
        with zipfile.ZipFile(path) as archive, path.open("rb") as file:
            for entry in archive.infolist():
                if entry.compress_type != zipfile.ZIP_STORED or entry.flag_bits & 1:
                    return None
                file.seek(entry.header_offset)
                signature, name, extra = _HEADER.unpack(file.read(_HEADER.size))
                if signature != _SIGNATURE:
                    return None
                file.seek(name + extra, 1)
                version = npy.read_magic(file)
                read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
                shape, columns_first, dtype = read(file)
                if columns_first or dtype.hasobject or not shape:
                    return None
                key = entry.filename.removesuffix(".npy")
                out[key] = StoredArray(file.tell(), shape, dtype)
    except (OSError, ValueError, zipfile.BadZipFile, struct.error):
        return None  # whoever reads the whole says what is wrong
    return out
