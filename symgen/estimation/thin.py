"""What is kept of a chunk of a long log: all that its equations and its torques need, and no more.

The motion is smooth between nodes, and torques are compared some tens of times a second: a chunk
that was read, mended and filtered once is a quarter of its samples or less, from which a later pass
goes on. W is not kept: it is larger than the motion that it is made of, and quickly evaluated.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symgen.data.mask import Bools
from symgen.estimation.decimation import Decimation
from symgen.estimation.filtered import FilteredLog
from symgen.estimation.recipe import Recipe
from symgen.estimation.system import (
    Equations,
    Model,
    compared_torques,
    energy_rows,
    energy_sides,
    momentum_rows,
    momentum_sides,
    torque_sides,
)
from symgen.estimation.windows import Windows, placed_windows
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
_ROWS = ("samples", "step", "stride", "cutoff", "every", "margin")  # of a Decimation


@dataclass(frozen=True, eq=False)
class ThinLog:
    """A chunk of a log without a mask.

    Attributes:
        name: of the log.
        rows: low-pass of the comparison band on the nodes.
        motion: q, qd, qdd at the nodes, (nodes, n) each.
        windows: of the equations; None for torque.
        window_motion: q, qd at the nodes of the windows.
        sides: the equations without W, joint by joint.
        t: of the samples at which torques are compared, (K,) s.
        measured: torque there, (K, n).
        resting: whether a rest of the joint concerns it, (K, n); None where no joint rests.
    """

    name: str
    rows: Decimation
    motion: tuple[FloatArray, FloatArray, FloatArray]
    windows: Windows | None
    window_motion: tuple[FloatArray, FloatArray]
    sides: tuple[Equations, ...]
    t: FloatArray
    measured: FloatArray
    resting: Bools | None = None

    def equations(self, evaluator: Evaluator, recipe: Recipe) -> tuple[Equations, ...]:
        """Return the equations with their W."""
        if recipe.model == "energy":
            assert self.windows is not None
            W = energy_rows(evaluator, *self.window_motion, self.windows, self.rows.step)
            return (replace(self.sides[0], W=W),)
        if recipe.model == "momentum":
            assert self.windows is not None
            joints = momentum_rows(evaluator, *self.window_motion, self.windows, self.rows.step)
        else:
            joints = compared_torques(evaluator, self.modelled).transpose(1, 0, 2)
        return tuple(
            e.with_rows(np.ascontiguousarray(W)) for e, W in zip(self.sides, joints, strict=True)
        )

    def torque(self, evaluator: Evaluator, X: FloatArray) -> FloatArray:
        """Return the torque of a model in the comparison band, (K, n)."""
        inverse = evaluator["inverse_dynamics"]
        found = self.modelled(lambda q, qd, qdd: inverse(q, qd, qdd, X))
        return np.concatenate([torque for _, torque in found])

    def modelled(self, model: Model) -> Iterator[tuple[slice, FloatArray]]:
        """Evaluate a model along the log, see `FilteredLog.modelled`."""

        def at(first: int, last: int) -> FloatArray:
            return np.asarray(model(*(x[first:last] for x in self.motion)))

        return self.rows.chunks(at)

    def arrays(self) -> dict[str, Any]:
        """Return all of it as arrays, for `packed_arrays` and `thin_log`."""
        arrays: dict[str, Any] = {"t": self.t, "measured": self.measured}
        arrays |= dict(zip(("q", "qd", "qdd"), self.motion, strict=True))
        arrays["name"] = np.array(self.name)
        cutoff = np.nan if self.rows.cutoff is None else self.rows.cutoff
        given = replace(self.rows, cutoff=cutoff)
        arrays["rows"] = np.array([getattr(given, key) for key in _ROWS], dtype=float)
        if self.windows is not None:
            w = self.windows
            arrays["windows"] = np.array([w.stride, w.steps, w.hop])
            if w.stride != self.rows.stride:
                arrays |= dict(zip(("wq", "wqd"), self.window_motion, strict=True))
        arrays["sides_t"] = self.sides[0].t
        arrays["sides_y"] = np.stack([e.y for e in self.sides])
        if any(e.rest is not None for e in self.sides):
            arrays["rest"] = np.stack(
                [np.zeros(len(e.y), bool) if e.rest is None else e.rest for e in self.sides]
            )
            arrays["rest_weight"] = np.array([e.rest_weight for e in self.sides])
        if self.resting is not None:
            arrays["resting"] = self.resting
        arrays["joints"] = np.array([-1 if e.joint is None else e.joint for e in self.sides])
        arrays["correlation"] = np.array(self.sides[0].correlation)
        return arrays


def packed_arrays(arrays: Mapping[str, Any]) -> bytes:
    """Return arrays as the bytes of an NPZ file."""
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def thinned(log: FilteredLog, recipe: Recipe) -> ThinLog:
    """Keep of a log without a mask what its equations and torques need.

    Raises:
        IdentificationError: the window does not fit the log.
    """
    stride = log.rows.stride
    motion = (*log.nodes(stride), np.ascontiguousarray(log.qdd[::stride]))
    if recipe.model == "torque":
        w, own, sides = None, motion[:2], torque_sides(log)
    else:
        w = placed_windows(log, recipe.window)
        own = motion[:2] if w.stride == stride else log.nodes(w.stride)
        sides = [energy_sides(log, w)] if recipe.model == "energy" else momentum_sides(log, w)
    t = log.t[log.kept]
    return ThinLog(log.name, log.rows, motion, w, own, tuple(sides), t, log.measured, log.resting)


def thin_log(arrays: Mapping[str, NDArray[Any]]) -> ThinLog:
    """Return the log whose `arrays` these are."""
    samples, step, stride, cutoff, every, margin = map(float, arrays["rows"])
    rows = Decimation(
        int(samples), step, int(stride), None if np.isnan(cutoff) else cutoff, int(every),
        int(margin),
    )  # fmt: skip
    motion = (arrays["q"], arrays["qd"], arrays["qdd"])
    w = Windows(*map(int, arrays["windows"])) if "windows" in arrays else None
    own = (arrays["wq"], arrays["wqd"]) if "wq" in arrays else motion[:2]
    name, joints = str(arrays["name"]), list(map(int, arrays["joints"]))
    t, y = arrays["sides_t"], arrays["sides_y"]
    none, correlation = np.zeros((len(t), 0)), int(arrays["correlation"])
    sides = tuple(
        Equations(name, none, y[k], t, correlation, None if j < 0 else j)
        for k, j in enumerate(joints)
    )
    if "rest" in arrays:
        weights = zip(sides, arrays["rest"], map(float, arrays["rest_weight"]), strict=True)
        sides = tuple(replace(e, rest=rest, rest_weight=weight) for e, rest, weight in weights)
    seen = arrays["t"], arrays["measured"], arrays.get("resting")
    return ThinLog(name, rows, motion, w, own, sides, *seen)
