"""explain: description, formula and text picture of an effect."""

from __future__ import annotations

import re
import textwrap
import tomllib
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from symgen import names
from symgen.data.raw import FloatArray
from symgen.errors import ParameterError
from symgen.files import templates
from symgen.robot.effect import Definition, Search, definitions, unit
from symgen.symbolic.effects import definition_tape
from symgen.symbolic.independence import FUNCTIONS
from symgen.symbolic.tape import Numbers

_WIDTH, _HEIGHT = 60, 8  # of a picture, in characters of 2 x 4 dots
_DOTS = ((0x01, 0x02, 0x04, 0x40), (0x08, 0x10, 0x20, 0x80))  # of a Braille character, by column
_MARGIN = 20  # of what is said of an effect
_KINDS = {
    "linear": "linear: columns in every kernel, in C and CasADi",
    "model": "model: needs the model's own torque; measured by symgen diagnose",
    "log": "log: belongs to the measuring chain or to time; measured by symgen diagnose on samples",
}
#: What a picture is drawn over: label and half range, the first of these that a torque holds.
_OVER = {
    "taur": ("the model's torque, with qd = 1", 1.0),
    "q": ("q, rad", np.pi),
    "qd": ("qd, rad/s", 1.0),
    "qdd": ("qdd, rad/s2", 1.0),
}
_WARMER = 10.0  # than the mean, deg C, where a picture asks for a temperature


def listed() -> list[tuple[str, str, str]]:
    """Return name, kind and meaning of every effect of the library."""
    return [(d.name, d.kind, d.says) for d in definitions().values()]


def explained(name: str) -> str:
    """Return the description of an effect, as a text of several lines.

    Raises:
        ParameterError: the library has no such effect.
    """
    known = definitions()
    if name not in known:
        raise ParameterError(f"effect {name[:60]!r}; accepted: {', '.join(known)}")
    d = known[name]
    head = "torque on joint" if d.torque else "formula"
    formula = (d.torque or d.formula) + (" - constant" if d.offset else "")
    lines = [
        (head, formula),
        ("kind", _KINDS[d.kind] + (f", from {', '.join(d.reads)}" if d.reads else "")),
        ("coefficients", "; ".join(_coefficient(d, key) for key in d.linear) or "none of its own"),
        ("constants", "; ".join(_constant(key, s) for key, s in d.nonlinear.items()) or "none"),
        ("pattern", d.pattern),
        ("hard to tell from", d.confused or "nothing known"),
        ("to tell them apart", d.separate),
    ]
    out = [*textwrap.wrap(f"{d.name}: {d.says}", 100), ""]
    for label, said in lines:
        first, *rest = textwrap.wrap(said, 100 - _MARGIN, break_long_words=False) or [""]
        out += [f"{label:<{_MARGIN}}{first}", *(" " * _MARGIN + line for line in rest)]
    out.append(f"{'in robot.toml':<{_MARGIN}}{_declaration(d)}")
    if found := curve(d):
        label, *drawn = found
        out += ["", label, *picture(*drawn)]
    return "\n".join(out)


def curve(definition: Definition) -> tuple[str, FloatArray, FloatArray] | None:
    """Return label, abscissa and ordinate of the picture of an effect, or None.

    The expression is evaluated as compiled for `diagnose`. Coefficients and the other variables of
    the joint are 1. Constants are in the middle of their range, or the lowest one if the range is
    not logarithmic.
    """
    drawn = tomllib.loads((templates() / "report" / "pictures.toml").read_text("utf-8"))
    if definition.name in drawn:
        label, ends, y = drawn[definition.name].values()
        own = replace(definition, torque=f"Y*({y})", linear={"Y": ""}, nonlinear={})
        return label, *_drawn(own, "q", np.linspace(ends[0], ends[1], 2 * _WIDTH), {})
    if not definition.torque:
        return None
    over = next((name for name in _OVER if _holds(definition.torque, name)), "qd")
    text, half = _OVER[over]
    constants = {name: _middle(s) for name, s in definition.nonlinear.items()}
    taken = {k: 0.0 for k, s in definition.nonlinear.items() if s.scale == "mean temp"}
    x = np.linspace(-half, half, 2 * _WIDTH)
    x, y = _drawn(definition, over, x, constants | taken)
    beside = ", with qd = 1" if over == "q" and _holds(definition.torque, "qd") else ""
    beside += f", {_WARMER:g} degC above T0" if definition.reads else ""
    fixed = "".join(f", {name} = {value:.3g}" for name, value in (constants | taken).items())
    ones = " = ".join([*definition.linear, "1"])
    return f"torque over {text}{beside} ({ones}{fixed})", x, y


def _drawn(
    definition: Definition, over: str, x: FloatArray, constants: Mapping[str, float]
) -> tuple[FloatArray, FloatArray]:
    """Return x, and the torque of an effect over it, all coefficients and variables being 1."""
    inputs = {name: [x if name == over else np.ones_like(x)] for name in _OVER}
    inputs |= {role: [np.full_like(x, _WARMER)] for role in definition.reads}
    with np.errstate(divide="ignore"):
        tape = definition_tape(definition)
        columns = tape.run(Numbers({}, FUNCTIONS), {**inputs, "c": list(constants.values())})
    return x, 0.0 - sum(columns, np.zeros_like(x))


def _holds(torque: str, name: str) -> bool:
    return re.search(rf"\b{name}\b", torque) is not None


def _middle(search: Search) -> float:
    return float(np.sqrt(search.low * search.high)) if search.by_ratio else search.low


def _coefficient(d: Definition, key: str) -> str:
    units = dict.fromkeys(unit(d.linear[key], s) for s in (names.REVOLUTE, names.PRISMATIC))
    written = " or ".join(u for u in units if u) or "no unit"
    return f"{key} [{written}]" + (", positive" if d.sign == "positive" else "")


def _constant(key: str, search: Search) -> str:
    if search.scale == "mean temp":
        return f"{key}: the mean temperature of the joint over the logs"
    of = {"speed": " of the joint's RMS speed", "duration": " of the log's duration"}
    part = of.get(search.scale, "")
    return f"{key}: {search.low:g} to {search.high:g}{part}, {search.count} values tried"


def _declaration(d: Definition) -> str:
    if d.native in names.FRICTION:
        return f'friction = ["{d.native}"] of the joint, beside its other words'
    if d.native == "rotor":
        return "rotor_inertia = true of the joint (the default)"
    if d.native == "coupling":
        return "[[coupling]] with joints = [j, k], ratio = 1"
    if d.native == "payload":
        return "[payload] with joint = j, the link that carries it"
    if d.kind == "linear" and not d.torque:
        return "[[effect]] with a name, joints = [j], torque and linear of your own"
    if d.reads:
        values = ", ".join((*d.linear, *d.nonlinear))
        return f'[[effect]] with name = "{d.name}", joints = [j], values = {{ .. }} of {values}'
    if not d.declarable:
        return "not declared there: symgen diagnose measures it"
    constants = ", ".join(f"{key} = {_middle(s):.3g}" for key, s in d.nonlinear.items())
    nonlinear = f", nonlinear = {{ {constants} }}" if constants else ""
    offset = ', and "offset" among the words of its friction' if d.offset else ""
    return f'[[effect]] with name = "{d.name}", joints = [j]{nonlinear}{offset}'


def picture(x: FloatArray, y: FloatArray) -> list[str]:
    """Draw values, (2 width,), as lines of Braille dots with the zero line and the limits."""
    low, high = min(float(y.min()), 0.0), max(float(y.max()), 0.0)
    span = (high - low) or 1.0
    at = np.rint((high - np.append(y[0], y)) / span * (4 * _HEIGHT - 1)).astype(int)
    top, bottom = np.sort([at[:-1], at[1:]], axis=0)
    rows = np.arange(4 * _HEIGHT)[:, None]
    dots = ((top <= rows) & (rows <= bottom)).reshape(_HEIGHT, 4, _WIDTH, 2)
    zero = min(int(np.rint(high / span * (4 * _HEIGHT - 1))) // 4, _HEIGHT - 1)
    values, out = {zero: 0.0, 0: high, _HEIGHT - 1: low}, []
    for r, line in enumerate(np.einsum("rdwc,cd->rw", dots, _DOTS)):
        empty = "─" if r == zero else " "
        drawn = "".join(chr(0x2800 + c) if c else empty for c in line)
        value = f"{values[r]:.3g}" if r in values else ""
        out.append(f"{value:>8} │{drawn}".rstrip())
    left, right = f"{x[0]:.3g}", f"{x[-1]:.3g}"
    return [*out, " " * 10 + left + right.rjust(_WIDTH - len(left))]
