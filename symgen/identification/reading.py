"""An estimate from the folder that identify wrote."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from symgen.errors import ParameterError
from symgen.estimation.band import Band, Rests
from symgen.estimation.repairs import Repair
from symgen.estimation.values import Contrast, Endogeneity, Residual, Whiteness
from symgen.files import load_json
from symgen.identification.curves import FILE, read_curves
from symgen.identification.estimate import (
    READ,
    SCHEMA,
    Alternative,
    Consistency,
    Estimate,
    ParameterEstimate,
    Use,
)

MARKER = "estimate.json"
_PER_JOINT = ("torque", "momentum")  # residuals of one component a joint


def read_estimate(path: str | Path) -> Estimate:
    """Read an estimate again.

    Args:
        path: the folder that `identify` wrote, or the estimate.json in it. The curves for figures
            come from curves.npz beside it; without that file there are none. What an older
            estimate.json does not hold is empty.

    Raises:
        ParameterError: there is no estimate, or it is damaged.
    """
    path = Path(path)
    file = path / MARKER if path.is_dir() else path
    content = read_json(file, *READ)
    try:
        estimate = _estimate(content)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        raise ParameterError(
            f"{file}: damaged ({type(error).__name__}: {' '.join(str(error).split())[:100]}); "
            f"accepted: schema {SCHEMA} as identify writes it"
        ) from error
    traces, balances, course = read_curves(file.with_name(FILE), len(estimate.parameters))
    return Estimate(
        **{**vars(estimate), "traces": traces, "balances": balances, "convergence": course}
    )


def read_json(file: Path, *schemas: str) -> dict[str, Any]:
    """Return the content of a JSON file of one of some schemas.

    Raises:
        ParameterError: it cannot be read, or is of another kind.
    """
    try:
        content = load_json(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or " ".join(str(error).split())[:100]
        raise ParameterError(
            f"{file}: cannot be read ({reason}); accepted: schema {schemas[0]}"
        ) from error
    found = content.get("schema") if isinstance(content, dict) else None
    if found not in schemas:
        accepted = " or ".join(schemas)
        raise ParameterError(f"{file}: its schema is {found!r}; accepted: {accepted}")
    return dict(content)


def _estimate(content: dict[str, Any]) -> Estimate:
    parameters = tuple(
        ParameterEstimate(
            str(p["name"]),
            str(p["expression"]),
            number(p["value"]),
            or_nan(p["std"]),
            str(p["unit"]),
        )
        for p in content["parameters"]
    )
    if len({p.name for p in parameters}) < len(parameters) or not parameters:
        raise ValueError("parameters are missing, or there twice")
    names = [p.name for p in parameters]
    train, validation = _residuals(content["residual"])
    torque = content.get("torque_residual")
    torque_train, torque_validation = (None, None) if torque is None else _residuals(torque)
    correlation = np.array(
        [[or_nan(x) for x in row] for row in content.get("correlation", ())], dtype=float
    )
    if correlation.size and correlation.shape != (len(names), len(names)):
        raise ValueError("correlation has another size")
    known = (torque_validation and torque_validation.per_joint) or ()
    joints = tuple((int(j["number"]), str(j["unit"])) for j in content.get("joints", ()))
    tested = tuple(map(_whiteness, content.get("whiteness", ())))
    if any(not 0 <= w.component < _components(w.quantity, len(joints)) for w in tested):
        raise ValueError("whiteness of a joint that is not there")
    physical = content.get("physical", {})
    prior = content.get("prior")
    return Estimate(
        robot=str(content["robot"]),
        joints=joints or tuple((j, "N m or N") for j in range(1, len(known) + 1)),
        model=str(content["model"]),
        method=str(content["method"]),
        parameters=parameters,
        condition_number=number(content["condition_number"]),
        train=train,
        validation=validation,
        torque_train=torque_train,
        torque_validation=torque_validation,
        cutoff_hz=_number_or_none(content["cutoff_hz"]),
        window_s=_number_or_none(content["window_s"]),
        verdict=str(content["verdict"]),
        reasons=tuple(map(str, content["reasons"])),
        notes=tuple(map(str, content.get("notes", ()))),
        correlation=correlation if correlation.size else np.empty((0, 0)),
        provenance=tuple((str(k), str(v)) for k, v in content.get("provenance", {}).items()),
        physical=Consistency(
            physical.get("feasible"),
            _number_or_none(physical.get("distance_sigma")),
            str(physical.get("reason", "not checked")),
        ),
        excludes=str(content.get("std_excludes", "")),
        endogeneity=tuple(
            Endogeneity(
                str(e["columns"]),
                number(e["F"]),
                (int(e["df"][0]), number(e["df"][1])),
                number(e["p_value"]),
            )
            for e in content.get("endogeneity", ())
        ),
        comparison=tuple(_contrast(c, names, math.nan) for c in content.get("comparison", ())),
        prior=None if prior is None else _contrast(prior, names, math.inf),
        whiteness=tested,
        band=None if content.get("band") is None else read_band(content["band"]),
        repairs=tuple(map(read_repair, content.get("repairs", ()))),
        alternatives=tuple(map(_alternative, content.get("models", ()))),
        uses=tuple(_use(name, use) for name, use in content.get("uses", {}).items()),
        headline=str(content.get("headline", "")),
    )


def _components(quantity: str, joints: int) -> int:
    """Return how many components the residual of a quantity has."""
    return max(1, joints) if quantity in _PER_JOINT else 1


def read_repair(content: dict[str, Any]) -> Repair:
    """Read an entry of the key "repairs"."""
    log, channel, fault, done = (str(content[key]) for key in ("log", "channel", "fault", "done"))
    return Repair(log, channel, fault, int(content["samples"]), done)


def read_band(content: dict[str, Any]) -> Band:
    """Read the key "band"."""
    rate, cutoff, comparison = (
        number(content[key]) for key in ("rate_hz", "cutoff_hz", "comparison_hz")
    )
    if not min(rate, cutoff, comparison) > 0 or content["velocity"] not in ("measured", "derived"):
        raise ValueError("band")
    rests = content.get("rests")
    if rests is not None:
        slow, weight = (tuple(map(number, rests[key])) for key in ("slow", "weight"))
        if len(slow) != len(weight) or not all(0 < w <= 1 for w in weight):
            raise ValueError("rests")
        rests = Rests(slow, weight)
    return Band(rate, cutoff, comparison, str(content["velocity"]), rests)


def _alternative(content: dict[str, Any]) -> Alternative:
    torque = content["torque_residual"]
    train, validation = (None, None) if torque is None else _residuals(torque)
    return Alternative(
        str(content["model"]),
        or_inf(content["condition_number"]),
        or_inf(content["held_out_folds"]),
        train,
        validation,
        bool(content["chosen"]),
        str(content["reason"]),
        tuple((str(a["name"]), number(a["std"])) for a in content["apart"]),
    )


def _use(name: str, content: dict[str, Any]) -> Use:
    reason = str(content["reason"])
    known = tuple(map(str, content.get("known", ())))
    return Use(name, (reason,) if reason else (), known)


def or_inf(value: Any) -> float:
    """Return a number; infinity for null."""
    return math.inf if value is None else number(value)


def _whiteness(w: dict[str, Any]) -> Whiteness:
    if len(w["correlations"]) != len(w["bands"]) or not w["bands"]:
        raise ValueError("lags of whiteness")
    return Whiteness(
        str(w["quantity"]),
        int(w["component"]),
        str(w["kind"]),
        int(w["rows"]),
        number(w["step_s"]),
        tuple(map(number, w["correlations"])),
        tuple(map(number, w["bands"])),
        number(w["statistic"]),
        number(w["p_value"]),
    )


def _residuals(both: dict[str, Any]) -> tuple[Residual, Residual]:
    def one(content: dict[str, Any]) -> Residual:
        joints = content["per_joint"]
        found = None if joints is None else tuple(map(number, joints))
        return Residual(number(content["relative"]), found)

    return one(both["train"]), one(both["validation"])


def _contrast(content: dict[str, Any], names: Sequence[str], missing: float) -> Contrast:
    """Return values in the order of X; a parameter that is not named has the std `missing`."""
    found = {str(p["name"]): (number(p["value"]), or_nan(p["std"])) for p in content["parameters"]}
    pairs = [found.get(name, (0.0, missing)) for name in names]
    return Contrast(
        str(content["method"]), *(np.array(column) for column in zip(*pairs, strict=True))
    )


def or_nan(value: Any) -> float:
    """Return a number; NaN for null."""
    return math.nan if value is None else number(value)


def _number_or_none(value: Any) -> float | None:
    return None if value is None else number(value)


def number(value: Any) -> float:
    """Return a number; anything else is a TypeError."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise TypeError(f"{value!r} is no number")
    return float(value)
