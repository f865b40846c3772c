"""Figures of a diagnosis: residual over what it depends on, torques over time, repairs."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from symgen import names
from symgen.diagnosis.diagnosis import Curves, Diagnosis
from symgen.report.plots.figure import Figure, Panel, joint_panels

_DOTS, _FEW = 500, 100  # points of a residual plot, shared by the logs; and minimum for each log
_MOST = 0.8  # share of the gap at the joints of the first plot
_UNITS = {names.REVOLUTE: ("N m", "rad"), names.PRISMATIC: ("N", "m")}
#: Arrays of `Curves` over which the residual is drawn, by its pattern; others have two.
_ABSCISSAE = {
    "velocity-sign": "qd",
    "velocity": "qd",
    "low-speed": "qd",
    "kinematic": "qd",
    "other-joint": "qd",
    "reversal": "q",
    "position": "q",
    "spectrum": "q",
    "acceleration": "qdd",
    "load": "before",
    "time": "t",
}
_AXES = {
    "t": "time, s",
    "q": "position{of}, {unit}",
    "qd": "speed{of}, {unit}/s",
    "qdd": "acceleration{of}, {unit}/s2",
    "before": "modelled torque{of}, {torque}",
}


def dependences(diagnosis: Diagnosis) -> Figure | None:
    """Draw the residual over what it depends on, at the joints with most of the gap."""
    shares = np.cumsum([place.share for place in diagnosis.where])
    wanted, at = [], diagnosis.joints.index
    for place in diagnosis.where[: np.searchsorted(shares, _MOST) + 1]:
        pairs = [e.joints for e in diagnosis.effects if place.joint in e.joints]
        others = [k for pair in pairs for k in pair if k != place.joint] or [place.joint]
        followed = others[0] if place.pattern == "other-joint" else place.joint
        keys = _ABSCISSAE.get(place.pattern, "qd q").split()
        wanted += [(at(place.joint), at(followed), key) for key in keys]
    return _residuals(diagnosis, wanted)


def residuals(diagnosis: Diagnosis) -> Figure | None:
    """Draw the residual of every joint over time, speed and position."""
    every = range(len(diagnosis.joints))
    return _residuals(diagnosis, [(j, j, key) for key in ("t", "qd", "q") for j in every])


def _residuals(diagnosis: Diagnosis, wanted: Sequence[tuple[int, int, str]]) -> Figure | None:
    """Draw residuals of joint j over an array of `Curves` of joint k, each (j, k, array).

    Joints are numbered from 0. The result is None if there is nothing to draw.
    """
    panels, joints, logs = [], _joints(diagnosis), _recorded(diagnosis)
    keys = [f"residual {key}" for key in _shown(diagnosis)]
    for c in logs:
        count = _DOTS // len(logs) + _FEW
        some = np.unique(np.linspace(0, len(c.t) - 1, count).astype(int))
        for j, k, key in wanted:
            (name, title, _), (other, torque, unit) = joints[j], joints[k]
            of = "" if j == k else f" of {other}"
            label = _AXES[key].format(of=of, unit=unit, torque=torque)
            x = getattr(c, key)[some]
            x = x[:, k] if x.ndim > 1 else x
            drawn = [np.stack([x, residual[some, j]]) for residual in c.residuals]
            series = dict(zip(keys, drawn, strict=False))
            log = (c.name, "validation")
            panels.append(Panel(f"{name}, {title}", x, series, log, xlabel=label))
    return Figure(tuple(panels), "") if panels else None


def _shown(diagnosis: Diagnosis) -> list[str]:
    """Return the models to draw: before, and after if an effect is adopted."""
    adopted = any(effect.adopted for effect in diagnosis.effects)
    return ["before", "after"] if adopted else ["before"]


def torques(diagnosis: Diagnosis) -> Figure | None:
    """Draw the torque of every joint over time: measured, and modelled before and after."""
    panels, keys = [], ["measured", *_shown(diagnosis)]
    titles = [f"{label}, {torque}" for label, torque, _ in _joints(diagnosis)]
    for c in _recorded(diagnosis):
        series = {key: getattr(c, key) for key in keys}
        panels += joint_panels(titles, c.t, series, (c.name, "validation"))
    return Figure(tuple(panels)) if panels else None


def repaired(diagnosis: Diagnosis) -> Figure | None:
    """Draw one channel of each repair where it changes most, as recorded and as used."""
    panels, done = [], set()
    for c in diagnosis.mended:
        if (c.log, c.says) in done:
            continue
        done.add((c.log, c.says))
        where = f"{c.channel} of {c.log[:60]}, {c.unit}"
        before, after = {"as recorded": c.recorded}, {"as repaired": c.repaired}
        panels.append(Panel(f"{where}: {c.says[:90]}", c.recorded[0], before))
        panels.append(Panel(f"{where}: repaired", c.recorded[0], after))
    return Figure(tuple(panels)) if panels else None


def _recorded(diagnosis: Diagnosis) -> list[Curves]:
    return [c for c in diagnosis.curves if len(c.t)]


def _joints(diagnosis: Diagnosis) -> list[tuple[str, str, str]]:
    """Return the label of each joint, and the units of its torque and of its position."""
    sigma = {j.number: j.sigma for j in diagnosis.extended.movable}
    labels = diagnosis.extended.labels
    return [(labels[number], *_UNITS[sigma[number]]) for number in diagnosis.joints]
