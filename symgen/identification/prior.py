"""A prior from a file: values from CAD, or an estimate made before."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from symgen import names
from symgen.codegen.model import Model
from symgen.errors import ParameterError
from symgen.estimation.estimators import Prior
from symgen.identification.parameters import base_values, cad_parameters, read_named
from symgen.robot.imported import FORMATS

#: Standard deviation of a prior value that has none, as a share of the value ...
SHARE = 0.3
#: ... which counts as at least this share of the largest of its unit.
_LEAST = 0.1


def read_prior(path: str | Path, model: Model) -> Prior:
    """Read a prior for the base parameters.

    A base parameter has one where the file names it, or all standard parameters that it joins; the
    others are free. Standard deviations are those of an estimate.json; elsewhere 30 % of the value,
    or 3 % of the largest value of the same unit where that is more. What a .urdf leaves open (rotor
    inertia, friction of 0) has no prior, nor has what is joined with it.

    Args:
        path: an estimate.json, TOML with [parameters] (base or standard ones), or the .urdf that
            the robot was imported from.
        model: whose parameters they are.

    Raises:
        ParameterError: the file cannot be read, or names no parameter of this robot.
    """
    path = Path(path)
    given: dict[str, Any]
    deviation: dict[str, Any] = {}
    if path.suffix.lower() in FORMATS:
        links = {p.name for p in model.base.standard if p.inertial and p.prefix in names.LINK}
        found = cad_parameters(path, model)
        given = {name: value for name, value in found.items() if value or name in links}
    else:
        pairs = read_named(path, model.robot.name)
        given = {name: value for name, (value, _) in pairs.items()}
        deviation = {name: std for name, (_, std) in pairs.items()}
    values = base_values(given, model, str(path), partial=True)
    known = np.isfinite(values)
    if not known.any():
        raise ParameterError(f"{path}: it gives no base parameter of {model.robot.name}")
    mean = np.where(known, values, 0.0)
    parameters = model.base.parameters
    largest = {p.unit: 0.0 for p in parameters}
    for p, x in zip(parameters, mean, strict=True):
        largest[p.unit] = max(largest[p.unit], abs(float(x)))
    std = [
        _deviation(deviation.get(p.name), float(x), largest[p.unit]) if k else math.inf
        for p, x, k in zip(parameters, mean, known, strict=True)
    ]
    return Prior(mean, np.array(std))


def _deviation(given: Any, value: float, largest: float) -> float:
    """Return the deviation of an estimate, or a share of the value."""
    if isinstance(given, (int, float)) and math.isfinite(given) and given > 0:
        return float(given)
    return SHARE * max(abs(value), _LEAST * largest) or math.inf
