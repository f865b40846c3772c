"""Kernels for control and changes at run time, on random arms: Pinocchio, and 50 digits."""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import replace
from functools import cache, cached_property

import mpmath
import numpy as np
import pytest
from oracles.following import following_arm
from oracles.random_arms import random_arm, random_parameters
from oracles.transforms import parameter_vector, world_transforms
from support import parsed, robot_of, sampled

import symgen
from symgen.codegen.kernels import regrouped
from symgen.codegen.verification import evaluate, physical_parameters

# From 100 on, some joints follow others; prismatic and fixed joints and trees are among all.
SEEDS = [*sampled(range(24), 3), *sampled(range(100, 116), 2)]
KERNELS = (
    "slotine_li_regressor",
    "slotine_li_torque",
    "generalized_momentum",
    "friction",
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
    "solve_mass_matrix",
    "mass_matrix_factor",
    "all_terms",
    "link_jacobian",
    "link_drift",
    "base_parameters",
    "add_body",
    "standard_energy_regressor",
    "standard_torque_regressor",
)
OLD = ("inverse_dynamics", "forward_dynamics", "torque_regressor")
TERMS = ("mass_matrix", "bias_torque", "gravity_torque", "jacobian", "frames")


class Case:
    """One random arm with physical parameters, a state, and Pinocchio beside it."""

    def __init__(self, seed: int) -> None:
        self.friction = ("coulomb", "viscous", "offset")
        if seed < 100:
            self.arm = random_arm(seed, max_joints=6)
            self.G, self.c = np.eye(self.arm.n), np.zeros(self.arm.n)
            self.robot, self.flags = robot_of(self.arm, self.friction, True), True
        else:
            chosen = following_arm(seed)
            self.arm, self.G, self.c = chosen.arm, chosen.G, chosen.c
            words = ", ".join(f'"{word}"' for word in self.friction)
            text = chosen.text.replace('["coulomb", "viscous"]', f"[{words}]")
            self.robot, self.flags = parsed(text), chosen.rotors()
        self.model = symgen.derive(self.robot, (*OLD, *TERMS, *KERNELS, "energy_regressor"))
        self.evaluator = symgen.load(self.model, backend="casadi")
        self.links, self.rotors = random_parameters(self.arm, seed)
        draw = np.random.default_rng(seed)
        own = np.array([self.flags is True or self.flags[j - 1] for j in self.arm.movable])
        self.witness_rotors = self.rotors * own
        self.rest = draw.uniform(0.1, 1, 99)
        self.X, self.standard = self.parameters(self.links)
        # The same robot without friction, for Pinocchio.
        bare = [
            0.0 if not p.inertial else x
            for p, x in zip(self.model.base.standard, self.standard, strict=True)
        ]
        self.bare = np.array(regrouped(self.model.base, bare, self.robot.values()))
        self.q, self.qd, self.qdd, self.b = draw.uniform(-1, 1, (4, self.robot.n))

    def parameters(self, links: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Base and standard parameters of the arm with these links."""
        inertial = parameter_vector(self.arm, links, self.rotors, self.flags)
        count = len(self.model.base.standard) - len(inertial)
        standard = np.array([*inertial, *self.rest[:count]])
        return np.array(regrouped(self.model.base, standard, self.robot.values())), standard

    @cached_property
    def witness(self):
        pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
        from oracles.pinocchio_arm import PinocchioArm

        return PinocchioArm(self.arm, self.links, self.witness_rotors)

    def mass(self, q: np.ndarray) -> np.ndarray:
        """Pinocchio's mass matrix over the joints' own variables."""
        return self.G.T @ self.witness.mass_matrix(self.G @ q + self.c) @ self.G

    def weight(self, q: np.ndarray) -> np.ndarray:
        still = np.zeros(len(self.c))
        return self.G.T @ self.witness.inverse_dynamics(self.G @ q + self.c, still, still)

    @property
    def apart(self) -> list[int]:
        """Movable joints whose gravity and friction X keeps apart.

        OF of a first prismatic joint takes its weight into it: IA4R = IA4 + M4, OF4R = OF4 - g M4.
        """
        mixed = {p.name for p in self.model.base.parameters if p.name.startswith("OF") and p.terms}
        return [i for i, j in enumerate(self.robot.movable) if f"OF{j.number}R" not in mixed]

    def __call__(self, kernel: str, *inputs):
        return self.evaluator[kernel](*inputs)


@cache
def case(seed: int) -> Case:
    return Case(seed)


def _close(a, b, tolerance: float = 1e-10) -> None:
    np.testing.assert_allclose(a, b, atol=tolerance * (1 + np.abs(b).max(initial=0.0)), rtol=0)


def christoffel(c: Case) -> np.ndarray:
    """C of Christoffel's symbols, from differences of Pinocchio's mass matrix."""
    n, h = len(c.q), 1e-6
    slope = np.array([(c.mass(c.q + s) - c.mass(c.q - s)) / (2 * h) for s in h * np.eye(n)])
    symbols = slope.transpose(1, 2, 0) + slope.transpose(1, 0, 2) - slope
    return 0.5 * np.einsum("ijk,k->ij", symbols, c.qd)


@pytest.mark.parametrize("seed", SEEDS)
def test_slotine_li_is_the_motion_of_the_reference_with_christoffels_matrix(seed: int) -> None:
    c = case(seed)
    qdr, qddr = c.qdd, c.b
    expected = c.mass(c.q) @ qddr + christoffel(c) @ qdr + c.weight(c.q)
    _close(c("slotine_li_torque", c.q, c.qd, qdr, qddr, c.bare), expected, 1e-7)
    columns = c("slotine_li_regressor", c.q, c.qd, qdr, qddr)
    torque = c("slotine_li_torque", c.q, c.qd, qdr, qddr, c.X)
    _close(columns @ c.X, torque)
    rigid = columns[:, : c.model.inertial] @ c.X[: c.model.inertial]
    _close(rigid + c("friction", c.qd, c.X), torque)
    same = c("slotine_li_torque", c.q, c.qd, c.qd, c.qdd, c.X)
    _close(same, c("inverse_dynamics", c.q, c.qd, c.qdd, c.X))


@pytest.mark.parametrize("seed", SEEDS)
def test_momentum_and_its_rate(seed: int) -> None:
    c = case(seed)
    p, rate = c("generalized_momentum", c.q, c.qd, c.X)
    _close(p, c.mass(c.q) @ c.qd)
    _close(rate[c.apart], (christoffel(c).T @ c.qd - c.weight(c.q))[c.apart], 1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_friction_is_what_is_declared(seed: int) -> None:
    c = case(seed)
    value = dict(zip((p.name for p in c.model.base.standard), c.standard, strict=True))
    numbers = [j.number for j in c.robot.movable]
    expected = [
        value.get(f"FS{j}", 0) * np.sign(v) + value.get(f"FV{j}", 0) * v + value.get(f"OF{j}", 0)
        for j, v in zip(numbers, c.qd, strict=True)
    ]
    _close(c("friction", c.qd, c.X)[c.apart], np.array(expected)[c.apart])


def slopes(c: Case, kernel: str, point: Mapping[str, list[float]], by: str) -> np.ndarray:
    """Central differences with 50 digits, exact to far more than a double."""
    made = c.model.kernel(kernel)
    columns = []
    for k in range(len(c.q)):
        ends = []
        for sign in (1, -1):
            moved = {name: list(values) for name, values in point.items()}
            moved[by][k] = Shifted(moved[by][k], sign)
            ends.append(evaluate(made, c.model, moved, 50))
        columns.append(
            [float((a - b) / (2 * mpmath.mpf("1e-18"))) for a, b in zip(*ends, strict=True)]
        )
    return np.array(columns).T


class Shifted(float):
    """A number that is written with 1e-18 more or less."""

    def __new__(cls, value: float, sign: int) -> Shifted:
        made = super().__new__(cls, value)
        made.sign = sign
        return made

    def __repr__(self) -> str:
        with mpmath.workdps(60):
            return mpmath.nstr(
                mpmath.mpf(float.__repr__(self)) + self.sign * mpmath.mpf("1e-18"), 50
            )


def point_of(**inputs) -> dict[str, list[float]]:
    return {name: [float(x) for x in values] for name, values in inputs.items()}


@pytest.mark.parametrize("seed", SEEDS)
def test_derivatives_of_inverse_dynamics_are_slopes_with_50_digits(seed: int) -> None:
    c = case(seed)
    by_q, by_qd = c("inverse_dynamics_derivatives", c.q, c.qd, c.qdd, c.X)
    point = point_of(q=c.q, qd=c.qd, qdd=c.qdd, X=c.X)
    _close(by_q, slopes(c, "inverse_dynamics", point, "q"), 1e-12)
    _close(by_qd, slopes(c, "inverse_dynamics", point, "qd"), 1e-12)


@pytest.mark.parametrize("seed", sampled(range(24), 3))
def test_derivatives_of_inverse_dynamics_are_those_of_pinocchio(seed: int) -> None:
    pytest.importorskip("pinocchio")
    c = case(seed)
    by_q, by_qd = c("inverse_dynamics_derivatives", c.q, c.qd, c.qdd, c.bare)
    theirs = c.witness.inverse_dynamics_derivatives(c.q, c.qd, c.qdd)
    _close(by_q, theirs[0])
    _close(by_qd, theirs[1])


@pytest.mark.parametrize("seed", SEEDS)
def test_derivatives_of_forward_dynamics_are_slopes_with_50_digits(seed: int) -> None:
    c = case(seed)
    found = c("forward_dynamics_derivatives", c.q, c.qd, c.b, c.X)
    point = point_of(q=c.q, qd=c.qd, tau=c.b, X=c.X)
    for matrix, by in zip(found, ("q", "qd", "tau"), strict=True):
        _close(matrix, slopes(c, "forward_dynamics", point, by), 1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_mass_matrix_is_solved(seed: int) -> None:
    c = case(seed)
    _close(c.mass(c.q) @ c("solve_mass_matrix", c.q, c.b, c.X), c.b)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_factor_gives_the_mass_matrix_and_its_projections(seed: int) -> None:
    c = case(seed)
    L, D = c("mass_matrix_factor", c.q, c.X)
    mass = c.mass(c.q)
    _close(L @ np.diag(D) @ L.T, mass, 1e-12)
    assert np.array_equal(np.diag(L), np.ones(len(D)))
    assert not np.tril(L, -1).any()
    assert (D > 0).all()
    J = c("jacobian", c.q)
    y = np.zeros_like(J.T)
    for i in reversed(range(len(D))):  # L y = J', then J M^-1 J' = y' D^-1 y
        y[i] = J.T[i] - L[i, i + 1 :] @ y[i + 1 :]
    _close(y.T @ (y / D[:, None]), J @ np.linalg.solve(mass, J.T), 1e-9)
    with pytest.raises(symgen.SymgenError, match="mass_matrix_factor: the mass matrix is not pos"):
        c("mass_matrix_factor", c.q, -c.X)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_point_of_any_link_moves_as_its_jacobian_and_drift_say(seed: int) -> None:
    c, h = case(seed), 1e-4
    point = np.array([0.3, -0.2, 0.5])

    def place(q: np.ndarray, link: int) -> np.ndarray:
        frame = world_transforms(c.arm, c.G @ q + c.c)[link - 1]
        return frame[:3, :3] @ point + frame[:3, 3]

    def turning(q: np.ndarray, ahead: np.ndarray, link: int) -> np.ndarray:
        a, b = (world_transforms(c.arm, c.G @ x + c.c)[link - 1][:3, :3] for x in (q, ahead))
        skew = b @ a.T
        return (
            np.array([skew[2, 1] - skew[1, 2], skew[0, 2] - skew[2, 0], skew[1, 0] - skew[0, 1]])
            / 2
        )

    for link in range(1, c.arm.links + 1):
        J = c("link_jacobian", c.q, link, point)
        for k, step in enumerate(h * np.eye(len(c.q))):
            _close(J[:3, k], (place(c.q + step, link) - place(c.q - step, link)) / (2 * h), 1e-6)
            _close(J[3:, k], turning(c.q - step, c.q + step, link) / (2 * h), 1e-6)
        drift = c("link_drift", c.q, c.qd, link, point)
        ends = [c("link_jacobian", c.q + s * c.qd, link, point) @ c.qd for s in (h, -h)]
        _close(drift, (ends[0] - ends[1]) / (2 * h), 1e-6)
    with pytest.raises(symgen.ParameterError, match="link"):
        c("link_jacobian", c.q, c.arm.links + 1, point)


@pytest.mark.parametrize("seed", SEEDS)
def test_regrouping_and_a_body_fixed_at_run_time(seed: int) -> None:
    c, draw = case(seed), np.random.default_rng(seed)
    _close(c("base_parameters", c.standard), c.X, 1e-14)
    for link in range(1, c.arm.links + 1):
        mass, com = draw.uniform(0.5, 3), draw.uniform(-0.3, 0.3, 3)
        half = draw.uniform(-0.2, 0.2, (3, 3))
        about = half @ half.T + 0.1 * np.eye(3)
        links = c.links.copy()
        whole = about + mass * (com @ com * np.eye(3) - np.outer(com, com))
        links[link - 1] += [*whole[np.triu_indices(3)], *(mass * com), mass]
        expected, _ = c.parameters(links)
        entries = about[np.triu_indices(3)]
        found = c("add_body", c.X, link, mass, com, entries)
        _close(found, expected, 1e-14)
        _close(c("add_body", found, link, -mass, com, -entries), c.X, 1e-14)


@pytest.mark.parametrize("seed", SEEDS)
def test_regressors_over_standard_parameters(seed: int) -> None:
    c = case(seed)
    kinetic, potential = c("standard_energy_regressor", c.q, c.qd)
    inertial = c.standard[: len(kinetic)]
    _close(kinetic @ inertial, 0.5 * c.qd @ c.mass(c.q) @ c.qd)
    whole = c.evaluator.energy_regressor(c.q, c.qd) @ c.X[: c.model.inertial]
    rest = c.evaluator.energy_regressor(0 * c.q, 0 * c.qd) @ c.X[: c.model.inertial]
    at_rest = (
        np.hstack(c("standard_energy_regressor", 0 * c.q, 0 * c.qd)).reshape(2, -1).sum(axis=0)
    )
    if len(c.apart) == c.robot.n:  # else a weight is in the friction of X
        _close((kinetic + potential - at_rest) @ inertial, whole - rest)
    tau = c("inverse_dynamics", c.q, c.qd, c.qdd, c.X)
    _close(c("standard_torque_regressor", c.q, c.qd, c.qdd) @ c.standard, tau)


LOADED = """
[robot]
name = "loaded"
gravity = [0.0, -9.81, 0.0]
[[joint]]
coulomb_width = 0.1
[[joint]]
d = 0.4
[[joint]]
sigma = 1
alpha = "pi/2"
[[coupling]]
joints = [1, 2]
ratio = -1.5
[[effect]]
name = "load_dependent_friction"
joints = [2]
[[effect]]
name = "detent"
joints = [1]
torque = "-A*(q1-c)*exp(-((q1-c)/w)**2) - B*abs(qd2)*q3"
linear = { A = "N m/rad", B = "N s" }
nonlinear = { c = 0.31, w = 0.18 }
"""


def test_derivatives_hold_effects_of_the_load_smooth_friction_and_couplings() -> None:
    model = symgen.derive(
        symgen.parse_robot(LOADED),
        ("inverse_dynamics", "forward_dynamics", "slotine_li_torque",
         "inverse_dynamics_derivatives", "forward_dynamics_derivatives"),
    )  # fmt: skip
    X = np.array(physical_parameters(model, random.Random(3)))
    X[[i for i, p in enumerate(model.base.parameters) if not p.inertial]] *= 0.2
    made = Case.__new__(Case)
    made.model, made.evaluator = model, symgen.load(model, backend="casadi")
    draw = np.random.default_rng(4)
    made.q, qd, qdd, tau = draw.uniform(-1, 1, (4, 3))
    point = point_of(q=made.q, qd=qd, qdd=qdd, X=X)
    found = made("inverse_dynamics_derivatives", made.q, qd, qdd, X)
    for matrix, by in zip(found, ("q", "qd"), strict=True):
        _close(matrix, slopes(made, "inverse_dynamics", point, by), 1e-12)
        assert np.abs(matrix).max() > 0.1
    point = point_of(q=made.q, qd=qd, tau=10 * tau, X=X)
    found = made("forward_dynamics_derivatives", made.q, qd, 10 * tau, X)
    for matrix, by in zip(found, ("q", "qd", "tau"), strict=True):
        _close(matrix, slopes(made, "forward_dynamics", point, by), 1e-9)
    same = made("slotine_li_torque", made.q, qd, qd, qdd, X)
    _close(same, made("inverse_dynamics", made.q, qd, qdd, X))


POWERS = """
[[effect]]
name = "nonlinear_viscous_friction"
joints = [3]
nonlinear = { p = 0.5 }
[[effect]]
name = "grip"
joints = [1]
torque = "-H*sqrt(abs(qd2*q2))"
linear = { H = "N m" }
"""


@pytest.mark.parametrize("backend", ["casadi", "c"])
def test_a_power_without_a_slope_at_rest_has_the_slope_0_there(backend: str) -> None:
    names = ("inverse_dynamics", "inverse_dynamics_derivatives", "forward_dynamics_derivatives")
    model = symgen.derive(symgen.parse_robot(LOADED + POWERS), names)
    X = np.array(physical_parameters(model, random.Random(3)))
    powers = [model.base.names.index(name) for name in ("FVN3", "H")]
    X[powers] = 0.2, 0.3
    without = X.copy()
    without[powers] = 0
    made = Case.__new__(Case)
    made.model, made.evaluator = model, symgen.load(model, backend=backend)
    draw = np.random.default_rng(4)
    made.q, qd, qdd, tau = draw.uniform(0.2, 1, (4, 3))
    q = made.q
    point = point_of(q=q, qd=qd, qdd=qdd, X=X)
    found = made(names[1], q, qd, qdd, X)
    for matrix, by in zip(found, ("q", "qd"), strict=True):
        _close(matrix, slopes(made, names[0], point, by), 1e-12)
    rest = np.zeros(3)
    for name, force in ((names[1], qdd), (names[2], 10 * tau)):
        for ours, plain in zip(
            made(name, q, rest, force, X), made(name, q, rest, force, without), strict=True
        ):
            _close(ours, plain, 1e-12)


def test_effects_of_the_load_are_in_every_kernel_that_has_them_and_in_no_other() -> None:
    """Beside the robot without effects: all is the same at coefficients 0, else but torques.

    The torque of Slotine and Li holds the share of ITS rigid torque; friction declares no effect.
    """
    from symgen.codegen.verification import physical_parameters

    text = LOADED.partition("[[effect]]")[0]
    models = [
        symgen.derive(symgen.parse_robot(t), (*KERNELS, *OLD, *TERMS)) for t in (text, LOADED)
    ]
    calls = [symgen.load(model, backend="casadi") for model in models]
    names = [model.base.names for model in models]
    kept = [names[1].index(name) for name in names[0]]
    draw = np.random.default_rng(5)
    X = 0.2 * np.ones(len(names[1]))
    X[kept] = physical_parameters(models[0], random.Random(3))
    none = X.copy()
    none[[i for i in range(len(X)) if i not in kept]] = 0
    given = {name: draw.uniform(-1, 1, 3) for name in ("q", "qd", "qdd", "qdr", "qddr", "tau", "b")}
    given |= {"point": [0.1, 0.2, 0.3], "link": 2, "mass": 1.5, "com": [0.1, 0.2, -0.1]}
    given |= {"inertia": [0.3, 0, 0, 0.3, 0, 0.3]}
    standard = draw.uniform(0.1, 1, len(models[1].base.standard))
    words = [[p.name for p in model.base.standard] for model in models]
    differ = set()
    for kernel in models[0].kernels:
        found = []
        for i, values in ((0, X[kept]), (1, none), (1, X)):
            own = {"X": values, "standard": [standard[words[1].index(w)] for w in words[i]]}
            arguments = [(given | own)[name] for name, _ in kernel.tape.inputs]
            sizes = [len(symbols) for name, symbols in models[i].kernel(kernel.name).tape.inputs]
            arguments = [
                a[:size] if name == "X" else a
                for a, size, (name, _) in zip(arguments, sizes, kernel.tape.inputs, strict=True)
            ]
            out = calls[i][kernel.name](*arguments)
            out = out if isinstance(out, tuple) else (out,)
            if i and kernel.outputs[0].name == "X":
                out = (out[0][kept],)
            columns = [len(o.columns) or None for o in kernel.outputs]
            found.append([np.asarray(a)[..., :k] for a, k in zip(out, columns, strict=True)])
        for here, there in zip(found[0], found[1], strict=True):
            _close(there, here, 1e-12)
        if any(np.abs(a - b).max() > 1e-6 for a, b in zip(found[1], found[2], strict=True)):
            differ.add(kernel.name)
    assert differ == {
        "inverse_dynamics", "bias_torque", "forward_dynamics", "all_terms", "slotine_li_torque",
        "inverse_dynamics_derivatives", "forward_dynamics_derivatives",
    }  # fmt: skip
    base, motion = models[1].base, [given[name] for name in ("q", "qd", "qdr", "qddr")]
    columns = calls[1]["slotine_li_regressor"](*motion)
    rigid = columns[:, : base.inertial] @ X[: base.inertial]
    torque = columns @ X[: base.linear]
    torque[1] += X[names[1].index("FL2")] * abs(rigid[1]) * np.sign(given["qd"][1])
    _close(calls[1]["slotine_li_torque"](*motion, X), torque, 1e-12)


def test_kernels_over_standard_parameters_come_on_request_alone() -> None:
    names = {k.name for k in symgen.derive(symgen.read_robot("planar2r"), "all").kernels}
    assert "slotine_li_regressor" in names
    assert not any(name.startswith("standard_") for name in names)


def test_factors_of_a_mass_matrix_of_zero_say_that_it_is_not_positive_definite() -> None:
    evaluator = symgen.load(symgen.derive("planar2r", ("mass_matrix_factor",)), backend="c")
    with pytest.raises(symgen.SymgenError, match="not positive definite"):
        evaluator["mass_matrix_factor"](np.array([0.1, 0.7]), np.zeros(4))


@pytest.mark.parametrize("backend", ["c", "casadi"])
def test_effects_are_what_inverse_dynamics_has_beside_friction_and_the_rigid_body(backend) -> None:
    robot = symgen.parse_robot(LOADED)
    bare = replace(robot, effects=())
    model = symgen.derive(robot, ("effects", "friction", "inverse_dynamics"))
    evaluator = symgen.load(model, backend=backend)
    rigid = symgen.load(symgen.derive(bare, ("inverse_dynamics",)), backend=backend)
    rng = np.random.default_rng(3)
    q, qd, qdd = rng.uniform(-1, 1, (3, robot.n))
    X = rng.uniform(0.1, 1, len(model.base.parameters))
    own = dict(zip(model.base.names, X, strict=True))
    plain = [own[name] for name in rigid.model.base.names]
    expected = evaluator["inverse_dynamics"](q, qd, qdd, X) - rigid["inverse_dynamics"](
        q, qd, qdd, plain
    )
    assert np.abs(expected).max() > 1e-3
    np.testing.assert_allclose(evaluator["effects"](q, qd, qdd, X), expected, atol=1e-12)
    assert "effects" not in [k.name for k in symgen.derive(bare, "all").kernels]


@pytest.mark.parametrize("sigma", [(1, 0), (1, 1, 0, 0), (0, 1, 0), (1, 0, 1)])
def test_joints_after_a_linear_axis_have_the_symbols_of_christoffel(sigma: tuple[int, ...]) -> None:
    """By differences of the mass matrix; the link of a linear axis does not turn."""
    joints = "".join(
        f'[[joint]]\nsigma = {kind}\nalpha = "{("0", "-pi/2", "pi/2")[k % 3]}"\nd = 0.2\n'
        "friction = []\n"
        for k, kind in enumerate(sigma)
    )
    text = f'[robot]\nname = "axis"\ngravity = [2.0, -5.0, -8.0]\n{joints}'
    kernels = ("mass_matrix", "coriolis", "gravity_torque", "slotine_li_torque")
    model = symgen.derive(symgen.parse_robot(text, "axis.toml"), (*kernels, "slotine_li_regressor"))
    call, n = symgen.load(model), len(sigma)
    X = np.array(physical_parameters(model, random.Random(1)))
    q, qd, qdr, qddr = np.random.default_rng(1).uniform(-1, 1, (4, n))
    step = 1e-5 * np.eye(n)
    rates = np.array([
        (call["mass_matrix"](q + e, X) - call["mass_matrix"](q - e, X)) / 2e-5 for e in step
    ])  # fmt: skip
    symbols = (
        np.einsum("kij,k->ij", rates, qd)
        + np.einsum("jik,k->ij", rates, qd)
        - np.einsum("ijk,k->ij", rates, qd)
    ) / 2
    np.testing.assert_allclose(call["coriolis"](q, qd, X), symbols, rtol=0, atol=1e-8)
    tau = call["mass_matrix"](q, X) @ qddr + symbols @ qdr + call["gravity_torque"](q, X)
    found = call["slotine_li_torque"](q, qd, qdr, qddr, X)
    np.testing.assert_allclose(found, tau, rtol=0, atol=1e-7)
    found = call["slotine_li_regressor"](q, qd, qdr, qddr) @ X
    np.testing.assert_allclose(found, tau, rtol=0, atol=1e-7)
