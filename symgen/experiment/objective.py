"""What a search makes small: the criterion on samples of the regressor, and its gradient in z.

The gradient goes backwards through scaling and windows by hand, through the kernels by CasADi's
reverse mode, and through the bases by their transpose.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from symgen.codegen.casadi_model import casadi_function
from symgen.codegen.model import Model, derive
from symgen.errors import PackageError
from symgen.experiment.bounds import Bounds
from symgen.experiment.criterion import KERNELS, FloatArray, loss, windows
from symgen.experiment.space import Space
from symgen.robot.types import Robot

#: Width of tanh(qd/width) for sign(qd), as a share of the largest speed, while searching.
_SMOOTH = 0.03
_PER_PERIOD = 8  # samples of the criterion in a period of the fastest term
_ROWS = 2  # rows of the regressor for each parameter, at least
#: Inputs of kernels in the order of derivatives.
INPUTS = ("q", "qd", "qdd")


def smooth_robot(robot: Robot, limits: Bounds) -> Robot:
    """Return the robot with Coulomb friction that has a derivative where speeds change sign."""
    width = iter(_SMOOTH * limits.rates[0])
    return replace(
        robot,
        joints=tuple(
            replace(j, coulomb_width=j.coulomb_width or float(next(width))) if j.movable else j
            for j in robot.joints
        ),
    )


class Objective:
    """The loss of a vector z and its gradient, on a grid of samples of all runs."""

    def __init__(self, robot: Robot, space: Space, model: str, window: float, base: Model) -> None:
        self.space, self.size = space, space.size
        derived = derive(robot, (*KERNELS[model], "inverse_dynamics"))
        if derived.base.names != base.base.names:
            raise PackageError("the smoothed model has other parameters than the model")
        kernels = [k for k in map(derived.kernel, KERNELS[model]) if k is not None]
        torque = derived.kernel("inverse_dynamics")
        assert torque is not None
        self.inverse = casadi_function(derived, torque)
        self.grids: list[FloatArray] = []
        self.windows = []
        reach = 0.0 if model == "torque" else window
        equations = 1 if model == "energy" else robot.n  # of each sample
        enough = math.ceil(_ROWS * len(derived.base.names) / equations / space.runs)
        for run in range(space.runs):
            length = space.duration(run)
            step = min(length / (_PER_PERIOD * fastest(space, run)), (length - reach) / enough)
            steps = max(1, math.ceil(window / step - 1e-9), 4 if model != "torque" else 1)
            if model != "torque":
                step = window / steps
            count = int(length / step + 1e-9) + 1
            self.grids.append(np.arange(count) * np.float64(step))
            self.windows.append(windows(model, count, step, steps))
        self.counts = [len(t) for t in self.grids]
        self.shapes = [[o.shape for o in k.outputs] for k in kernels]
        self.inputs = [[INPUTS.index(name) for name, _ in k.tape.inputs] for k in kernels]
        total = sum(self.counts)
        self.maps = [casadi_function(derived, k, flat=True).map(total) for k in kernels]
        self.reverse = [m.reverse(1) for m in self.maps]
        self.matrices = [
            tuple(b.matrix(self.grids[b.run], order) for order in range(3)) for b in space.blocks
        ]
        self.spans = [slice(a, b) for a, b in pairwise(np.cumsum([0, *self.counts]))]

    def motion(self, z: FloatArray) -> list[FloatArray]:
        """Return q, qd, qdd of all runs, each (n, samples)."""
        out = [np.empty((len(self.space.centre), sum(self.counts))) for _ in range(3)]
        for b, matrices in zip(self.space.blocks, self.matrices, strict=True):
            for x, B in zip(out, matrices, strict=True):
                x[b.joint, self.spans[b.run]] = B @ z[b.part]
        out[0] += self.space.centre[:, None]
        return out

    def __call__(self, z: FloatArray, criterion: str) -> tuple[float, FloatArray]:
        """Return the loss and its gradient (size,)."""
        motion = self.motion(z)
        raw: list[tuple[Any, ...]] = []
        samples: list[FloatArray] = []
        for function, inputs, shapes in zip(self.maps, self.inputs, self.shapes, strict=True):
            result = function(*(motion[i] for i in inputs))
            raw.append(result if isinstance(result, tuple) else (result,))
            samples += [
                r.full().T.reshape(-1, *shape) for r, shape in zip(raw[-1], shapes, strict=True)
            ]
        parts = [tuple(s[span] for s in samples) for span in self.spans]
        rows = [w.rows(part) for w, part in zip(self.windows, parts, strict=True)]
        value, gradient = loss(np.concatenate(rows), criterion)
        pieces = np.split(gradient, np.cumsum([len(r) for r in rows])[:-1])
        backs = [
            w.transposed(piece, part)
            for w, piece, part in zip(self.windows, pieces, parts, strict=True)
        ]
        seeds = [
            np.concatenate([back[k] for back in backs]).reshape(sum(self.counts), -1).T
            for k in range(len(samples))
        ]
        slopes = [np.zeros_like(x) for x in motion]
        for function, inputs, outputs in zip(self.reverse, self.inputs, raw, strict=True):
            own, seeds = seeds[: len(outputs)], seeds[len(outputs) :]
            result = function(*(motion[i] for i in inputs), *outputs, *own)
            found = result if isinstance(result, tuple) else (result,)
            for i, slope in zip(inputs, found, strict=True):
                slopes[i] += slope.full()
        out = np.zeros(self.size)
        for b, matrices in zip(self.space.blocks, self.matrices, strict=True):
            for slope, B in zip(slopes, matrices, strict=True):
                out[b.part] += slope[b.joint, self.spans[b.run]] @ B
        return value, out


def fastest(space: Space, run: int) -> int:
    """Return how many periods of the fastest term fit into a run."""
    own = (b.basis for b in space.blocks if b.run == run)
    return max(b.terms if b.kind in ("fourier", "cosine") else math.ceil(b.terms / 2) for b in own)
