"""The kernels of a model as methods, with the names, arguments and results of the contract.

Every method takes one sample, arrays (n,), or N of them, (N, n), and X (p,), which all share; where
gravity is an input, g (3,) comes last. What a method returns of N samples has a first axis N.
A kernel that the model was derived without is a ParameterError that says which it has.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from symgen.runtime.calls import FloatArray, checked


class KernelMethods:
    """What an evaluator computes."""

    def __getitem__(self, name: str) -> Any:
        """Return a kernel by its name."""
        raise NotImplementedError

    def has(self, name: str) -> bool:
        """Whether the model was derived with this kernel."""
        raise NotImplementedError

    def friction_power(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """Columns (p - p_inertial,) of the power of friction, W; none for a robot without it."""
        if not self.has("friction_power"):
            arrays, _ = checked(self["energy_regressor"].kernel, (q, qd))
            return np.zeros((*arrays[0].shape[:-1], 0))
        return np.asarray(self["friction_power"](q, qd))

    def energy_regressor(self, q: ArrayLike, qd: ArrayLike, *g: ArrayLike) -> FloatArray:
        """h = DE + DU (p_inertial,): total energy is h . X[:p_inertial], J, up to a constant."""
        found: FloatArray = self["energy_regressor"](q, qd, *g)
        return found

    def power_regressor(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *g: ArrayLike
    ) -> FloatArray:
        """Columns (p,) of power, W: qd' tau = out . X, the rate of energy plus friction."""
        found: FloatArray = self["power_regressor"](q, qd, qdd, *g)
        return found

    def momentum_regressor(
        self, q: ArrayLike, qd: ArrayLike, *g: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """dT/dqd and dL/dq, (n, p_inertial) each: d/dt(dT/dqd) = tau - friction + dL/dq."""
        found: tuple[FloatArray, FloatArray] = self["momentum_regressor"](q, qd, *g)
        return found

    def torque_regressor(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *g: ArrayLike
    ) -> FloatArray:
        """Columns (n, p) of torque, friction included: tau = out X."""
        found: FloatArray = self["torque_regressor"](q, qd, qdd, *g)
        return found

    def friction_torque(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """Columns (n, p - p_inertial) of friction torque: out X[p_inertial:]."""
        found: FloatArray = self["friction_torque"](q, qd)
        return found

    def inverse_dynamics(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, X: ArrayLike, *g: ArrayLike
    ) -> FloatArray:
        """tau = M qdd + C qd + g + friction, (n,), N m or N."""
        found: FloatArray = self["inverse_dynamics"](q, qd, qdd, X, *g)
        return found

    def mass_matrix(self, q: ArrayLike, X: ArrayLike) -> FloatArray:
        """M(q), (n, n), kg m2 (kg where prismatic)."""
        found: FloatArray = self["mass_matrix"](q, X)
        return found

    def gravity_torque(self, q: ArrayLike, X: ArrayLike, *g: ArrayLike) -> FloatArray:
        """The torque (n,) that holds the arm at rest, without friction."""
        found: FloatArray = self["gravity_torque"](q, X, *g)
        return found

    def coriolis(self, q: ArrayLike, qd: ArrayLike, X: ArrayLike) -> FloatArray:
        """C(q, qd), (n, n): C qd are the Coriolis torques, and dM/dt - 2 C is skew-symmetric."""
        found: FloatArray = self["coriolis"](q, qd, X)
        return found

    def bias_torque(self, q: ArrayLike, qd: ArrayLike, X: ArrayLike, *g: ArrayLike) -> FloatArray:
        """h = C qd + g + friction, (n,)."""
        found: FloatArray = self["bias_torque"](q, qd, X, *g)
        return found

    def forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, X: ArrayLike, *g: ArrayLike
    ) -> FloatArray:
        """Accelerations (n,) under torques; a ParameterError where M is not positive definite."""
        found: FloatArray = self["forward_dynamics"](q, qd, tau, X, *g)
        return found

    def energy(
        self, q: ArrayLike, qd: ArrayLike, X: ArrayLike, *g: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """Kinetic and potential energy, (1,) each, J; the latter up to a constant."""
        found: tuple[FloatArray, FloatArray] = self["energy"](q, qd, X, *g)
        return found

    def frames(self, q: ArrayLike) -> FloatArray:
        """Transforms 0T_j (links, 4, 4), fixed links included."""
        found: FloatArray = self["frames"](q)
        return found

    def jacobian(self, q: ArrayLike) -> FloatArray:
        """Jacobian (6, n) of the last frame that moves, in frame 0: velocity, then turning."""
        found: FloatArray = self["jacobian"](q)
        return found

    def all_terms(
        self, q: ArrayLike, qd: ArrayLike, X: ArrayLike, *g: ArrayLike
    ) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
        """M, h, gravity torque, Jacobian and frames in one call, which turns each angle once."""
        found: tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray] = self[
            "all_terms"
        ](q, qd, X, *g)
        return found

    def slotine_li_regressor(
        self, q: ArrayLike, qd: ArrayLike, qdr: ArrayLike, qddr: ArrayLike, *g: ArrayLike
    ) -> FloatArray:
        """Columns (n, p) of M qddr + C(q, qd) qdr + g + friction(qd)."""
        found: FloatArray = self["slotine_li_regressor"](q, qd, qdr, qddr, *g)
        return found

    def slotine_li_torque(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdr: ArrayLike,
        qddr: ArrayLike,
        X: ArrayLike,
        *g: ArrayLike,
    ) -> FloatArray:
        """M qddr + C(q, qd) qdr + g + friction(qd), (n,), C of Christoffel's symbols."""
        found: FloatArray = self["slotine_li_torque"](q, qd, qdr, qddr, X, *g)
        return found

    def generalized_momentum(
        self, q: ArrayLike, qd: ArrayLike, X: ArrayLike, *g: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """p = M qd and rate = C' qd - g, (n,) each: dp/dt = tau - friction + rate."""
        found: tuple[FloatArray, FloatArray] = self["generalized_momentum"](q, qd, X, *g)
        return found

    def friction(self, qd: ArrayLike, X: ArrayLike) -> FloatArray:
        """Torque (n,) of the friction that joints and couplings declare; effects are not in it."""
        found: FloatArray = self["friction"](qd, X)
        return found

    def inverse_dynamics_derivatives(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, X: ArrayLike, *g: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """dtau/dq and dtau/dqd, (n, n) each; dtau/dqdd is `mass_matrix`."""
        found: tuple[FloatArray, FloatArray] = self["inverse_dynamics_derivatives"](
            q, qd, qdd, X, *g
        )
        return found

    def forward_dynamics_derivatives(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, X: ArrayLike, *g: ArrayLike
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """dqdd/dq, dqdd/dqd and dqdd/dtau, (n, n) each."""
        found: tuple[FloatArray, FloatArray, FloatArray] = self["forward_dynamics_derivatives"](
            q, qd, tau, X, *g
        )
        return found

    def solve_mass_matrix(self, q: ArrayLike, b: ArrayLike, X: ArrayLike) -> FloatArray:
        """x (n,) of M(q) x = b; a ParameterError where M is not positive definite."""
        found: FloatArray = self["solve_mass_matrix"](q, b, X)
        return found

    def mass_matrix_factor(self, q: ArrayLike, X: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """L (n, n) and the diagonal D (n,) of M = L D L'."""
        found: tuple[FloatArray, FloatArray] = self["mass_matrix_factor"](q, X)
        return found

    def link_jacobian(self, q: ArrayLike, link: int, point: ArrayLike) -> FloatArray:
        """Jacobian (6, n), in frame 0, of a point (3,) in the frame of a link, by its number."""
        found: FloatArray = self["link_jacobian"](q, link, point)
        return found

    def link_drift(self, q: ArrayLike, qd: ArrayLike, link: int, point: ArrayLike) -> FloatArray:
        """dJ/dt qd (6,) of such a point: its acceleration without qdd."""
        found: FloatArray = self["link_drift"](q, qd, link, point)
        return found

    def base_parameters(self, standard: ArrayLike) -> FloatArray:
        """X (p,) from the standard parameters, in the order of `model.base.standard`."""
        found: FloatArray = self["base_parameters"](standard)
        return found

    def add_body(
        self, X: ArrayLike, link: int, mass: float, com: ArrayLike, inertia: ArrayLike
    ) -> FloatArray:
        """X (p,) with a body fixed on a link; inertia XX XY XZ YY YZ ZZ about com (3,)."""
        found: FloatArray = self["add_body"](X, link, mass, com, inertia)
        return found

    def standard_energy_regressor(
        self, q: ArrayLike, qd: ArrayLike, *g: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """DE and DU of every standard parameter."""
        found: tuple[FloatArray, FloatArray] = self["standard_energy_regressor"](q, qd, *g)
        return found

    def standard_torque_regressor(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *g: ArrayLike
    ) -> FloatArray:
        """Columns of torque in every standard parameter, friction included."""
        found: FloatArray = self["standard_torque_regressor"](q, qd, qdd, *g)
        return found
