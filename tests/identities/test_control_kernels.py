"""Kernels for control with effects, couplings and smooth friction, by slopes with 50 digits."""

from __future__ import annotations

import random
from collections.abc import Mapping
from dataclasses import replace
from decimal import Decimal

import mpmath
import numpy as np
import pytest

import symgen
from symgen.codegen.verification import evaluate, physical_parameters


def _close(a, b, tolerance: float = 1e-10) -> None:
    np.testing.assert_allclose(a, b, atol=tolerance * (1 + np.abs(b).max(initial=0.0)), rtol=0)


def slopes(
    model: symgen.Model, kernel: str, point: Mapping[str, list[float]], by: str
) -> np.ndarray:
    """Central differences with 50 digits, exact to far more than a double."""
    made = model.kernel(kernel)
    columns = []
    for k in range(len(point[by])):
        ends = []
        for sign in (1, -1):
            moved = {name: list(values) for name, values in point.items()}
            moved[by][k] = Shifted(moved[by][k], sign)
            ends += list(evaluate(made, model, [moved], 50))
        columns.append([float((a - b) / Decimal("2e-18")) for a, b in zip(*ends, strict=True)])
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
    made = symgen.load(model, backend="casadi")
    draw = np.random.default_rng(4)
    q, qd, qdd, tau = draw.uniform(-1, 1, (4, 3))
    point = point_of(q=q, qd=qd, qdd=qdd, X=X)
    found = made["inverse_dynamics_derivatives"](q, qd, qdd, X)
    for matrix, by in zip(found, ("q", "qd"), strict=True):
        _close(matrix, slopes(model, "inverse_dynamics", point, by), 1e-12)
        assert np.abs(matrix).max() > 0.1
    point = point_of(q=q, qd=qd, tau=10 * tau, X=X)
    found = made["forward_dynamics_derivatives"](q, qd, 10 * tau, X)
    for matrix, by in zip(found, ("q", "qd", "tau"), strict=True):
        _close(matrix, slopes(model, "forward_dynamics", point, by), 1e-9)
    same = made["slotine_li_torque"](q, qd, qd, qdd, X)
    _close(same, made["inverse_dynamics"](q, qd, qdd, X))


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
    made = symgen.load(model, backend=backend)
    draw = np.random.default_rng(4)
    q, qd, qdd, tau = draw.uniform(0.2, 1, (4, 3))
    point = point_of(q=q, qd=qd, qdd=qdd, X=X)
    found = made[names[1]](q, qd, qdd, X)
    for matrix, by in zip(found, ("q", "qd"), strict=True):
        _close(matrix, slopes(model, names[0], point, by), 1e-12)
    rest = np.zeros(3)
    for name, force in ((names[1], qdd), (names[2], 10 * tau)):
        for ours, plain in zip(
            made[name](q, rest, force, X), made[name](q, rest, force, without), strict=True
        ):
            _close(ours, plain, 1e-12)


def test_effects_of_the_load_are_in_every_kernel_that_has_them_and_in_no_other() -> None:
    """Beside the robot without effects: all is the same at coefficients 0, else but torques.

    The torque of Slotine and Li holds the share of ITS rigid torque; friction declares no effect.
    """
    from symgen.codegen.verification import physical_parameters

    text = LOADED.partition("[[effect]]")[0]
    models = [symgen.derive(symgen.parse_robot(t), "all") for t in (text, LOADED)]
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
        "inverse_dynamics", "bias_torque", "forward_dynamics", "slotine_li_torque",
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
