"""The kernels as methods of an evaluator; `python tests/forms.py` writes this file."""

from numpy.typing import ArrayLike

from symgen.data.raw import FloatArray

class KernelMethods:
    """Every kernel as a method, `evaluator.mass_matrix(q, X)`."""

    def energy_regressor(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """Columns DE + DU of kinetic plus potential energy: E + U = out . X.

        Inputs: q (n,), qd (n,), and g (3,) if gravity is an input of the robot.
        Outputs: out (p_inertial,).

        Floating base: Columns DE of kinetic energy: E = out . X.

        Inputs: q (n,), qd (n,), v (3,), w (3,).
        Outputs: out (p_inertial,).
        """

    def friction_power(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """Columns of the power that friction takes: P = out . X[p_inertial..p).

        Inputs: q (n,), qd (n,).
        Outputs: out (p - p_inertial,).

        Floating base: Columns of the power that friction takes: P = out . X[p_inertial..p).

        Inputs: q (n,), qd (n,).
        Outputs: out (p - p_inertial,).
        """

    def friction_torque(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """Columns of friction torque: out X[p_inertial..p).

        Inputs: q (n,), qd (n,).
        Outputs: out (n, p - p_inertial).

        Floating base: Columns of friction torque: out X[p_inertial..p).

        Inputs: q (n,), qd (n,).
        Outputs: out (n, p - p_inertial).
        """

    def power_regressor(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """Columns of power: qd' tau = out . X, the rate of energy plus friction.

        Inputs: q (n,), qd (n,), qdd (n,), and g (3,) if gravity is an input of the robot.
        Outputs: out (p,).

        Floating base: Columns of power: wrench . (v, w) + qd' tau = out . X.

        Inputs: q (n,), qd (n,), qdd (n,), f (3,), v (3,), w (3,), wd (3,).
        Outputs: out (p,).
        """

    def momentum_regressor(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> tuple[FloatArray, ...]:
        """Columns of p = dT/dqd and of dL/dq: dp/dt = tau - friction + dL/dq.

        Inputs: q (n,), qd (n,), and g (3,) if gravity is an input of the robot.
        Outputs: p_out (m, p_inertial), dl_out (m, p_inertial).

        Floating base: Columns of the momentum p and of its rate: dp/dt = (wrench, tau -
        friction) + rate.

        Inputs: q (n,), qd (n,), v (3,), w (3,).
        Outputs: p_out (m, p_inertial), dl_out (m, p_inertial).
        """

    def torque_regressor(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """Columns of torque: tau = out X, friction included.

        Inputs: q (n,), qd (n,), qdd (n,), and g (3,) if gravity is an input of the robot, or f
        (3,), w (3,), wd (3,) if its base has an IMU.
        Outputs: out (m, p).

        Floating base: Columns of wrench and torque: (wrench, tau) = out X, friction included.

        Inputs: q (n,), qd (n,), qdd (n,), f (3,), w (3,), wd (3,).
        Outputs: out (m, p).
        """

    def inverse_dynamics(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        X: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """Torque of a motion: tau = M qdd + C qd + g + friction.

        Inputs: q (n,), qd (n,), qdd (n,), X (p,), and g (3,) if gravity is an input of the
        robot, or f (3,), w (3,), wd (3,) if its base has an IMU.
        Outputs: tau (m,).

        Floating base: Wrench on the base and torque of a motion: M (f, wd, qdd) + bias_torque.

        Inputs: q (n,), qd (n,), qdd (n,), X (p,), f (3,), w (3,), wd (3,).
        Outputs: tau (m,).
        """

    def mass_matrix(self, q: ArrayLike, X: ArrayLike) -> FloatArray:
        """Mass matrix M(q).

        Inputs: q (n,), X (p_inertial,).
        Outputs: M (m, m).

        Floating base: Mass matrix M(q): rows of the wrench and of tau, columns of f, wd and
        qdd.

        Inputs: q (n,), X (p_inertial,).
        Outputs: M (m, m).
        """

    def gravity_torque(
        self,
        q: ArrayLike,
        X: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """Torque of gravity on the links, without springs and friction.

        Inputs: q (n,), X (p_inertial,), and g (3,) if gravity is an input of the robot, or f
        (3,), w (3,), wd (3,) if its base has an IMU.
        Outputs: tau (m,).

        Floating base: Wrench on the base and torque of the specific force f on the links,
        without springs and friction.

        Inputs: q (n,), X (p_inertial,), f (3,).
        Outputs: tau (m,).
        """

    def coriolis(self, q: ArrayLike, qd: ArrayLike, X: ArrayLike) -> FloatArray:
        """C(q, qd) with C qd the Coriolis torques and dM/dt - 2 C skew-symmetric.

        Inputs: q (n,), qd (n,), X (p_inertial,).
        Outputs: C (n, n).
        """

    def bias_torque(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        X: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """H = C qd + g + friction.

        Inputs: q (n,), qd (n,), X (p,), and g (3,) if gravity is an input of the robot, or f
        (3,), w (3,), wd (3,) if its base has an IMU.
        Outputs: h (m,).

        Floating base: H = C qd + friction: M (f, wd, qdd) + h = (wrench, tau).

        Inputs: q (n,), qd (n,), X (p,), w (3,).
        Outputs: h (m,).
        """

    def forward_dynamics(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        tau: ArrayLike,
        X: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """Accelerations under torques tau; not 0 where M is not positive definite.

        Inputs: q (n,), qd (n,), tau (n,), X (p,), and g (3,) if gravity is an input of the
        robot, or f (3,), w (3,), wd (3,) if its base has an IMU.
        Outputs: qdd (n,).

        Floating base: Accelerations of joints and base under torques tau and a wrench on the
        base; not 0 where M is not positive definite.

        Inputs: q (n,), qd (n,), tau (n,), X (p,), w (3,), wrench (6,).
        Outputs: qdd (n,), f (3,), wd (3,).
        """

    def energy(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        X: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> tuple[FloatArray, ...]:
        """Kinetic energy T and potential energy U, U up to a constant.

        Inputs: q (n,), qd (n,), X (p_inertial,), and g (3,) if gravity is an input of the
        robot.
        Outputs: T_out (1,), U_out (1,).

        Floating base: Kinetic energy T.

        Inputs: q (n,), qd (n,), X (p_inertial,), v (3,), w (3,).
        Outputs: T_out (1,).
        """

    def frames(self, q: ArrayLike) -> FloatArray:
        """Homogeneous transforms 0T_j of all links, fixed ones included.

        Inputs: q (n,).
        Outputs: T_out (links, 4, 4).

        Floating base: Homogeneous transforms 0T_j of all links, fixed ones included.

        Inputs: q (n,).
        Outputs: T_out (links, 4, 4).
        """

    def jacobian(self, q: ArrayLike) -> FloatArray:
        """Jacobian of the last frame that moves, in frame 0: rows of velocity, then of turning.

        Inputs: q (n,).
        Outputs: J_out (6, m).

        Floating base: Jacobian of the last frame that moves, in frame 0: rows of velocity, then
        of turning; columns of v, w and qd.

        Inputs: q (n,).
        Outputs: J_out (6, m).
        """

    def slotine_li_regressor(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdr: ArrayLike,
        qddr: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """Columns of M qddr + C(q, qd) qdr + g + friction(qd) = out X, C of Christoffel's symbols.

        Inputs: q (n,), qd (n,), qdr (n,), qddr (n,), and g (3,) if gravity is an input of the
        robot.
        Outputs: out (n, p).
        """

    def slotine_li_torque(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdr: ArrayLike,
        qddr: ArrayLike,
        X: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """M qddr + C(q, qd) qdr + g + friction(qd), C of Christoffel's symbols.

        Inputs: q (n,), qd (n,), qdr (n,), qddr (n,), X (p,), and g (3,) if gravity is an input
        of the robot.
        Outputs: tau (n,).
        """

    def generalized_momentum(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        X: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> tuple[FloatArray, ...]:
        """P = M qd and rate = C' qd - g: dp/dt = tau - friction + rate.

        Inputs: q (n,), qd (n,), X (p_inertial,), and g (3,) if gravity is an input of the
        robot.
        Outputs: p_out (m,), rate_out (m,).

        Floating base: P = M (v, w, qd) and its rate: dp/dt = (wrench, tau - friction) + rate.

        Inputs: q (n,), qd (n,), X (p_inertial,), v (3,), w (3,).
        Outputs: p_out (m,), rate_out (m,).
        """

    def centroidal_momentum(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        X: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> tuple[FloatArray, ...]:
        """Momentum of the robot about its centre of mass, linear and angular, and the centre of
        mass, in frame 0.

        Inputs: q (n,), qd (n,), X (p_inertial,).
        Outputs: h_out (6,), com_out (3,).

        Floating base: Momentum of the robot about its centre of mass, linear and angular, and
        the centre of mass, in frame 0.

        Inputs: q (n,), qd (n,), X (p_inertial,), v (3,), w (3,).
        Outputs: h_out (6,), com_out (3,).
        """

    def friction(self, qd: ArrayLike, X: ArrayLike) -> FloatArray:
        """Torque of the friction that joints and couplings declare; effects are not in it.

        Inputs: qd (n,), X (p,).
        Outputs: tau (n,).

        Floating base: Torque of the friction that joints and couplings declare; effects are not
        in it.

        Inputs: qd (n,), X (p,).
        Outputs: tau (n,).
        """

    def effects(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        X: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """Torque of the declared effects; with friction and the rigid body it is inverse_dynamics.

        Inputs: q (n,), qd (n,), qdd (n,), X (p,), and g (3,) if gravity is an input of the
        robot, or f (3,), w (3,), wd (3,) if its base has an IMU.
        Outputs: tau (n,).

        Floating base: Torque of the declared effects; with friction and the rigid body it is
        inverse_dynamics.

        Inputs: q (n,), qd (n,), qdd (n,), X (p,), f (3,), w (3,), wd (3,).
        Outputs: tau (n,).
        """

    def inverse_dynamics_derivatives(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        X: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> tuple[FloatArray, ...]:
        """Dtau/dq and dtau/dqd; dtau/dqdd is mass_matrix; the derivative of sign(qd) is 0.

        Inputs: q (n,), qd (n,), qdd (n,), X (p,), and g (3,) if gravity is an input of the
        robot, or f (3,), w (3,), wd (3,) if its base has an IMU.
        Outputs: dq_out (n, n), dqd_out (n, n).

        Floating base: D(wrench, tau)/dq, by qd and by w; by f, wd and qdd they are mass_matrix;
        the derivative of sign(qd) is 0.

        Inputs: q (n,), qd (n,), qdd (n,), X (p,), f (3,), w (3,), wd (3,).
        Outputs: dq_out (m, n), dqd_out (m, n), dw_out (m, 3).
        """

    def forward_dynamics_derivatives(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        tau: ArrayLike,
        X: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> tuple[FloatArray, ...]:
        """Dqdd/dq, dqdd/dqd and dqdd/dtau; the derivative of sign(qd) is 0.

        Inputs: q (n,), qd (n,), tau (n,), X (p,), and g (3,) if gravity is an input of the
        robot, or f (3,), w (3,), wd (3,) if its base has an IMU.
        Outputs: dq_out (n, n), dqd_out (n, n), dtau_out (n, n).

        Floating base: D(f, wd, qdd)/dq, by qd, by (wrench, tau) and by w; the derivative of
        sign(qd) is 0.

        Inputs: q (n,), qd (n,), tau (n,), X (p,), w (3,), wrench (6,).
        Outputs: dq_out (m, n), dqd_out (m, n), dtau_out (m, m), dw_out (m, 3).
        """

    def solve_mass_matrix(self, q: ArrayLike, b: ArrayLike, X: ArrayLike) -> FloatArray:
        """X of M(q) x = b.

        Inputs: q (n,), b (m,), X (p_inertial,).
        Outputs: x (m,).

        Floating base: X of M(q) x = b.

        Inputs: q (n,), b (m,), X (p_inertial,).
        Outputs: x (m,).
        """

    def mass_matrix_factor(self, q: ArrayLike, X: ArrayLike) -> tuple[FloatArray, ...]:
        """M = L D L' with ones on the diagonal of L and zeros below it; for projections solve with
        L from its last row.

        Inputs: q (n,), X (p_inertial,).
        Outputs: L_out (m, m), D_out (m,).

        Floating base: M = L D L' with ones on the diagonal of L and zeros below it; for
        projections solve with L from its last row.

        Inputs: q (n,), X (p_inertial,).
        Outputs: L_out (m, m), D_out (m,).
        """

    def link_jacobian(self, q: ArrayLike, link: ArrayLike, point: ArrayLike) -> FloatArray:
        """Jacobian, in frame 0, of a point in the frame of a link: velocity, then turning.

        Inputs: q (n,), link, point (3,).
        Outputs: J (6, m).

        Floating base: Jacobian, in frame 0, of a point in the frame of a link: velocity, then
        turning; columns of v, w and qd.

        Inputs: q (n,), link, point (3,).
        Outputs: J (6, m).
        """

    def link_drift(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        link: ArrayLike,
        point: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """DJ/dt qd of a point in the frame of a link: its acceleration without qdd, in frame 0.

        Inputs: q (n,), qd (n,), link, point (3,).
        Outputs: a (6,).

        Floating base: Specific force and angular acceleration, in frame 0, of a point in the
        frame of a link, less link_jacobian (f, wd, qdd).

        Inputs: q (n,), qd (n,), link, point (3,), w (3,).
        Outputs: a (6,).
        """

    def tool_wrench(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        load: ArrayLike,
        offset: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """Wrench of the arm on a tool behind the [sensor]: force, and moment about the origin of
        its frame, in its axes; load is XX XY XZ YY YZ ZZ MX MY MZ M of the tool in this frame.

        Inputs: q (n,), qd (n,), qdd (n,), load (10,), offset (6,), and g (3,) if gravity is an
        input of the robot.
        Outputs: w (6,).
        """

    def base_parameters(self, standard: ArrayLike) -> FloatArray:
        """X from the standard parameters, in this order: model.base.standard.

        Inputs: standard (s,).
        Outputs: X (p,).

        Floating base: X from the standard parameters, in this order: model.base.standard.

        Inputs: standard (s,).
        Outputs: X (p,).
        """

    def add_body(
        self,
        X: ArrayLike,
        link: ArrayLike,
        mass: ArrayLike,
        com: ArrayLike,
        inertia: ArrayLike,
    ) -> FloatArray:
        """Fix a body on a link, in X: its mass, the centre of mass in the frame of the link, and
        inertia XX XY XZ YY YZ ZZ about that; mass and inertia negative: take it off.

        Inputs: X (p,), link, mass, com (3,), inertia (6,).
        Outputs: X (p,).

        Floating base: Fix a body on a link, in X: its mass, the centre of mass in the frame of
        the link, and inertia XX XY XZ YY YZ ZZ about that; mass and inertia negative: take it
        off.

        Inputs: X (p,), link, mass, com (3,), inertia (6,).
        Outputs: X (p,).
        """

    def standard_energy_regressor(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> tuple[FloatArray, ...]:
        """Columns DE and DU of kinetic and of potential energy in every standard parameter.

        Inputs: q (n,), qd (n,), and g (3,) if gravity is an input of the robot.
        Outputs: kinetic_out (s_inertial,), potential_out (s_inertial,).

        Floating base: Columns DE of kinetic energy in every standard parameter.

        Inputs: q (n,), qd (n,), v (3,), w (3,).
        Outputs: kinetic_out (s_inertial,).
        """

    def standard_torque_regressor(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> FloatArray:
        """Columns of torque in every standard parameter, friction included.

        Inputs: q (n,), qd (n,), qdd (n,), and g (3,) if gravity is an input of the robot, or f
        (3,), w (3,), wd (3,) if its base has an IMU.
        Outputs: out (m, s).

        Floating base: Columns of wrench and torque in every standard parameter, friction
        included.

        Inputs: q (n,), qd (n,), qdd (n,), f (3,), w (3,), wd (3,).
        Outputs: out (m, s).
        """

    def load_momentum(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *base: ArrayLike,
        **named: ArrayLike,
    ) -> tuple[FloatArray, ...]:
        """Columns of p = dT/dqd and of dL/dq of a load on the link of [payload], or on the last
        moving link.

        Inputs: q (n,), qd (n,), and g (3,) if gravity is an input of the robot.
        Outputs: p_out (n, 10), dl_out (n, 10).
        """

    def add_load(self, X: ArrayLike, load: ArrayLike) -> FloatArray:
        """X with this load: its XX XY XZ YY YZ ZZ MX MY MZ M in the frame of that link, about its
        origin.

        Inputs: X (p,), load (10,).
        Outputs: loaded (p,).

        Floating base: X with this load: its XX XY XZ YY YZ ZZ MX MY MZ M in the frame of that
        link, about its origin.

        Inputs: X (p,), load (10,).
        Outputs: loaded (p,).
        """
