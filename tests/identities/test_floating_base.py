"""A floating base: kernels and base parameters against Pinocchio's free flyer."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from oracles.random_arms import random_arm, random_parameters
from oracles.transforms import Arm
from packages import STRICT, c_files, run
from support import parsed, robot_of, sampled

import symgen
from symgen.codegen.kernels import KERNELS
from symgen.codegen.model import regrouping

pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
from oracles.free_flyer import VELOCITY, FreeFlyer

#: Of the size of the values; what solves with M loses its condition.
CLOSE = 1e-12
DRONE = '[robot]\nname = "drone"\nbase = "floating"\n'


def floating(robot: symgen.Robot) -> symgen.Robot:
    """The robot, as its file gives it with a floating base."""
    text = symgen.robot_toml(robot)
    return parsed(text.replace("[robot]\n", '[robot]\nbase = "floating"\n', 1))


def free_flyer(arm: Arm, seed: int) -> tuple[FreeFlyer, np.ndarray, np.ndarray]:
    """The robot in Pinocchio, the ten numbers of its links, and its standard parameters."""
    links, rotors = random_parameters(arm, seed)
    links = np.vstack([links[::-1][0] + links[0], links])  # any body
    rotor = dict(zip(arm.movable, rotors, strict=True))
    values = list(links[0])
    for j in range(1, arm.links + 1):
        values += [*links[j], *([rotor[j]] if j in rotor else [])]
    return FreeFlyer(arm, links, rotors), links, np.array(values)


def drawn(arm: Arm, seed: int) -> tuple[np.ndarray, ...]:
    """q, qd, qdd and f, w, wd of one state."""
    draw = np.random.default_rng(seed)
    joints = draw.uniform(-2, 2, (3, arm.n))
    return (*joints, *(np.array([12.0, 3.0, 8.0])[:, None] * draw.uniform(-1, 1, (3, 3))))


def near(found: np.ndarray, want: np.ndarray, lost: float = 1.0, size: float = 0.0) -> None:
    size = max(size, 1 + np.abs(want).max(initial=0.0))
    np.testing.assert_allclose(found, want, rtol=0, atol=CLOSE * lost * size)


@pytest.mark.parametrize("seed", sampled(range(200), 6))
def test_kernels_of_random_trees_are_those_of_pinocchio(seed: int) -> None:
    arm = random_arm(seed, max_joints=6)
    model = symgen.derive(floating(robot_of(arm)), "all")
    call = symgen.load(model, backend="casadi")
    tree, links, standard = free_flyer(arm, seed)
    X = regrouping(model) @ standard
    near(call.base_parameters(standard), X)
    inertial = X[: model.inertial]
    state = q, qd, qdd, f, w, wd = drawn(arm, seed)
    v, still = VELOCITY, np.zeros(arm.n)
    want = tree.dynamics(*state)
    size = 1 + np.abs(want).max()
    near(call.inverse_dynamics(q, qd, qdd, X, f, w, wd), want)
    near(call.torque_regressor(q, qd, qdd, f, w, wd) @ X, want, size=size)
    M = call.mass_matrix(q, X)
    near(M, tree.masses(q))
    acceleration = np.array([*f, *wd, *qdd])
    near(M @ acceleration + call.bias_torque(q, qd, X, w), want, size=size)
    zero = np.zeros(3)
    near(call.gravity_torque(q, X, f), tree.dynamics(q, still, still, f, zero, zero))

    u = np.array([*v, *w, *qd])
    p, rate = tree.momentum(q, qd, v, w)
    for found in (
        call.generalized_momentum(q, qd, X, v, w),
        [x @ inertial for x in call.momentum_regressor(q, qd, v, w)],
    ):
        near(found[0], p)
        near(found[1], rate, size=1 + np.abs(p).max() * np.abs(u).max())
    kinetic = tree.kinetic(q, qd, v, w)
    near(call.energy(q, qd, X, v, w), kinetic)
    near(call.energy_regressor(q, qd, v, w) @ inertial, kinetic)
    power = call.power_regressor(q, qd, qdd, f, v, w, wd) @ X
    near(power, want @ u, size=size * np.abs(u).max())
    h, com = call.centroidal_momentum(q, qd, X, v, w)
    want_h, want_com = tree.centroidal(q, qd, v, w)
    near(com, want_com)
    near(h, want_h, size=np.abs(p).max())
    # without gravity f is the acceleration
    wrench = call.inverse_dynamics(q, qd, qdd, X, f, w, wd)[:6]
    changing = np.array([*wrench[:3], *wrench[3:] - np.cross(com, wrench[:3])])
    want_rate = tree.centroidal_rate(q, qd, qdd, v, w, f - np.cross(w, v), wd)
    np.testing.assert_allclose(changing, want_rate, rtol=0, atol=1e-10 * size)

    lost = float(np.linalg.cond(tree.masses(q)))
    found = call.forward_dynamics(q, qd, want[6:], X, w, want[:6])
    largest = np.abs(acceleration).max() + 1
    for got, expected in zip(found, (qdd, f, wd), strict=True):
        near(got, expected, lost, size=largest)
    near(call.solve_mass_matrix(q, M @ acceleration, X), acceleration, lost)
    L, D = call.mass_matrix_factor(q, X)
    near(L @ np.diag(D) @ L.T, M)
    slopes = tree.slopes(*state)
    size = size + max(np.abs(x).max() for x in slopes)
    for got, expected in zip(
        call.inverse_dynamics_derivatives(q, qd, qdd, X, f, w, wd), slopes, strict=True
    ):
        near(got, expected, size=size)
    inverse = np.linalg.inv(M)
    by_q, by_qd, by_tau, by_w = call.forward_dynamics_derivatives(q, qd, want[6:], X, w, want[:6])
    for got, expected in zip((by_q, by_qd, by_w), slopes, strict=True):
        near(got, -inverse @ expected, lost, size=np.abs(inverse).max() * size)
    near(by_tau, inverse, lost, size=np.abs(inverse).max())

    at = np.array([0.3, -0.2, 0.5])
    for link in range(arm.links + 1):
        velocity, faster = tree.point(link, at, state)
        J, drift = call.link_jacobian(q, link, at), call.link_drift(q, qd, link, at, w)
        near(J @ u, velocity)
        near(J @ acceleration + drift, faster, size=1 + np.abs(faster).max() + size)
    body = np.array([0.7, 0.1, -0.2, 0.3])
    joined = call.add_body(X, 0, body[0], body[1:], [0.1, 0, 0, 0.2, 0, 0.3])
    more = links.copy()
    steiner = body[0] * (body[1:] @ body[1:] * np.eye(3) - np.outer(body[1:], body[1:]))
    inertia = (np.diag([0.1, 0.2, 0.3]) + steiner)[np.triu_indices(3)]
    more[0] += [*inertia, *body[0] * body[1:], body[0]]
    heavier = FreeFlyer(arm, more, tree.rotor_inertia)
    near(call.inverse_dynamics(q, qd, qdd, joined, f, w, wd), heavier.dynamics(*state))
    assert len(X) == rank_of(model)


def rank_of(model: symgen.Model) -> int:
    """Rank of the regressor in every standard parameter, by singular values."""
    every = symgen.load(symgen.derive(model.robot, "standard_torque_regressor"), backend="casadi")
    count = 4 * len(model.base.standard) // 6 + 10
    draw = np.random.default_rng(1)
    joints = draw.uniform(-2, 2, (3, count, model.robot.n))
    base = draw.uniform(-10, 10, (3, count, 3))
    W = every.standard_torque_regressor(*joints, *base).reshape(-1, len(model.base.standard))
    return int(np.linalg.matrix_rank(W, tol=1e-10 * np.linalg.norm(W, 2)))


LEGS = "[[joint]]\nantecedent = 0\n[[joint]]\nantecedent = 0\nd = 0.4\n"


@pytest.mark.slow
@pytest.mark.parametrize("joints", ["", LEGS])
def test_the_package_of_a_drone_and_of_two_legs_checks_itself(tmp_path: Path, joints: str) -> None:
    model = symgen.derive(symgen.parse_robot(DRONE + joints), "all")
    tree = symgen.generate(model)
    symgen.write_package(tree, tmp_path / "drone")
    assert symgen.read_robot(tmp_path / "drone") == model.robot
    files = c_files(tmp_path / "drone", check=True)
    run(["cc", *STRICT, "-O1", f"-I{tmp_path / 'drone'}", *files, "-lm", "-o", "check"], tmp_path)
    run([tmp_path / "check"], tmp_path)
    header = (tmp_path / "drone" / "drone.h").read_text()
    assert f"#define drone_EQUATIONS {6 + model.robot.n}" in header
    assert not (tmp_path / "drone" / "drone_identifier.h").exists()
    X = symgen.load(model, backend="casadi").base_parameters(np.ones(len(model.base.standard)))
    compiled, by_casadi = (symgen.load(model, backend=backend) for backend in ("c", "casadi"))
    state = np.random.default_rng(0).uniform(-1, 1, (3, 70, model.robot.n))
    base = np.random.default_rng(1).uniform(-1, 1, (3, 70, 3))
    given = (*(x for x in state if x.size), X, *base)
    for load in (compiled, by_casadi):
        batch = load.inverse_dynamics(*given)
        assert batch.shape == (70, 6 + model.robot.n)
        for k in (0, 69):
            single = load.inverse_dynamics(*(x if x is X else x[k] for x in given))
            np.testing.assert_allclose(batch[k], single, atol=CLOSE)
    panels = compiled["inverse_dynamics"].panels()
    if panels is not None:
        np.testing.assert_allclose(panels(*given), batch, atol=CLOSE)


def test_a_tree_has_the_base_inputs_of_its_definition() -> None:
    model = symgen.derive(floating(robot_of(random_arm(2, max_joints=4))), "all")
    for kernel in model.kernels:
        expected = [a.name for a in KERNELS[kernel.name].floating.inputs]
        assert [a.name for a in kernel.inputs] == expected, kernel.name


@pytest.mark.parametrize(
    ("kernel", "reason"),
    [
        ("coriolis", "floats: M' - 2 C is skew-symmetric only with the velocity"),
        ("slotine_li_torque", "floats: C needs the velocity"),
        ("tool_wrench", "base at rest, and the base of drone floats"),
        ("frames", "drone has no movable joints"),
    ],
)
def test_what_a_floating_base_has_not_is_refused_with_the_reason(kernel: str, reason: str) -> None:
    model = symgen.derive(symgen.parse_robot(DRONE), "all")
    with pytest.raises(symgen.SymgenError, match=f"{kernel}.+{reason}"):
        symgen.generate(model, kernels=(kernel,))
    fixed = symgen.derive("planar2r", "all")
    with pytest.raises(symgen.SymgenError, match=r"centroidal_momentum.+base of planar2r is fixed"):
        symgen.generate(fixed, kernels=("centroidal_momentum",))


QUADRUPED = """[robot]
name = "quadruped"
base = "floating"
""" + "".join(
    f"""[[joint]]
antecedent = 0
gamma = {0.1 + place}
d = 0.2
alpha = 1.2
friction = []
rotor_inertia = false
[[joint]]
d = 0.1
alpha = "pi/2"
friction = []
rotor_inertia = false
[[joint]]
d = 0.2
friction = []
rotor_inertia = false
[[frame]]
name = "foot{leg}"
joint = {3 * leg}
xyz = [0.2, 0.0, 0.01]
"""
    for leg, place in enumerate((0.7, 2.4, -0.7, -2.4), 1)
)
KERNELS_OF_RANKS = ("torque_regressor", "link_jacobian", "link_drift")
POINTS = [symgen.Contact(f"foot{leg}", "point") for leg in (1, 2, 3, 4)]
SURFACES = [symgen.Contact(f"foot{leg}", "surface") for leg in (1, 2, 3, 4)]


@pytest.fixture(scope="module")
def quadruped() -> symgen.Model:
    return symgen.derive(symgen.parse_robot(QUADRUPED), KERNELS_OF_RANKS)


@pytest.mark.parametrize(("rows", "rank"), [("all", 94), ("base", 94), ("joints", 84)])
def test_ranks_of_wrenches_and_torques_alone(quadruped, rows: str, rank: int) -> None:
    found = symgen.exact_rank(quadruped.robot, quadruped.base, [symgen.EquationPart(rows)])
    assert found.rank == rank
    call = symgen.load(quadruped, backend="casadi")
    draw = np.random.default_rng(2)
    joints, base = draw.uniform(-2, 2, (3, 60, 12)), draw.uniform(-10, 10, (3, 60, 3))
    part = {"all": slice(None), "base": slice(6), "joints": slice(6, None)}[rows]
    W = call.torque_regressor(*joints, *base)[:, part].reshape(-1, 94)
    assert np.linalg.matrix_rank(W, tol=1e-10 * np.linalg.norm(W, 2)) == rank
    base = quadruped.base
    unknown = [p.name for p in base.parameters if base.standard[p.index].joint == 0]
    assert list(found.unknown) == (unknown if rows == "joints" else [])


@pytest.mark.parametrize(
    ("sets", "rank", "mass"),
    [
        ([POINTS], 90, False),
        ([POINTS[::3], POINTS[1:3]], 94, True),
        ([POINTS, POINTS[1:]], 91, False),
        ([SURFACES[:1]], 76, False),
        ([POINTS[:1]], 93, False),
    ],
)
def test_ranks_where_contacts_stay(quadruped, sets, rank: int, mass: bool) -> None:
    """A foot that never lifts hides a point mass there; a trot shows everything."""
    found = symgen.exact_rank(
        quadruped.robot,
        quadruped.base,
        [symgen.EquationPart(contacts=tuple(contacts)) for contacts in sets],
    )
    assert (found.rank, "M0R" not in found.unknown) == (rank, mass)
    W = np.vstack([projected(quadruped, contacts) for contacts in sets])
    assert np.linalg.matrix_rank(W, tol=1e-10 * np.linalg.norm(W, 2)) == rank


def projected(model: symgen.Model, contacts: Sequence[symgen.Contact]) -> np.ndarray:
    """Columns where contacts stay, in floats, projected by I - J+ J."""
    call, draw, out = symgen.load(model, backend="casadi"), np.random.default_rng(4), []
    places = [model.robot.frame(c.frame) for c in contacts]

    def rows(kernel: str, *state: np.ndarray, last: tuple = ()) -> np.ndarray:
        parts = (call[kernel](*state, f.joint, f.xyz, *last) for f in places)
        sizes = (3 if c.kind == "point" else 6 for c in contacts)
        return np.concatenate([p[:size] for p, size in zip(parts, sizes, strict=True)])

    for _ in range(100):
        q, u, a = (draw.uniform(-2, 2, k) for k in (12, 18, 18))
        J = rows("link_jacobian", q)
        inverse = np.linalg.pinv(J)
        u -= inverse @ (J @ u)
        weight = draw.uniform(-9, 9, 3)
        want = [[*weight, *([] if c.kind == "point" else np.zeros(3))] for c in contacts]
        a += inverse @ (np.concatenate(want) - rows("link_drift", q, u[6:], last=(u[3:6],)) - J @ a)
        W = call.torque_regressor(q, u[6:], a[6:], a[:3], u[3:6], a[3:6])
        out.append(W - inverse @ (J @ W))
    return np.vstack(out)


def test_ranks_in_flight(quadruped) -> None:
    """Without torques, a flight gives X up to one factor."""
    ranks = [
        symgen.exact_rank(quadruped.robot, quadruped.base, [symgen.EquationPart(rows, flight=True)])
        for rows in ("base", "all")
    ]
    assert [(r.rank, len(r.unknown)) for r in ranks] == [(93, 94), (94, 0)]


def test_gravity_as_an_input_is_refused() -> None:
    with pytest.raises(symgen.SymgenError, match=r"'input' is not possible with base = 'floating'"):
        symgen.parse_robot(DRONE + 'gravity = "input"\n')


RICH = """[robot]
name = "rich"
base = "floating"
[geometry]
L1 = 0.4
[[joint]]
antecedent = 0
alpha = 0.7
d = "L1"
friction = ["coulomb", "viscous", "offset"]
coulomb_width = 0.3
[[joint]]
d = "L1"
alpha = "pi/2"
friction = ["viscous"]
[[joint]]
antecedent = 1
d = 0.3
follows = "pi/3 - 2*q2"
[[joint]]
sigma = 1
antecedent = 0
alpha = -0.4
[[coupling]]
joints = [1, 2]
ratio = 0.5
[payload]
joint = 2
[[effect]]
name = "load_dependent_friction"
joints = [1]
[[effect]]
name = "gravity_spring"
joints = [4]
"""


def test_couplings_followers_effects_and_a_payload_on_a_floating_base() -> None:
    """Kernels agree with each other, and derivatives with differences."""
    model = symgen.derive(symgen.parse_robot(RICH), tuple(KERNELS))
    call, draw = symgen.load(model, backend="casadi"), np.random.default_rng(5)
    n, standard = 3, []
    for p in model.base.standard:
        solid = {"M": 2.0, "XX": 0.4, "YY": 0.5, "ZZ": 0.6, "MX": 0.1, "MZ": -0.2}
        standard.append(solid.get(p.prefix, 0.05))
    X = call.base_parameters(standard)
    q, qd, qdd, f, w, wd, v = (draw.uniform(-1, 1, k) for k in (n, n, n, 3, 3, 3, 3))

    def dynamics(q, qd, w) -> np.ndarray:
        return call.inverse_dynamics(q, qd, qdd, X, f, w, wd)

    want, step = dynamics(q, qd, w), 1e-6
    M, inertial = call.mass_matrix(q, X), X[: model.inertial]
    found = call.forward_dynamics(q, qd, want[6:], X, w, want[:6])
    for got, expected in zip(found, (qdd, f, wd), strict=True):
        np.testing.assert_allclose(got, expected, atol=1e-9)
    slopes = call.inverse_dynamics_derivatives(q, qd, qdd, X, f, w, wd)
    for k, (slope, size) in enumerate(zip(slopes, (n, n, 3), strict=True)):
        for j, unit in enumerate(np.eye(size)):
            state = [(q, qd, w), (q, qd, w)]
            ends = [list(s) for s in state]
            for end, sign in zip(ends, (1, -1), strict=True):
                end[k] = end[k] + sign * step * unit
            difference = (dynamics(*ends[0]) - dynamics(*ends[1])) / (2 * step)
            np.testing.assert_allclose(slope[:, j], difference, atol=1e-7)
    u = np.array([*v, *w, *qd])
    p, rate = call.generalized_momentum(q, qd, X, v, w)
    near(p, M @ u)
    columns = call.momentum_regressor(q, qd, v, w)
    near(columns[0] @ inertial, p)
    near(columns[1] @ inertial, rate)
    near(call.energy(q, qd, X, v, w), 0.5 * u @ M @ u)
    J = call.link_jacobian(q, 3, [0.1, 0.2, 0.3])
    moved = call.link_jacobian(q + step * qd, 3, [0.1, 0.2, 0.3]) - J
    still = call.link_drift(q, qd, 3, [0.1, 0.2, 0.3], np.zeros(3))
    np.testing.assert_allclose(moved @ np.array([*np.zeros(6), *qd]) / step, still, atol=1e-5)
