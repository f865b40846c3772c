"""Effects of a robot with other constants than those that its kernels contain.

    tau_motor = kernels at coefficients 0 + sum of columns(q, qd; c) times coefficients

The kernels of a model contain the constants as numbers. Here they are variables.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from symgen.codegen.model import Model
from symgen.data.raw import FloatArray
from symgen.errors import ParameterError
from symgen.robot.effect import Effect
from symgen.robot.expressions import exact
from symgen.robot.types import Robot
from symgen.symbolic.effects import constants_tape
from symgen.symbolic.independence import FUNCTIONS
from symgen.symbolic.tape import Numbers, Tape


class Slopes(NamedTuple):
    """Columns and derivatives of the torques of effects: W (N, n, p), by_q, by_qd, by_c (N, n, _).

    The columns of the other parameters are 0.
    """

    W: FloatArray
    by_q: FloatArray
    by_qd: FloatArray
    by_c: FloatArray


@dataclass(frozen=True, eq=False)
class EffectConstants:
    """The constants of effects, and the torques of these effects as functions of them.

    Attributes:
        names: of the constants.
        values: (c,) in the robot file.
        owners: (c,) name of the effect of each.
        others: names of constants that are no variables here: their effects need the acceleration
            or the load.
        places: (m,) index in X of the coefficient of each column.
        rows: (m,) index of the joint of each column.
        own: (m, c) whether a column has a constant.
        n, p: number of joints and of parameters.
    """

    names: tuple[str, ...]
    values: FloatArray
    owners: tuple[str, ...]
    others: tuple[str, ...]
    places: NDArray[np.intp]
    rows: NDArray[np.intp]
    own: NDArray[np.bool_]
    n: int
    p: int
    _robot: Robot
    _tapes: tuple[Tape, Tape]

    @classmethod
    def of(cls, model: Model) -> EffectConstants:
        """Return the constants of a model."""
        robot, names = model.robot, model.base.names
        every = [e for e in robot.effects if e.nonlinear]
        effects = [e for e in every if not _accelerated(e)]
        columns = [(e, name, j) for e in effects for name, _ in e.linear for j, _ in e.torque]
        constants = [(e, *named) for e in effects for named in e.nonlinear]
        whole = constants_tape(robot, effects)
        stride = 1 + 2 * robot.n + len(constants)
        return cls(
            tuple(name for _, name, _ in constants),
            np.array([float(value.subs(robot.values())) for *_, value in constants]),
            tuple(e.name for e, *_ in constants),
            tuple(name for e in every if _accelerated(e) for name, _ in e.nonlinear),
            np.array([names.index(name) for _, name, _ in columns], dtype=np.intp),
            np.array([robot.numbers.index(j) for *_, j in columns], dtype=np.intp),
            np.array([[e is other for other, *_ in constants] for e, *_ in columns], dtype=bool),
            robot.n,
            len(names),
            robot,
            (whole.keep(range(0, stride * len(columns), stride)), whole),
        )

    def without(self, X: FloatArray) -> FloatArray:
        """Return parameters (p,) with 0 for the coefficients of the effects."""
        out = X.copy()
        out[self.places] = 0.0
        return out

    def torque(self, q: FloatArray, qd: FloatArray, X: FloatArray, c: FloatArray) -> FloatArray:
        """Return the torque of the effects on the motors, (N, n).

        Args:
            q, qd: (N, n) rad or m, rad/s or m/s.
            X: (p,).
            c: (c,) constants.

        Raises:
            ParameterError: it is not finite.
        """
        out = np.zeros_like(q)
        for row, column, place in zip(
            self.rows, self._run(self._tapes[0], q, qd, c), self.places, strict=True
        ):
            out[:, row] += column * X[place]
        if not np.isfinite(out).all():
            raise ParameterError("the torque of an effect is not finite")
        return out

    def slopes(self, q: FloatArray, qd: FloatArray, X: FloatArray, c: FloatArray) -> Slopes:
        """Return the columns of the effects and the derivatives of their torque; see `torque`."""
        n, size, count = self.n, len(self.names), len(q)
        W = np.zeros((count, n, self.p))
        by = np.zeros((count, n, 2 * n + size))
        found = self._run(self._tapes[1], q, qd, c).reshape(len(self.rows), -1, count)
        for row, place, (column, *slopes) in zip(self.rows, self.places, found, strict=True):
            W[:, row, place] = column
            by[:, row] += np.stack(slopes, axis=1) * X[place]
        return Slopes(W, by[..., :n], by[..., n : 2 * n], by[..., 2 * n :])

    def moved(self, c: FloatArray) -> Robot:
        """Return the robot with other constants (c,), rounded to six digits."""
        rounded = (exact(float(f"{value:.6g}")) for value in c)
        return self._robot.with_constants(dict(zip(self.names, rounded, strict=True)))

    def _run(self, tape: Tape, q: FloatArray, qd: FloatArray, c: FloatArray) -> FloatArray:
        inputs = {"q": [*q.T], "qd": [*qd.T], "c": [*c]}
        with np.errstate(all="ignore"):
            out = tape.run(Numbers(self._robot.values(), FUNCTIONS), inputs)
        return np.array([np.broadcast_to(np.asarray(x, dtype=float), len(q)) for x in out])


def _accelerated(effect: Effect) -> bool:
    """Whether the torque of an effect needs more than q and qd."""
    read = {s.name for _, torque in effect.torque for s in torque.free_symbols}
    return any(re.fullmatch(r"(qdd|taur)\d+", name) for name in read - {*effect.names})
