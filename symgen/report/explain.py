"""explain: description and formula of an effect."""

from __future__ import annotations

import numpy as np

from symgen import names
from symgen.errors import ParameterError
from symgen.files import rendered
from symgen.robot.effect import Definition, SearchRange, definitions, effect_unit

_KINDS = {
    "linear": "linear: columns in every kernel, in C and CasADi",
    "model": "model: needs the model's own torque; measured by symgen diagnose",
    "log": "log: belongs to the measuring chain or to time; measured by symgen diagnose on samples",
}


def effect_list() -> list[tuple[str, str, str]]:
    """Return name, kind and meaning of every effect in the library."""
    return [(d.name, d.kind, d.says) for d in definitions().values()]


def explain_effect(name: str) -> str:
    """Return the description of an effect, as a text of several lines.

    Raises:
        ParameterError: the library has no such effect.
    """
    known = definitions()
    if name not in known:
        raise ParameterError(f"effect {name[:60]!r}; accepted: {', '.join(known)}")
    d = known[name]
    middle = ", ".join(f"{key} = {_middle(s):.3g}" for key, s in d.nonlinear.items())
    return rendered(
        "text/effect.txt",
        d=d,
        kind=_KINDS[d.kind],
        coefficients=[_coefficient(d, key) for key in d.linear],
        constants=[_constant(key, search) for key, search in d.nonlinear.items()],
        middle=middle,
        friction=names.FRICTION,
    )


def _middle(search: SearchRange) -> float:
    return float(np.sqrt(search.low * search.high)) if search.by_ratio else search.low


def _coefficient(d: Definition, key: str) -> str:
    units = dict.fromkeys(effect_unit(d.linear[key], s) for s in (names.REVOLUTE, names.PRISMATIC))
    written = " or ".join(u for u in units if u) or "no unit"
    return f"{key} [{written}]" + (", positive" if d.sign == "positive" else "")


def _constant(key: str, search: SearchRange) -> str:
    of = {"speed": " of the joint's RMS speed", "duration": " of the log's duration"}
    part = of.get(search.scale, "")
    return f"{key}: {search.low:g} to {search.high:g}{part}, {search.count} values tried"
