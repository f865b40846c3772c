"""Search for a motion: a nonlinear program over emitted CasADi functions, solved by IPOPT.

With W the regressor of the model that will be used, its columns scaled to unit norm, and
lambda_i the eigenvalues of C = W'W, the condition number is sqrt(lambda_max / lambda_min) and
log det C = sum of log lambda_i, 0 at best (Gautier and Khalil 1992, Swevers et al. 1997).
Limits of position, speed, acceleration and jerk are linear in the coefficients.
"""

from __future__ import annotations

import math
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import casadi
import numpy as np

from symgen.codegen.casadi_model import casadi_function
from symgen.codegen.model import Model, derive
from symgen.data.raw import FloatArray
from symgen.estimation.equation_model import NEEDED
from symgen.estimation.integrals import cumulative_integral
from symgen.experiment.bounds import Bounds, Space
from symgen.robot.types import Robot

CRITERIA = ("condition", "logdet")
_FLOOR = 1e-13  # added to the eigenvalues
_SMALL = 1e-30  # of the square of a column's norm
_LARGE = 0.05  # what columns e times as large are worth, in logs of the condition number
#: Width of tanh(qd/width) for sign(qd), as a share of the largest speed, while searching.
_SMOOTH = 0.03
# Samples in a period of the fastest term: of the criterion, the limits and the torques.
_PER_PERIOD, _CHECKS, _TORQUE_CHECKS = 8, 6, 4
_ROWS = 2  # rows of the regressor for each parameter, at least
_MARGIN = 0.985  # of a limit that holds between the samples


@dataclass
class Clock:
    """Stops a search after a time limit or on Ctrl-C."""

    end: float
    interrupted: bool = False
    begun: float = field(default_factory=time.perf_counter)

    @property
    def elapsed(self) -> float:
        """Seconds since the search began."""
        return time.perf_counter() - self.begun

    @property
    def left(self) -> float:
        """Remaining seconds; 0 after Ctrl-C."""
        return 0.0 if self.interrupted else self.end - self.elapsed

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Let Ctrl-C stop the search without an error; only the main thread receives it."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return

        def stop(*_: object) -> None:
            self.interrupted = True

        before = signal.signal(signal.SIGINT, stop)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)


class _Watch(casadi.Callback):
    """Stops IPOPT when the clock has run out."""

    def __init__(self, variables: int, constraints: int, clock: Clock) -> None:
        casadi.Callback.__init__(self)
        self.sizes = {"f": 1, "x": variables, "lam_x": variables}
        self.sizes |= {"g": constraints, "lam_g": constraints}
        self.clock = clock
        self.construct("watch", {})

    def get_n_in(self) -> int:
        return int(casadi.nlpsol_n_out())

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, i: int) -> str:
        return str(casadi.nlpsol_out(i))

    def get_sparsity_in(self, i: int) -> Any:
        size = self.sizes.get(casadi.nlpsol_out(i), 0)
        return casadi.Sparsity.dense(size, 1 if size else 0)

    def eval(self, _: Any) -> Any:
        return [int(self.clock.left <= 0)]


class Program:
    """The nonlinear program of one search; solved from many starts.

    Args:
        robot: the robot.
        space: the motions to choose from, with their limits.
        model: model to identify with: "energy", "momentum" or "torque".
        window: window of energy and momentum, s.
        criterion: "condition" or "logdet".
        prior: parameters (p,) of the model whose torques are limited, or None.
        clock: stops the search.
        iterations: largest number of IPOPT iterations.
    """

    def __init__(
        self,
        robot: Robot,
        space: Space,
        model: str,
        window: float,
        criterion: str,
        prior: FloatArray | None,
        clock: Clock,
        iterations: int,
    ) -> None:
        derived = derive(_smooth(robot, space.limits), (*NEEDED[model], "inverse_dynamics"))
        z = casadi.MX.sym("z", space.size)
        G = sum(_gram(derived, space, run, z, model, window) for run in range(space.runs))
        self.loss = casadi.Function("loss", [z], [_loss(G, criterion)])
        A, low, high = _linear_limits(space)
        g, slopes = [casadi.mtimes(A, z)], [casadi.MX(A)]
        if prior is not None:
            for run in range(space.runs):
                tau, slope = _torques(derived, space, run, z, prior)
                g, slopes = [*g, tau], [*slopes, slope]
        constraints, unused = casadi.vertcat(*g), casadi.MX.sym("p", 0)
        edge = np.full(constraints.numel() - len(low), _MARGIN)
        self.bounds = {"lbg": np.append(low, -edge), "ubg": np.append(high, edge)}
        self.watch = _Watch(space.size, constraints.numel(), clock)
        self.solver = casadi.nlpsol(
            criterion,
            "ipopt",
            {"x": z, "f": self.loss(z), "g": constraints},
            {
                "print_time": False,
                "error_on_fail": False,
                "iteration_callback": self.watch,
                "jac_g": casadi.Function(
                    "jac_g", [z, unused], [constraints, casadi.vertcat(*slopes)]
                ),
                "ipopt": {
                    "print_level": 0,
                    "sb": "yes",
                    "hessian_approximation": "limited-memory",
                    "limited_memory_max_history": 8,
                    "limited_memory_aug_solver": "extended",
                    "max_iter": iterations,
                    "tol": 1e-4,
                    "acceptable_tol": 1e-3,
                    "acceptable_obj_change_tol": 1e-4,
                    "mu_strategy": "monotone",
                    "mu_init": 1e-2,
                },
            },
        )

    def solve(self, z: FloatArray) -> FloatArray:
        """Return the z that IPOPT reaches from a start, or until the clock stops it."""
        found: FloatArray = self.solver(x0=z, **self.bounds)["x"].full()[:, 0]
        return found if np.isfinite(found).all() else z


def _smooth(robot: Robot, limits: Bounds) -> Robot:
    """Return the robot with Coulomb friction that is differentiable at zero speed."""
    width = iter(_SMOOTH * limits.rates[0])
    joints = (
        replace(j, coulomb_width=j.coulomb_width or float(next(width))) if j.movable else j
        for j in robot.joints
    )
    return replace(robot, joints=tuple(joints))


def _fastest(space: Space, run: int) -> int:
    """Return the number of periods of the fastest term in a run."""
    own = (b.basis for b in space.of(run))
    return max(b.terms if b.kind in ("fourier", "cosine") else math.ceil(b.terms / 2) for b in own)


def _basis(space: Space, run: int, t: FloatArray) -> tuple[Any, FloatArray]:
    """Return B, c of q, qd, qdd = B z + c at times t, joint by joint: (3 n N, size), (3 n N,)."""
    own = space.of(run)
    orders = ([casadi.DM(b.matrix(t, order)) for b in own] for order in range(3))
    B = casadi.vertcat(*(casadi.diagcat(*matrices) for matrices in orders))
    begin, end = own[0].part.start, own[-1].part.stop
    rows = B.shape[0]
    B = casadi.horzcat(casadi.DM(rows, begin), B, casadi.DM(rows, space.size - end))
    return B, np.append(np.repeat(space.centre, len(t)), np.zeros(rows * 2 // 3))


def _motion(x: Any, n: int) -> dict[str, Any]:
    """Return the q, qd and qdd, (n, N) each, that `_basis` has joint by joint."""
    parts = casadi.vertsplit(x, x.numel() // 3)
    shaped = (casadi.reshape(part, part.numel() // n, n).T for part in parts)
    return dict(zip(("q", "qd", "qdd"), shaped, strict=True))


def _gram(derived: Model, space: Space, run: int, z: Any, model: str, window: float) -> Any:
    """Return W'W (p, p) of a run, for the equations of `identify` on a coarser grid.

    Energy: [h(t2) - h(t1), integral of f]; momentum: [p(t2) - p(t1) - integral of dL/dq, integral
    of F]; torque: the samples themselves.
    """
    n, length = len(space.centre), space.of(run)[0].basis.duration
    lines = 1 if model == "energy" else n  # equations of each sample
    enough = math.ceil(_ROWS * len(derived.base.names) / lines / space.runs)
    reach = 0.0 if model == "torque" else window
    step = min(length / (_PER_PERIOD * _fastest(space, run)), (length - reach) / enough)
    steps = 0
    if model != "torque":
        steps = max(4, math.ceil(window / step - 1e-9))
        step = window / steps
    count = int(length / step + 1e-9) + 1
    B, c = _basis(space, run, np.arange(count) * np.float64(step))
    motion = _motion(casadi.mtimes(B, z) + c, n)
    samples: list[Any] = []
    for kernel in filter(None, map(derived.kernel, NEEDED[model])):
        function = casadi_function(derived, kernel, flat=True).map(count)
        found = function(*(motion[name] for name, _ in kernel.tape.inputs))
        samples += found if isinstance(found, tuple) else [found]
    if model != "torque":
        identity = np.eye(count)
        integral = cumulative_integral(identity, step)
        D, S = (
            casadi.sparsify(casadi.DM((x[steps:] - x[:-steps]).T)) for x in (identity, integral)
        )
        first, *rates = samples
        samples = [casadi.mtimes(first, D), *(casadi.mtimes(x, S) for x in rates)]
        if model == "momentum":
            samples[:2] = [samples[0] - samples[1]]
    rows = zip(*(casadi.vertsplit(x, x.shape[0] // lines) for x in samples), strict=True)
    W = casadi.horzcat(*(casadi.vertcat(*row) for row in rows))
    return casadi.mtimes(W, W.T)


def _loss(G: Any, criterion: str) -> Any:
    """Return a smooth loss of W'W.

    "logdet" is -log det C. "condition" is the log of the condition number. Power means of order 6
    replace the extreme eigenvalues, which are not smooth if two are equal:

        (log tr C^6 + log tr C^-6) / 12

    Scaled columns do not distinguish a large motion from a small one, in which noise dominates. A
    small share of the mean log norm of the columns therefore favours large motions.
    """
    p = G.shape[0]
    norms = casadi.sqrt(casadi.fmax(casadi.diag(G), _SMALL))
    C = G / casadi.mtimes(norms, norms.T) + _FLOOR * casadi.DM.eye(p)
    if criterion == "logdet":
        symbols = casadi.SX.sym("C", p, p)
        R = casadi.diag(casadi.chol(symbols))
        value = -2 * casadi.Function("logdet", [symbols], [casadi.sum1(casadi.log(R))])(C)
    else:
        cubes = (casadi.mtimes([M, M, M]) for M in (C, casadi.inv(C, "ldl", {})))
        value = sum(casadi.log(casadi.sumsqr(M)) for M in cubes) / 12
    return value - _LARGE / p * casadi.sum1(casadi.log(norms))


def _torques(derived: Model, space: Space, run: int, z: Any, X: FloatArray) -> tuple[Any, Any]:
    """Return the torques of the prior model over their limits, and their derivatives in z.

    d tau/dz = (d tau/d(q, qd, qdd)) B, with the first factor from CasADi.
    """
    t = np.linspace(0, space.of(run)[0].basis.duration, _TORQUE_CHECKS * _fastest(space, run) + 1)
    B, c = _basis(space, run, t)
    x = casadi.MX.sym("x", B.shape[0])
    kernel = derived.kernel("inverse_dynamics")
    assert kernel is not None
    inverse = casadi_function(derived, kernel).map(len(t))
    tau = inverse(*_motion(x, len(space.centre)).values(), casadi.repmat(casadi.DM(X), 1, len(t)))
    shares = np.diag(1 / space.limits.torque)[np.isfinite(space.limits.torque)]
    tau = casadi.vec(casadi.mtimes(casadi.sparsify(casadi.DM(shares)), tau))
    function = casadi.Function("torques", [x], [tau, casadi.jacobian(tau, x)])
    values, slopes = function(casadi.mtimes(B, z) + c)
    return values, casadi.mtimes(slopes, B)


def _linear_limits(space: Space) -> tuple[Any, FloatArray, FloatArray]:
    """Return A, low and high of low <= A z <= high: limits over their size, on a grid."""
    blocks, low, high = [], [], []
    for b in space.blocks:
        t = np.linspace(0, b.basis.duration, _CHECKS * _fastest(space, b.run) + 1)
        own = []
        for order, least, most in space.limits_of(b):
            size = most if order else space.limits.half[b.joint]
            rows = b.matrix(t, order) / size
            moving = np.abs(rows).max(axis=1) > 1e-9  # at rest by construction: no constraint
            own.append(rows[moving])
            low.append(np.full(len(own[-1]), _MARGIN * least / size))
            high.append(np.full(len(own[-1]), _MARGIN * most / size))
        blocks.append(casadi.DM(np.concatenate(own)))
    return casadi.diagcat(*blocks), np.concatenate(low), np.concatenate(high)
