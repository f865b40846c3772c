"""The search for a motion: a nonlinear program over CasADi's emitted functions, solved by IPOPT.

The loss is the objective's. Limits of position, speed, acceleration and jerk are linear; torques of
the prior model are those of its emitted function, which CasADi differentiates.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import casadi
import numpy as np

from symgen.experiment.bounds import Bounds
from symgen.experiment.criterion import FloatArray
from symgen.experiment.objective import INPUTS, Objective, fastest
from symgen.experiment.space import Space

_CHECKS = 6  # samples of the limits in a period of the fastest term
_TORQUE_CHECKS = 4
_MARGIN = 0.985  # of a limit that holds between these samples


@dataclass
class Clock:
    """When a search has to stop: a time, or Ctrl-C."""

    end: float
    interrupted: bool = False
    begun: float = field(default_factory=time.perf_counter)

    @property
    def elapsed(self) -> float:
        """Seconds since the search began."""
        return time.perf_counter() - self.begun

    @property
    def left(self) -> float:
        """Seconds that are left; none after Ctrl-C."""
        return 0.0 if self.interrupted else self.end - self.elapsed

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Take Ctrl-C as the wish to stop, not as an error; only the main thread hears it."""
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


class _Function(casadi.Callback):
    """A function of z that knows its Jacobian, both in NumPy, as CasADi calls it.

    `at` returns the values (rows,) and the Jacobian (rows, size), which has the given sparsity.
    """

    def __init__(self, name: str, size: int, rows: int, pattern: Any) -> None:
        casadi.Callback.__init__(self)
        self.size, self.rows, self.pattern = size, rows, pattern
        self.kept: list[Any] = []
        self.last: tuple[bytes, tuple[FloatArray, FloatArray]] | None = None
        self.construct(name, {})

    def at(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        raise NotImplementedError

    def once(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return `at`, computed once for value and Jacobian."""
        key = z.tobytes()
        if self.last is None or self.last[0] != key:
            self.last = key, self.at(z)
        return self.last[1]

    def get_n_in(self) -> int:
        return 1

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, _: int) -> Any:
        return casadi.Sparsity.dense(self.size, 1)

    def get_sparsity_out(self, _: int) -> Any:
        return casadi.Sparsity.dense(self.rows, 1)

    def eval(self, given: Any) -> Any:
        return [casadi.DM(self.once(given[0].full()[:, 0])[0])]

    def has_jacobian(self, *_: object) -> bool:
        return True

    def get_jacobian(self, name: str, _in: Any, _out: Any, options: Any = None) -> Any:
        self.kept.append(_Jacobian(name, self, options))
        return self.kept[-1]


class _Jacobian(casadi.Callback):
    """The Jacobian of a `_Function`."""

    def __init__(self, name: str, function: _Function, options: Any) -> None:
        casadi.Callback.__init__(self)
        self.function = function
        self.construct(name, options)

    def get_n_in(self) -> int:
        return 2

    def get_n_out(self) -> int:
        return 1

    def get_sparsity_in(self, i: int) -> Any:
        return casadi.Sparsity.dense(self.function.rows if i else self.function.size, 1)

    def get_sparsity_out(self, _: int) -> Any:
        return self.function.pattern

    def eval(self, given: Any) -> Any:
        jacobian = self.function.once(given[0].full()[:, 0])[1]
        return [casadi.project(casadi.DM(jacobian), self.function.pattern)]


class _Loss(_Function):
    """The loss of the criterion."""

    def __init__(self, objective: Objective, criterion: str) -> None:
        self.objective, self.criterion = objective, criterion
        pattern = casadi.Sparsity.dense(1, objective.size)
        super().__init__("loss", objective.size, 1, pattern)

    def at(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        value, gradient = self.objective(z, self.criterion)
        return np.array([value]), gradient[None]


class Torques(_Function):
    """Torques of the prior model over their limits, sample by sample of a grid of their own.

    d tau/dz = sum over k of (d tau/d q^(k)) B^(k), with the first factor from CasADi.
    """

    def __init__(self, objective: Objective, limits: Bounds, X: FloatArray) -> None:
        space = objective.space
        self.space, self.X = space, X
        self.joints = np.flatnonzero(np.isfinite(limits.torque))
        self.allowed = limits.torque[self.joints]
        grids = [
            np.linspace(0, space.duration(run), _TORQUE_CHECKS * fastest(space, run) + 1)
            for run in range(space.runs)
        ]
        self.edges = np.cumsum([0, *(len(t) for t in grids)])
        self.matrices = [
            [b.matrix(grids[b.run], order) for order in range(3)] for b in space.blocks
        ]
        n, total = len(space.centre), int(self.edges[-1])
        q, qd, qdd = (casadi.SX.sym(name, n) for name in INPUTS)
        values = casadi.DM(X)
        tau = objective.inverse(q, qd, qdd, values)
        slope = casadi.jacobian(tau, casadi.vertcat(q, qd, qdd))
        dense = casadi.densify(slope)
        self.function = casadi.Function("torques", [q, qd, qdd], [tau, casadi.vec(dense)]).map(
            total
        )
        shown = np.zeros((total, len(self.joints), space.size))
        for b in space.blocks:
            shown[self.edges[b.run] : self.edges[b.run + 1], :, b.part] = 1
        rows = total * len(self.joints)
        pattern = casadi.sparsify(casadi.DM(shown.reshape(rows, -1))).sparsity()
        super().__init__("torques", space.size, rows, pattern)

    def at(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        n, total = len(self.space.centre), int(self.edges[-1])
        motion = np.zeros((3, n, total))
        motion[0] += self.space.centre[:, None]
        spans = [slice(self.edges[b.run], self.edges[b.run + 1]) for b in self.space.blocks]
        for b, span, matrices in zip(self.space.blocks, spans, self.matrices, strict=True):
            for order, B in enumerate(matrices):
                motion[order, b.joint, span] += B @ z[b.part]
        tau, slopes = self.function(*motion)
        # Column-major vec of (n, 3 n): the derivative's column comes first.
        cube = slopes.full().T.reshape(total, 3, n, n)[..., self.joints] / self.allowed
        out = np.zeros((total, len(self.joints), self.space.size))
        for b, span, matrices in zip(self.space.blocks, spans, self.matrices, strict=True):
            for order, B in enumerate(matrices):
                out[span, :, b.part] += cube[span, order, b.joint][:, :, None] * B[:, None, :]
        values = tau.full().T[:, self.joints] / self.allowed
        return values.ravel(), out.reshape(-1, self.space.size)


class _Watch(casadi.Callback):
    """Stops IPOPT when the clock says so."""

    def __init__(self, variables: int, constraints: int, clock: Clock) -> None:
        casadi.Callback.__init__(self)
        self.sizes = {"x": variables, "g": constraints, "lam_x": variables, "lam_g": constraints}
        self.clock = clock
        self.construct("watch", {})

    def get_n_in(self) -> int:
        return int(casadi.nlpsol_n_out())

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, i: int) -> str:
        return str(casadi.nlpsol_out(i))

    def get_sparsity_in(self, i: int) -> Any:
        name = casadi.nlpsol_out(i)
        size = 1 if name == "f" else self.sizes.get(name, 0)
        return casadi.Sparsity.dense(size, 1 if size else 0)

    def eval(self, _: Any) -> Any:
        return [int(self.clock.left <= 0)]


class Program:
    """The nonlinear program of one search; solved from many starts."""

    def __init__(
        self,
        objective: Objective,
        limits: Bounds,
        prior: FloatArray | None,
        clock: Clock,
        iterations: int,
    ) -> None:
        space = objective.space
        z = casadi.MX.sym("z", space.size)
        A, low, high = _linear_limits(space, limits)
        g, lower, upper = [casadi.mtimes(A, z)], [low], [high]
        self.torques = None
        if prior is not None:
            self.torques = Torques(objective, limits, prior)
            g.append(self.torques(z))
            edge = np.full(g[-1].numel(), _MARGIN)
            lower, upper = [*lower, -edge], [*upper, edge]
        self.lower, self.upper = np.concatenate(lower), np.concatenate(upper)
        constraints = casadi.vertcat(*g)
        self.watch = _Watch(space.size, constraints.numel(), clock)
        self.losses, self.solvers = {}, {}
        for criterion in ("logdet", "condition"):
            self.losses[criterion] = _Loss(objective, criterion)
            self.solvers[criterion] = casadi.nlpsol(
                criterion,
                "ipopt",
                {"x": z, "f": self.losses[criterion](z), "g": constraints},
                {
                    "print_time": False,
                    "error_on_fail": False,
                    "iteration_callback": self.watch,
                    "ipopt.print_level": 0,
                    "ipopt.sb": "yes",
                    "ipopt.hessian_approximation": "limited-memory",
                    "ipopt.limited_memory_max_history": 8,
                    "ipopt.limited_memory_aug_solver": "extended",
                    "ipopt.max_iter": iterations,
                    "ipopt.tol": 1e-4,
                    "ipopt.acceptable_tol": 1e-3,
                    "ipopt.acceptable_obj_change_tol": 1e-4,
                    "ipopt.mu_strategy": "monotone",
                    "ipopt.mu_init": 1e-2,
                },
            )

    def solve(self, z: FloatArray, criterion: str) -> FloatArray:
        """Return the z that IPOPT reaches from a start; the clock may stop it on the way."""
        result = self.solvers[criterion](x0=z, lbg=self.lower, ubg=self.upper)
        found: FloatArray = result["x"].full()[:, 0]
        return found if np.isfinite(found).all() else z


def _linear_limits(space: Space, limits: Bounds) -> tuple[Any, FloatArray, FloatArray]:
    """Return A, low and high of low <= A z <= high: limits over their size, on a grid."""
    rows, low, high = [], [], []
    for b in space.blocks:
        count = _CHECKS * fastest(space, b.run) + 1
        t = np.linspace(0, b.basis.duration, count)
        j, own = b.joint, []
        room = np.array([limits.low[j], limits.high[j]]) - space.centre[j]
        own.append((b.matrix(t, 0) / limits.half[j], *(room / limits.half[j] * _MARGIN)))
        for order in (1, 2, 3):
            allowed = limits.rates[order - 1, j]
            if np.isfinite(allowed):
                own.append((b.matrix(t, order) / allowed, -_MARGIN, _MARGIN))
        for B, a, c in own:
            moving = np.abs(B).max(axis=1) > 1e-9  # at rest by construction: no constraint
            dense = np.zeros((int(moving.sum()), b.part.stop - b.part.start))
            dense[:] = B[moving]
            before = casadi.DM(len(dense), b.part.start)
            after = casadi.DM(len(dense), space.size - b.part.stop)
            rows.append(casadi.horzcat(before, casadi.DM(dense), after))
            low.append(np.full(len(dense), a))
            high.append(np.full(len(dense), c))
    return casadi.vertcat(*rows), np.concatenate(low), np.concatenate(high)
