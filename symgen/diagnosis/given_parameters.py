"""Given parameters: one set of link parameters that gives them, and what effects add to them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from symgen import names
from symgen.codegen.model import Model
from symgen.diagnosis.diagnosis import FoundParameter
from symgen.identification.parameters import base_values

FloatArray = NDArray[np.float64]


def link_values(model: Model, X: FloatArray) -> FloatArray:
    """Return link parameters (links, 10) that give X (p,): those that lead a base parameter.

    All others are zero: of the many sets, this one differs from the true one by what has no
    torque in the model's own geometry and gravity.
    """
    out = np.zeros((len(model.robot.joints), len(names.LINK)))
    for value, p in zip(X, model.base.parameters, strict=True):
        standard = model.base.standard[p.index]
        if standard.prefix in names.LINK:
            out[standard.joint - 1, names.LINK.index(standard.prefix)] += value
    return out


def changed(
    model: Model, X: FloatArray, extended: Model, added: Sequence[FoundParameter]
) -> FloatArray:
    """Return the base parameters of the extended model: those given, and what effects add.

    Args:
        model: of the given parameters.
        X: (p,) given.
        extended: the model with the effects declared.
        added: standard parameters of the extended model that effects add to or bring.
    """
    values = {p.name: 0.0 for p in extended.base.standard}
    for value, p in zip(X, model.base.parameters, strict=True):
        values[p.head] = float(value)
    for parameter in added:
        name = parameter.name
        if name not in values:  # a load's parameter that others join: R of its name
            name = name.removesuffix("R")
        if name in values:
            values[name] += parameter.value
    return base_values(values, extended, "the extended model")
