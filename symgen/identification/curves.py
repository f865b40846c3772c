"""What an estimate's figures are drawn from, as one NPZ file: curves over time."""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.data.raw import require_size
from symgen.errors import ParameterError
from symgen.estimation.values import Balance, Convergence, Trace
from symgen.identification.estimate import Estimate

FloatArray = NDArray[np.float64]
FILE = "curves.npz"
_TRACE = ("t", "measured", "predicted")
_BALANCE = ("t", "work", "energy", "friction")


def curves_npz(estimate: Estimate) -> bytes:
    """Return the traces, balances and convergence of an estimate as the bytes of an NPZ file.

    Curves are in single precision, times in double. `index`, a JSON text in bytes, names them:
    "traces" and "balances" in order, whose arrays are `trace0_t`, `trace0_measured`, ...,
    `balance0_work`, ...; and `convergence_t`, `convergence_values` where there is one.
    """
    traces = [
        {"log": x.log, "kind": x.kind, "quantity": x.quantity, "spacing": x.spacing}
        for x in estimate.traces
    ]
    balances = [{"log": x.log, "kind": x.kind} for x in estimate.balances]
    index = json.dumps({"traces": traces, "balances": balances})
    arrays: dict[str, Any] = {"index": np.frombuffer(index.encode(), dtype=np.uint8)}
    for kind, values, keys in (
        ("trace", estimate.traces, _TRACE),
        ("balance", estimate.balances, _BALANCE),
    ):
        for k, value in enumerate(values):
            for key in keys:
                array = getattr(value, key)
                arrays[f"{kind}{k}_{key}"] = array if key == "t" else array.astype(np.float32)
    if estimate.convergence is not None:
        arrays["convergence_t"] = estimate.convergence.t
        arrays["convergence_values"] = estimate.convergence.values
    file = io.BytesIO()
    np.savez_compressed(file, allow_pickle=False, **arrays)
    return file.getvalue()


def read_curves(
    path: Path, parameters: int
) -> tuple[tuple[Trace, ...], tuple[Balance, ...], Convergence | None]:
    """Read what `curves_npz` wrote; a file that is absent holds nothing.

    Args:
        path: the NPZ file.
        parameters: number of parameters that the estimate has.

    Raises:
        ParameterError: the file is damaged.
    """
    if not path.exists():
        return (), (), None
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            require_size(path, sum(entry.file_size for entry in file.zip.infolist()))
            index = json.loads(file["index"].tobytes())
            traces = []
            for k, entry in enumerate(index["traces"]):
                arrays = _arrays(file, f"trace{k}", _TRACE)
                log, kind, quantity = (str(entry[key]) for key in ("log", "kind", "quantity"))
                t, measured, predicted = arrays
                if measured.ndim != 2 or measured.shape != predicted.shape:
                    raise ValueError("columns")
                apart = max(0, int(entry["spacing"]))
                traces.append(Trace(log, kind, quantity, t, measured, predicted, apart))
            balances = []
            for k, entry in enumerate(index["balances"]):
                arrays = _arrays(file, f"balance{k}", _BALANCE)
                balances.append(Balance(str(entry["log"]), str(entry["kind"]), *arrays))
            course = None
            if "convergence_t" in file:
                course = Convergence(*_arrays(file, "convergence", ("t", "values")))
    except Exception as error:  # a damaged archive raises one of two dozen kinds
        raise ParameterError(
            f"{path}: damaged ({type(error).__name__}); accepted: the file that identify wrote, or "
            "none (figures over time are left out then)"
        ) from error
    if course is not None and course.values.shape != (len(course.t), parameters):
        raise ParameterError(f"{path}: it belongs to another estimate than the one beside it")
    return tuple(traces), tuple(balances), course


def _arrays(file: Any, start: str, keys: tuple[str, ...]) -> list[FloatArray]:
    """Return arrays by their keys, t first; all have as many rows as t, of finite numbers.

    Raises:
        ValueError: they have not.
    """
    found = [np.asarray(file[f"{start}_{key}"], dtype=float) for key in keys]
    if found[0].ndim != 1 or any(len(array) != len(found[0]) for array in found):
        raise ValueError("rows")
    if not all(np.isfinite(array).all() for array in found):
        raise ValueError("numbers")
    return found
