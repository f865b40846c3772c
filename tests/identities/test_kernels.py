"""Every kernel of robots of every kind, by tape, CasADi and C, against Pinocchio and transforms."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from copy import copy
from dataclasses import replace
from functools import cache, partial

import numpy as np
import pytest
from oracles.following import following_arm
from oracles.random_arms import random_arm, random_parameters
from oracles.transforms import (
    LINK_PARAMETERS,
    jacobians,
    parameter_vector,
    world_transforms,
)
from support import parsed, robot_of

import symgen
from symgen.codegen.definition import Subject
from symgen.codegen.kernel import Kernel
from symgen.codegen.kernels import KERNELS
from symgen.codegen.model import regrouping
from symgen.symbolic import forward
from symgen.symbolic.tape import Numbers

pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
from oracles.pinocchio_arm import PinocchioArm

FUNCTIONS = {"sin": np.sin, "cos": np.cos, "abs": np.abs, "sign": np.sign, "tanh": np.tanh}
POINT = np.array([0.3, -0.2, 0.5])
MASS, INERTIA = 1.5, np.array([0.3, 0.01, 0.02, 0.4, 0.03, 0.5])
#: A body with this mass, its centre at POINT, and this inertia about that, as parameters of a link.
BODY = np.array(
    [
        *(
            INERTIA
            + MASS * (POINT @ POINT * np.eye(3) - np.outer(POINT, POINT))[np.triu_indices(3)]
        ),
        *(MASS * POINT),
        MASS,
    ]
)
#: Chains and trees of turning, sliding and fixed joints; joints that follow others; gravity as an
#: input; forward dynamics by articulated bodies, as robots with many joints have it.
KINDS = ("chain 3", "tree 4", "follows 100", "input 2", "many 5")
MORE = [f"{kind} {k}" for kind in ("chain", "tree", "many") for k in range(6, 16)]
MORE += [f"follows {k}" for k in range(101, 116)]
CASES = [(kind, backend) for kind in KINDS for backend in ("numpy", "casadi")]
CASES += [("tree 4", "c")]
LATE = [(kind, "c") for kind in KINDS if kind != "tree 4"]
LATE += [(kind, backend) for kind in MORE for backend in ("numpy", "casadi")]
#: Of these the expected values are differences, or M is solved with.
ROUGH = ("coriolis", "slotine_li", "momentum", "drift", "forward", "solve")


class Case:
    """A robot with parameters that a body can have, a state, and Pinocchio's tree beside it.

    The tree's variables are G q + c: the oracle's arm has no joint that follows another.
    """

    def __init__(self, kind: str, seed: int) -> None:
        friction = ("coulomb", "viscous")
        if kind == "follows":
            chosen = following_arm(seed, max_joints=5)
            self.arm, self.G, self.c = chosen.arm, chosen.G, chosen.c
            robot, self.flags = parsed(chosen.text), chosen.rotors()
        else:
            self.arm = random_arm(seed, min_joints=3, max_joints=5, tree=kind == "tree")
            self.G, self.c = np.eye(self.arm.n), np.zeros(self.arm.n)
            robot, self.flags = robot_of(self.arm, friction), (True,) * self.arm.links
        if kind == "input":
            self.arm = replace(self.arm, gravity=(1.7, -3.1, 8.2))
            text = symgen.robot_toml(robot)
            line = next(x for x in text.splitlines() if x.startswith("gravity"))
            robot = parsed(text.replace(line, 'gravity = "input"'))
        with pytest.MonkeyPatch.context() as patch:
            if kind == "many":
                patch.setattr(forward, "MANY", 1)
            self.model = symgen.derive(robot, tuple(KERNELS))
        self.links, self.rotors = random_parameters(self.arm, seed)
        draw = np.random.default_rng(seed)
        self.q, self.qd, self.qdd, self.b = draw.uniform(-1, 1, (4, robot.n))
        self.rest = draw.uniform(0.1, 1, 99)
        self.X, self.standard = self.parameters(self.links)
        self.tree = self.witness(self.links)
        value = dict(zip((p.name for p in self.model.base.standard), self.standard, strict=True))
        self.FS, self.FV = (
            np.array([value[f"{p}{j.number}"] for j in robot.movable]) for p in ("FS", "FV")
        )

    def witness(self, links: np.ndarray) -> PinocchioArm:
        own = np.array([self.flags[j - 1] for j in self.arm.movable])
        return PinocchioArm(self.arm, links, self.rotors * own)

    def parameters(self, links: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Base and standard parameters of the arm with these links."""
        inertial = parameter_vector(self.arm, links, self.rotors, self.flags)
        count = len(self.model.base.standard) - len(inertial)
        standard = np.array([*inertial, *self.rest[:count]])
        return regrouping(self.model) @ standard, standard

    def mass(self, q: np.ndarray) -> np.ndarray:
        return self.G.T @ self.tree.mass_matrix(self.G @ q + self.c) @ self.G

    def rigid(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        G = self.G
        return G.T @ self.tree.inverse_dynamics(G @ q + self.c, G @ qd, G @ qdd)

    def frames(self, q: np.ndarray) -> np.ndarray:
        return world_transforms(self.arm, self.G @ q + self.c)

    def link_jacobian(self, q: np.ndarray, link: int) -> np.ndarray:
        """Jacobian of POINT of a link."""
        frames = self.frames(q)
        J = jacobians(self.arm, frames)[link - 1] @ self.G
        arm = frames[link - 1, :3, :3] @ POINT
        return np.vstack([J[:3] + np.cross(J[3:].T, arm).T, J[3:]])

    def christoffel(self) -> np.ndarray:
        """C of Christoffel's symbols, from differences of the mass matrix."""
        h, one = 1e-6, np.eye(len(self.q))
        ends = [(self.mass(self.q + h * e), self.mass(self.q - h * e)) for e in one]
        slope = np.array([(a - b) / (2 * h) for a, b in ends])
        symbols = slope.transpose(1, 2, 0) + slope.transpose(1, 0, 2) - slope
        return 0.5 * np.einsum("ijk,k->ij", symbols, self.qd)

    def given(self) -> dict[str, np.ndarray]:
        """Every input of a kernel, by name."""
        tau = self.rigid(self.q, self.qd, self.qdd) + self.FS * np.sign(self.qd) + self.FV * self.qd
        given = {"q": self.q, "qd": self.qd, "qdd": self.qdd, "tau": tau, "b": self.b, "X": self.X}
        given |= {"qdr": self.b, "qddr": self.qdd[::-1], "standard": self.standard, "point": POINT}
        given |= {"link": 1, "mass": MASS, "com": POINT, "g": np.array(self.arm.gravity, float)}
        return given | {"inertia": INERTIA, "load": BODY}

    def expected(self) -> dict[str, tuple[np.ndarray, ...]]:
        """What a kernel gives; where it gives columns, what they are times their parameters."""
        q, qd, qdd, b = self.q, self.qd, self.qdd, self.b
        zero, step = 0 * q, 1e-4
        M, C, weight = self.mass(q), self.christoffel(), self.rigid(q, zero, zero)
        friction = self.FS * np.sign(qd) + self.FV * qd
        tau = self.rigid(q, qd, qdd) + friction
        reference = M @ qdd[::-1] + C @ b + weight + friction
        T, U = qd @ M @ qd / 2, self.tree.potential_energy(self.G @ q + self.c)
        slopes = (
            self.G.T
            @ self.tree.inverse_dynamics_derivatives(self.G @ q + self.c, self.G @ qd, self.G @ qdd)
            @ self.G
        )
        slopes[1] += np.diag(self.FV)
        inverse = np.linalg.inv(M)
        ends = [self.link_jacobian(q + s * qd, 1) @ qd for s in (step, -step)]
        frames = self.frames(q)
        return {
            "inverse_dynamics": (tau,),
            "forward_dynamics": (qdd,),
            "mass_matrix": (M,),
            "gravity_torque": (weight,),
            "bias_torque": (tau - M @ qdd,),
            "coriolis": (C,),
            "friction": (friction,),
            "friction_torque": (friction,),
            "friction_power": (qd @ friction,),
            "torque_regressor": (tau,),
            "power_regressor": (qd @ tau,),
            "momentum_regressor": (M @ qd, C.T @ qd - weight),
            "energy_regressor": (T + U,),
            "energy": (T, U),
            "slotine_li_regressor": (reference,),
            "slotine_li_torque": (reference,),
            "generalized_momentum": (M @ qd, C.T @ qd - weight),
            "inverse_dynamics_derivatives": tuple(slopes),
            "forward_dynamics_derivatives": (
                *(-np.linalg.solve(M, s) for s in slopes),
                np.linalg.inv(M),
            ),
            "solve_mass_matrix": (inverse @ b,),
            "mass_matrix_factor": (M,),
            "jacobian": (jacobians(self.arm, frames)[-1] @ self.G,),
            "frames": (frames,),
            "link_jacobian": (self.link_jacobian(q, 1),),
            "link_drift": ((ends[0] - ends[1]) / (2 * step),),
            "base_parameters": (self.X,),
            "add_body": (self.parameters(self.loaded(1))[0],),
            "add_load": (self.parameters(self.loaded(self.model.robot.numbers[-1]))[0],),
            "load_momentum": self.of_load(),
            "standard_energy_regressor": (T, U),
            "standard_torque_regressor": (tau,),
        }

    def loaded(self, link: int) -> np.ndarray:
        """Links, one of them with BODY."""
        links = self.links.copy()
        links[link - 1] += BODY
        return links

    def of_load(self) -> tuple[np.ndarray, np.ndarray]:
        """What BODY on the last link adds to dT/dqd and to dL/dq."""
        heavy = copy(self)
        heavy.tree = self.witness(self.loaded(self.model.robot.numbers[-1]))
        with_load, without = (
            (x.mass(x.q) @ x.qd, x.christoffel().T @ x.qd - x.rigid(x.q, 0 * x.q, 0 * x.q))
            for x in (heavy, self)
        )
        return with_load[0] - without[0], with_load[1] - without[1]

    def reduced(self, kernel: Kernel, outputs: list[np.ndarray]) -> Iterator[np.ndarray]:
        """Yield outputs, columns times their parameters, and the product of the factors of M."""
        if kernel.name == "mass_matrix_factor":
            L, D = outputs
            yield L @ np.diag(D) @ L.T
            return
        base = self.model.base
        value = dict(zip(base.names, self.X, strict=True))
        value |= dict(zip((p.name for p in base.standard), self.standard, strict=True))
        if not kernel.name.startswith("standard"):
            value |= dict(zip(base.names, self.X, strict=True))
        if kernel.name == "load_momentum":
            value |= {f"{prefix}L": x for prefix, x in zip(LINK_PARAMETERS, BODY, strict=True)}
        for array, output in zip(outputs, kernel.outputs, strict=True):
            yield array @ [value[name] for name in output.columns] if output.columns else array

    def compared(
        self, call: Callable[[Kernel, dict[str, np.ndarray]], list[np.ndarray]]
    ) -> Iterator[tuple[str, list[np.ndarray], list[np.ndarray]]]:
        """Yield each kernel with what it gives and what is expected, energies up to a constant."""
        given, expected = self.given(), self.expected()
        from_rest = given | {"q": 0 * self.q, "qd": 0 * self.qd}
        for kernel in self.model.kernels:
            if kernel.name not in expected:
                continue
            found = list(self.reduced(kernel, call(kernel, given)))
            wanted = [np.array(x) for x in expected[kernel.name]]
            if "energy" in kernel.name:
                rest = list(self.reduced(kernel, call(kernel, from_rest)))
                found[-1] = found[-1] - rest[-1]
                wanted[-1] = wanted[-1] - self.tree.potential_energy(self.c)
            yield kernel.name, found, wanted


@cache
def case(kind: str) -> Case:
    word, seed = kind.split()
    return Case(word, int(seed))


@cache
def evaluator(kind: str, backend: str) -> symgen.Evaluator:
    return symgen.load(case(kind).model, backend=backend)


def by_tape(model: symgen.Model, kernel: Kernel, given: dict[str, np.ndarray]) -> list[np.ndarray]:
    """Run the tape of a kernel in NumPy; what guards it comes after its outputs."""
    columns = {}
    for name, symbols in kernel.tape.inputs:
        value = np.eye(len(symbols))[0] if name == "link" else np.atleast_1d(given[name])
        columns[name] = list(value[: len(symbols)])
    flat = kernel.tape.run(Numbers(model.robot.values(), FUNCTIONS), columns)
    ends = np.cumsum([output.size for output in kernel.outputs])
    parts = np.split(np.array(flat, float), ends)
    return [p.reshape(o.shape) for p, o in zip(parts, kernel.outputs, strict=False)]


def called(
    model: symgen.Model,
    loaded: symgen.Evaluator | None,
    kernel: Kernel,
    given: dict[str, np.ndarray],
) -> list[np.ndarray]:
    """Call a kernel of a loaded model, or run its tape in NumPy."""
    if loaded is None:
        return by_tape(model, kernel, given)
    arguments = [given[name] for name, _ in kernel.tape.inputs]
    out = loaded[kernel.name](*arguments)
    out = out if isinstance(out, tuple) else (out,)
    return [np.asarray(a).reshape(o.shape) for a, o in zip(out, kernel.outputs, strict=True)]


@pytest.fixture
def prepared(kind: str, backend: str) -> Case:
    """A robot whose kernels are compiled."""
    if backend == "c" and shutil.which("cc") is None:
        pytest.skip("no C compiler (cc) on this machine")
    if backend != "numpy":
        evaluator(kind, backend)
    return case(kind)


@pytest.mark.parametrize(
    ("kind", "backend"), [*CASES, *(pytest.param(*c, marks=pytest.mark.slow) for c in LATE)]
)
def test_every_kernel_is_that_of_pinocchio(kind: str, backend: str, prepared: Case) -> None:
    model = prepared.model
    loaded = None if backend == "numpy" else evaluator(kind, backend)
    seen = set()
    for name, found, wanted in prepared.compared(partial(called, model, loaded)):
        seen.add(name)
        for a, b in zip(found, wanted, strict=True):
            tolerance = 5e-7 if any(word in name for word in ROUGH) else 1e-9
            size = tolerance * (1 + np.abs(b).max(initial=0.0))
            np.testing.assert_allclose(a.reshape(b.shape), b, rtol=0, atol=size, err_msg=name)
    assert set(prepared.expected()) - seen <= {"friction_power", "friction_torque", "friction"}


def test_couplings_and_payload_are_in_torques_and_regressors() -> None:
    text = """
    [robot]
    name = "wrist"
    gravity = [0.5, 1.0, -9.7]
    [[joint]]
    [[joint]]
    alpha = "pi/2"
    d = 0.3
    [[joint]]
    alpha = "-pi/2"
    r = 0.2
    [[coupling]]
    joints = [2, 3]
    ratio = -1.5
    [payload]
    joint = 3
    """
    kernels = ("inverse_dynamics", "torque_regressor", "power_regressor")
    model = symgen.derive(symgen.parse_robot(text), kernels)
    assert {"IAM3", "FVM3", "FSM3"} <= set(model.base.names)
    assert "XX3 - YY3 + XXL - YYL" in {p.expression for p in model.base.parameters}
    evaluator = symgen.load(model)
    draw = np.random.default_rng(0)
    q, qd, qdd = draw.uniform(-1, 1, (3, 3))
    X = draw.uniform(0.5, 1, len(model.base.parameters))
    tau = evaluator["inverse_dynamics"](q, qd, qdd, X)
    # F = IAM u' + FVM u + FSM sign(u) on joint 2, ratio F on joint 3.
    value = dict(zip(model.base.names, X, strict=True))
    without = X.copy()
    for name in ("IAM3", "FVM3", "FSM3"):
        without[model.base.names.index(name)] = 0.0
    u, up = qd[1] - 1.5 * qd[2], qdd[1] - 1.5 * qdd[2]
    F = value["IAM3"] * up + value["FVM3"] * u + value["FSM3"] * np.sign(u)
    rest = evaluator["inverse_dynamics"](q, qd, qdd, without)
    np.testing.assert_allclose(tau - rest, [0, F, -1.5 * F], atol=1e-12)
    np.testing.assert_allclose(evaluator["torque_regressor"](q, qd, qdd) @ X, tau)
    np.testing.assert_allclose(evaluator["power_regressor"](q, qd, qdd) @ X, qd @ tau)


@pytest.mark.slow
def test_twice_the_joints_are_twice_the_steps() -> None:
    """Where the mass matrix is factored they are three times as many."""

    def steps(joints: int) -> int:
        joint = '[[joint]]\nalpha = "pi/2"\nd = 0.1\nr = 0.2\n'
        robot = parsed('[robot]\nname = "arm"\ngravity = [0, 0, -9.81]\n' + joints * joint)
        (kernel,) = symgen.derive(robot, ("forward_dynamics",)).kernels
        return len(kernel.tape.steps)

    few = steps(forward.MANY)
    assert 1.9 * few < steps(2 * forward.MANY) < 2.2 * few


@pytest.mark.slow
def test_a_tree_of_short_branches_factors_the_mass_matrix(monkeypatch) -> None:
    """Articulated bodies would need half as many steps again."""
    root = '[robot]\nname = "tree"\n[[joint]]\n'
    branch = "[[joint]]\nantecedent = 1\n" + 4 * '[[joint]]\nalpha = "pi/2"\nd = 0.1\nr = 0.2\n'
    robot = parsed(root + 5 * branch)
    assert robot.n > forward.MANY
    (factored,) = symgen.derive(robot, ("forward_dynamics",)).kernels
    monkeypatch.setattr(forward, "MANY", 1)
    definition = KERNELS["forward_dynamics"]
    recursive = definition.derive(Subject(robot, symgen.derive(robot, ()).base))
    assert recursive is not None
    assert len(factored.tape.steps) < 0.8 * len(recursive.tape.steps)
