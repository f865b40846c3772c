"""The curves of an estimate's figures, as one NPZ file."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from symgen.data.raw import require_size
from symgen.errors import ParameterError
from symgen.estimation.values import Balance, Convergence, Trace
from symgen.schemas import as_json, from_json

FILE = "curves.npz"
_KINDS: dict[str, type[Trace | Balance]] = {"trace": Trace, "balance": Balance}


def curves_npz(curves: Mapping[str, tuple[Any, ...]], course: Convergence | None) -> bytes:
    """Return the traces, balances and convergence of an estimate as the bytes of an NPZ file.

    Curves are in single precision, times in double. `index`, a JSON text in bytes, names them:
    "traces" and "balances" in order, whose arrays are `trace0_t`, `trace0_measured`, ...,
    `balance0_work`, ...; and `convergence_t`, `convergence_values` where there is one.
    """
    index = json.dumps(as_json(curves))
    arrays: dict[str, Any] = {"index": np.frombuffer(index.encode(), dtype=np.uint8)}
    for kind in _KINDS:
        for k, value in enumerate(curves[f"{kind}s"]):
            for key, array in vars(value).items():
                if isinstance(array, np.ndarray):
                    kept = array if key == "t" else array.astype(np.float32)
                    arrays[f"{kind}{k}_{key}"] = kept
    if course is not None:
        arrays |= {f"convergence_{key}": array for key, array in vars(course).items()}
    file = io.BytesIO()
    np.savez_compressed(file, allow_pickle=False, **arrays)
    return file.getvalue()


def read_curves(path: Path, parameters: int) -> dict[str, Any]:
    """Read a file of `curves_npz`; a missing file has no curves.

    Args:
        path: the NPZ file.
        parameters: number of parameters that the estimate has.

    Returns:
        The fields traces, balances and convergence of an estimate, as far as the file has them.

    Raises:
        ParameterError: the file is damaged.
    """
    if not path.exists():
        return {}
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            require_size(path, sum(entry.file_size for entry in file.zip.infolist()))
            index = json.loads(file["index"].tobytes())
            found: dict[str, Any] = {
                f"{kind}s": tuple(
                    from_json(made, entry, path, **_arrays(file, f"{kind}{k}", made, entry))
                    for k, entry in enumerate(index[f"{kind}s"])
                )
                for kind, made in _KINDS.items()
            }
            if "convergence_t" in file:
                found["convergence"] = Convergence(**_arrays(file, "convergence", Convergence, ()))
    except Exception as error:  # a damaged archive raises one of two dozen kinds
        raise ParameterError(
            f"{path}: damaged ({type(error).__name__}); accepted: the file that identify wrote, or "
            "none (figures over time are left out then)"
        ) from error
    course = found.get("convergence")
    if course is not None and course.values.shape != (len(course.t), parameters):
        raise ParameterError(f"{path}: it belongs to another estimate than the one beside it")
    return found


def _arrays(file: Any, start: str, kind: Any, told: Any) -> dict[str, Any]:
    """Return the arrays of a curve, as many rows as t of finite numbers in each.

    Raises:
        ValueError: they are others.
    """
    places = ((f.name, f"{start}_{f.name}") for f in fields(kind) if f.name not in told)
    found = {key: np.asarray(file[at], dtype=float) for key, at in places if at in file}
    rows, columns = found["t"].shape, {x.shape[1:] for key, x in found.items() if key != "t"}
    if any(x.shape[:1] != rows or not np.isfinite(x).all() for x in found.values()):
        raise ValueError("rows")
    if [len(shape) for shape in columns] != [0 if kind is Balance else 1]:
        raise ValueError("columns")
    return found
