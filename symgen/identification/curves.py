"""The curves of a result's figures, as one NPZ file."""

from __future__ import annotations

import io
import json
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from symgen.data.raw import FloatArray, require_size
from symgen.errors import ParameterError
from symgen.estimation.values import Trace
from symgen.schemas import as_json, from_json

FILE = "curves.npz"
#: Largest number in single precision; shortest step of a log, s.
_LARGEST, _SHORTEST = float(np.finfo(np.float32).max), 1e-9


def traces_npz(traces: tuple[Trace, ...]) -> bytes:
    """Return traces as the bytes of an NPZ file.

    Curves are in single precision, times in double. `index`, a JSON text in bytes, lists the
    traces in order. The arrays of the traces are `trace0_t`, `trace0_measured`, ...
    """
    index = json.dumps({"traces": as_json(traces)})
    arrays: dict[str, Any] = {"index": np.frombuffer(index.encode(), dtype=np.uint8)}
    for k, trace in enumerate(traces):
        for key, array in vars(trace).items():
            if isinstance(array, np.ndarray):
                arrays[f"trace{k}_{key}"] = array if key == "t" else array.astype(np.float32)
    file = io.BytesIO()
    np.savez_compressed(file, allow_pickle=False, **arrays)
    return file.getvalue()


def read_traces(path: Path, joints: int = 0) -> tuple[Trace, ...]:
    """Read traces from a file of `traces_npz`; none if the file is missing.

    Args:
        path: path of the file.
        joints: number of joints; 0 if it is unknown.

    Raises:
        ParameterError: the file is damaged.
    """
    if not path.exists():
        return ()
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            require_size(path, sum(entry.file_size for entry in file.zip.infolist()))
            index = json.loads(file["index"].tobytes())
            return tuple(
                from_json(Trace, entry, path, **_arrays(file, f"trace{k}", entry, joints))
                for k, entry in enumerate(index["traces"])
            )
    except Exception as error:  # a damaged archive raises one of many kinds
        raise ParameterError(
            f"{path}: damaged ({type(error).__name__}); accepted: the file that identify wrote, or "
            "none (figures over time are left out then)"
        ) from error


def _arrays(file: Any, start: str, entry: Any, joints: int) -> dict[str, Any]:
    """Return the arrays of a trace: numbers in single precision, one row for each entry of t.

    Raises:
        ValueError: an array has another shape, or a number or time that no log has.
    """
    places = ((f.name, f"{start}_{f.name}") for f in fields(Trace) if f.name not in entry)
    arrays = {key: np.asarray(file[at], dtype=float) for key, at in places if at in file}
    rows = arrays["t"].shape
    columns = {x.shape[1:] for key, x in arrays.items() if key != "t"}
    if any(x.shape[:1] != rows or not (abs(x) < _LARGEST).all() for x in arrays.values()):
        raise ValueError("rows")
    require_times(arrays["t"])
    ((count,),) = columns
    if joints and count != (1 if entry["quantity"] == "energy" else joints):
        raise ValueError("columns")
    return arrays


def require_times(t: FloatArray) -> None:
    """Raise ValueError unless there are times (K,) in s, which increase by steps of a log."""
    if not t.size or not (np.diff(t) > _SHORTEST).all():
        raise ValueError("times")
