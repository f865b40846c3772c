"""An estimate as estimate.json, and back: the one place that knows what the file holds.

The classes here are the file, key by key; what older schemas do not hold has a default.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from symgen.errors import ParameterError
from symgen.estimation.band import Band
from symgen.estimation.values import Contrast, Endogeneity, Residual, Whiteness
from symgen.faults.fault import Fault
from symgen.identification.curves import FILE, read_curves
from symgen.identification.estimate import (
    READ,
    SCHEMA,
    UNCHECKED,
    Alternative,
    Consistency,
    Estimate,
    ParameterEstimate,
    Use,
)
from symgen.schemas import OrNan, from_json, read_json, result_file, to_json

MARKER = "estimate.json"
_PER_JOINT = ("torque", "momentum")  # residuals of one component a joint


@dataclass(frozen=True)
class Joint:
    """A joint by its number in the file, and the unit of its torque."""

    number: int
    unit: str


@dataclass(frozen=True)
class _Parameter:
    name: str
    expression: str
    value: float
    std: OrNan
    unit: str
    relative_std_percent: float | None = None


@dataclass(frozen=True)
class _Both:
    train: Residual
    validation: Residual


@dataclass(frozen=True)
class _Value:
    name: str
    value: float
    std: OrNan


@dataclass(frozen=True)
class _Method:
    method: str
    parameters: tuple[_Value, ...]


@dataclass(frozen=True)
class _Apart:
    name: str
    std: float


@dataclass(frozen=True)
class _Model:
    model: str
    condition_number: float | None
    torque_residual: _Both | None
    held_out_folds: float | None
    chosen: bool
    reason: str
    apart: tuple[_Apart, ...]


@dataclass(frozen=True)
class _Use:
    ok: bool
    reason: str
    known: tuple[str, ...] | None = field(default=None, metadata={"absent": True})


@dataclass(frozen=True)
class _Test:
    columns: str
    F: float
    df: tuple[int, float]
    p_value: float


@dataclass(frozen=True, kw_only=True)
class _File:
    robot: str
    joints: tuple[Joint, ...] = ()
    model: str
    method: str
    parameters: tuple[_Parameter, ...]
    condition_number: float
    residual: _Both
    torque_residual: _Both | None = None
    cutoff_hz: float | None
    window_s: float | None
    verdict: str
    reasons: tuple[str, ...]
    headline: str = ""
    uses: dict[str, _Use] = field(default_factory=dict)
    band: Band | None = None
    models: tuple[_Model, ...] = ()
    repairs: tuple[Fault, ...] = ()
    physical: Consistency = UNCHECKED
    std_excludes: str = ""
    endogeneity: tuple[_Test, ...] = ()
    comparison: tuple[_Method, ...] = ()
    prior: _Method | None = None
    correlation: tuple[tuple[OrNan, ...], ...] = ()
    whiteness: tuple[Whiteness, ...] = ()
    notes: tuple[str, ...] = ()
    provenance: dict[str, str] = field(default_factory=dict)


def estimate_json(e: Estimate) -> dict[str, Any]:
    """Return the content of estimate.json."""
    names = [p.name for p in e.parameters]
    file = _File(
        robot=e.robot,
        joints=tuple(Joint(*joint) for joint in e.joints),
        model=e.model,
        method=e.method,
        parameters=tuple(
            _Parameter(**asdict(p), relative_std_percent=p.relative_std_percent)
            for p in e.parameters
        ),
        condition_number=e.condition_number,
        residual=_Both(e.train, e.validation),
        torque_residual=_both(e.torque_train, e.torque_validation),
        cutoff_hz=e.cutoff_hz,
        window_s=e.window_s,
        verdict=e.verdict,
        reasons=e.reasons,
        headline=e.headline,
        uses={
            u.name: _Use(u.ok, "; ".join(u.reasons), u.known if u.name == "parameters" else None)
            for u in e.uses
        },
        band=e.band,
        models=tuple(
            _Model(
                a.model,
                a.condition_number,
                _both(a.train, a.validation),
                a.held_out,
                a.chosen,
                a.reason,
                tuple(_Apart(*pair) for pair in a.apart),
            )
            for a in e.alternatives
        ),
        repairs=e.repairs,
        physical=e.physical,
        std_excludes=e.excludes,
        endogeneity=tuple(_Test(t.columns, t.statistic, t.df, t.p_value) for t in e.endogeneity),
        comparison=tuple(_method(c, names) for c in e.comparison),
        prior=None if e.prior is None else _method(e.prior, names),
        correlation=tuple(map(tuple, e.correlation.tolist())),
        whiteness=e.whiteness,
        notes=e.notes,
        provenance=dict(e.provenance),
    )
    return to_json(file, SCHEMA)


def read_estimate(path: str | Path) -> Estimate:
    """Read an estimate again.

    Args:
        path: the folder that `identify` wrote, or the estimate.json in it. The curves for figures
            come from curves.npz beside it; without that file there are none. What an older
            estimate.json does not hold is empty.

    Raises:
        ParameterError: there is no estimate, or it is damaged.
    """
    file = result_file(path, MARKER)
    found = from_json(_File, read_json(file, *READ), file)
    try:
        estimate = _estimate(found)
    except ValueError as error:
        raise ParameterError(
            f"{file}: damaged ({error}); accepted: schema {SCHEMA} as identify writes it"
        ) from error
    traces, balances, course = read_curves(file.with_name(FILE), len(estimate.parameters))
    return replace(estimate, traces=traces, balances=balances, convergence=course)


def _estimate(f: _File) -> Estimate:
    """Return what a file holds.

    Raises:
        ValueError: parts of it do not belong together.
    """
    names = [p.name for p in f.parameters]
    if len(set(names)) < len(names) or not names:
        raise ValueError("parameters are missing, or there twice")
    correlation = np.array(f.correlation, dtype=float)
    if correlation.size and correlation.shape != (len(names), len(names)):
        raise ValueError("correlation has another size")
    torque = f.torque_residual
    known = (torque and torque.validation.per_joint) or ()
    for w in f.whiteness:
        count = max(1, len(f.joints)) if w.quantity in _PER_JOINT else 1
        if not 0 <= w.component < count:
            raise ValueError("whiteness of a joint that is not there")
        if len(w.correlations) != len(w.bands) or not w.bands:
            raise ValueError("lags of whiteness")
    if f.band is not None:
        f.band.require()
    return Estimate(
        robot=f.robot,
        joints=tuple((j.number, j.unit) for j in f.joints)
        or tuple((j, "N m or N") for j in range(1, len(known) + 1)),
        model=f.model,
        method=f.method,
        parameters=tuple(
            ParameterEstimate(p.name, p.expression, p.value, p.std, p.unit) for p in f.parameters
        ),
        condition_number=f.condition_number,
        train=f.residual.train,
        validation=f.residual.validation,
        torque_train=None if torque is None else torque.train,
        torque_validation=None if torque is None else torque.validation,
        cutoff_hz=f.cutoff_hz,
        window_s=f.window_s,
        verdict=f.verdict,
        reasons=f.reasons,
        notes=f.notes,
        correlation=correlation if correlation.size else np.empty((0, 0)),
        provenance=tuple(f.provenance.items()),
        physical=f.physical,
        excludes=f.std_excludes,
        endogeneity=tuple(Endogeneity(t.columns, t.F, t.df, t.p_value) for t in f.endogeneity),
        comparison=tuple(_contrast(m, names, math.nan) for m in f.comparison),
        prior=None if f.prior is None else _contrast(f.prior, names, math.inf),
        whiteness=f.whiteness,
        band=f.band,
        repairs=f.repairs,
        alternatives=tuple(map(_alternative, f.models)),
        uses=tuple(
            Use(name, (u.reason,) if u.reason else (), u.known or ()) for name, u in f.uses.items()
        ),
        headline=f.headline,
    )


def _alternative(m: _Model) -> Alternative:
    torque = m.torque_residual
    return Alternative(
        m.model,
        _or(m.condition_number, math.inf),
        _or(m.held_out_folds, math.inf),
        None if torque is None else torque.train,
        None if torque is None else torque.validation,
        m.chosen,
        m.reason,
        tuple((a.name, a.std) for a in m.apart),
    )


def _both(train: Residual | None, validation: Residual | None) -> _Both | None:
    return None if train is None or validation is None else _Both(train, validation)


def _method(other: Contrast, names: Sequence[str]) -> _Method:
    """Return the parameters that a method or a prior knows."""
    found = zip(names, other.X.tolist(), other.std.tolist(), strict=True)
    return _Method(other.method, tuple(_Value(*p) for p in found if not math.isinf(p[2])))


def _contrast(m: _Method, names: Sequence[str], missing: float) -> Contrast:
    """Return values in the order of X; a parameter that is not named has the std `missing`."""
    found = {p.name: (p.value, p.std) for p in m.parameters}
    X, std = zip(*(found.get(name, (0.0, missing)) for name in names), strict=True)
    return Contrast(m.method, np.array(X), np.array(std))


def _or(value: float | None, missing: float) -> float:
    """Return a number, and what stands in a file as null."""
    return missing if value is None else value
