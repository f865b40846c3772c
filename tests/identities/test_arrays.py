"""JAX and PyTorch: the values of the C for every kernel, and slopes of the derivative kernels."""

from __future__ import annotations

import random
import subprocess
import sys
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from oracles.following import following_arm
from oracles.random_arms import named_arm, random_arm
from packages import LEANING, RICH
from support import PROJECT, parsed, robot_of

import symgen
from symgen.codegen.kernels import KERNELS
from symgen.codegen.verification import physical_parameters

EFFECTS = """
[robot]
name = "arm"
gravity = [0.0, -9.81, 0.0]
[[joint]]
[[joint]]
alpha = "pi/2"
d = 0.4
coulomb_width = 0.05
[[joint]]
d = 0.3
[[effect]]
name = "stribeck_friction"
joints = [3]
nonlinear = { vs = 0.5 }
[[effect]]
name = "torque_ripple"
joints = [2]
nonlinear = { k = 8 }
[[effect]]
name = "mine"
joints = [1]
torque = "-A*(q1-0.3)*exp(-((q1-0.3)/0.5)**2) + B*max(qd2, 0.1)*tan(q3)/(2 + cos(q1))"
linear = { A = "N m/rad", B = "N m" }
"""
LOADED = EFFECTS + '[[effect]]\nname = "load_dependent_friction"\njoints = [1, 2]\n'
DRONE = '[robot]\nname = "drone"\nbase = "floating"\ngravity = [0.0, 0.0, -9.81]\n'
WALKER = (
    DRONE.replace("drone", "walker")
    + """
[[joint]]
alpha = "pi/2"
d = 0.2
[[joint]]
d = 0.3
[[joint]]
antecedent = 0
d = -0.2
"""
)
POWER = """
[robot]
name = "power"
[[joint]]
[[joint]]
alpha = "pi/2"
[[effect]]
name = "nonlinear_viscous_friction"
joints = [1, 2]
nonlinear = { p = 1.5 }
"""
TEXTS = {"rich": RICH, "leaning": LEANING, "effects": EFFECTS, "loaded": LOADED}
TEXTS |= {"drone": DRONE, "walker": WALKER, "power": POWER}
LIBRARY = "emps lwr4 panda planar2r puma560 rx90 scara sr400 stanford twin tx40 ur10e wam7".split()
ROBOTS = [*LIBRARY, *TEXTS, "imu", "follows", "named", "tree"]
CASES = [("jax", "planar2r", ("inverse_dynamics", "torque_regressor"))]
LATE = [(library, robot, tuple(KERNELS)) for robot in ROBOTS for library in ("jax", "torch")]
#: Of the largest entry: the values, and the slopes.
CLOSE, SLOPE = 1e-12, 1e-9
STATES = 3


def robot_named(name: str) -> symgen.Robot:
    """A robot of the library, of TEXTS, or of an oracle."""
    if name in TEXTS:
        return parsed(TEXTS[name])
    if name == "imu":
        text = symgen.robot_toml(robot_of(random_arm(3, max_joints=4), ("coulomb", "viscous")))
        return parsed(text.replace("[robot]\n", '[robot]\nbase = "imu"\n', 1))
    if name == "follows":
        return parsed(following_arm(100, max_joints=5).text)
    if name == "named":
        return parsed(named_arm(2)[1])
    if name == "tree":
        return robot_of(random_arm(4, min_joints=4, max_joints=6, tree=True), ("offset",))
    return symgen.read_robot(name)


def states(model: symgen.Model, seed: int = 0) -> dict[str, dict[str, np.ndarray]]:
    """Inputs of every kernel, by kernel and name: a possible robot in random states."""
    draw = np.random.default_rng(seed)
    X = physical_parameters(model, random.Random(seed))
    found: dict[str, dict[str, np.ndarray]] = {}
    for kernel in model.kernels:
        found[kernel.name] = {}
        for a in kernel.inputs:
            value = draw.uniform(-1, 1, (STATES, a.size))
            if a.link:
                value = np.array(model.robot.numbers[-1]) if model.robot.numbers else np.array(0)
            elif a.plain:
                value = np.array(1.3)
            elif a.name == "X":
                value = np.array(X)  # functions of its first entries take all of it
            elif a.shared:
                value = value[0]
            elif a.name == "qd":
                value[0] = 0.0  # at rest
            found[kernel.name][a.name] = value
    return found


def called(
    model: symgen.Model, library: str, inputs: dict[str, dict[str, np.ndarray]], folder: Path
) -> dict[str, np.ndarray]:
    """Results of NAME_jax.py or NAME_torch.py, from a process with this library."""
    if find_spec(library) is None:
        pytest.skip(f"{library} is not installed")
    names = tuple(k.name for k in model.kernels if k.name in inputs)
    tree = symgen.generate(model, target=library, kernels=names)
    source = folder / f"{tree.name}_{library}.py"
    source.write_bytes(tree.files[source.name])
    flat = {f"{k}/{a}": value for k, named in inputs.items() for a, value in named.items()}
    read, written = folder / "in.npz", folder / "out.npz"
    np.savez(read, **flat)
    command = [sys.executable, PROJECT / "tests/arrays.py", source, read, written]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with np.load(written) as arrays:
        return {name: arrays[name] for name in arrays}


def in_c(function: Callable[..., object], named: dict[str, np.ndarray]) -> list[np.ndarray]:
    """Outputs of a C function, state by state."""
    by_state = [name for name, value in named.items() if value.ndim == 2]
    rows = []
    for k in range(STATES if by_state else 1):
        row = [value[k] if name in by_state else value for name, value in named.items()]
        found = function(*row)
        rows.append(found if isinstance(found, tuple) else (found,))
    return [np.stack(x) if by_state else np.asarray(x[0]) for x in zip(*rows, strict=True)]


def close(found: np.ndarray, wanted: np.ndarray, tolerance: float, name: str) -> None:
    """Equal shapes, and values equal in relation to the largest."""
    wanted = np.broadcast_to(wanted, found.shape)
    size = tolerance * np.abs(wanted).max(initial=0.0)
    np.testing.assert_allclose(found, wanted, rtol=0, atol=size, err_msg=name)


@pytest.mark.parametrize(
    ("library", "name", "kernels"),
    [*CASES, *(pytest.param(*c, marks=pytest.mark.slow) for c in LATE)],
    ids=lambda value: value if isinstance(value, str) else str(len(value)),
)
def test_values_are_those_of_c_and_slopes_those_of_the_derivatives(
    library: str, name: str, kernels: tuple[str, ...], tmp_path: Path
) -> None:
    model = symgen.derive(robot_named(name), kernels)
    inputs = states(model)
    found = called(model, library, inputs, tmp_path)
    evaluator = symgen.load(model)
    values: dict[str, list[np.ndarray]] = {}
    for kernel in model.kernels:
        values[kernel.name] = in_c(evaluator[kernel.name], inputs[kernel.name])
        for k, (wanted, output) in enumerate(zip(values[kernel.name], kernel.outputs, strict=True)):
            for form in ("values", "mapped"):
                key = f"{kernel.name}/{form}/{k}"
                if key in found:
                    assert found[key].shape[-len(output.shape) :] == output.shape, key
                    close(found[key], wanted.reshape(*wanted.shape[:1], *output.shape)
                          if wanted.ndim > len(output.shape) else wanted, CLOSE, key)  # fmt: skip
    for kernel, wanted in slopes(evaluator, inputs).items():
        for argument, slope in wanted.items():
            close(found[f"{kernel}/slopes/{argument}"], slope, SLOPE, f"{kernel}, {argument}")


def slopes(
    evaluator: symgen.Evaluator, inputs: dict[str, dict[str, np.ndarray]]
) -> dict[str, dict[str, np.ndarray]]:
    """Slopes of inverse and forward dynamics, from kernels in C, by kernel and input."""
    model, named = evaluator.model, inputs["inverse_dynamics"]
    found: dict[str, dict[str, np.ndarray]] = {"inverse_dynamics": {}}
    inverse = found["inverse_dynamics"]
    if not model.robot.loaded:
        moved = {name: value for name, value in named.items() if name != "X"}
        (inverse["X"],) = in_c(evaluator["torque_regressor"], moved)
    if "forward_dynamics" in inputs:
        inverse |= by_input(model, "inverse_dynamics_derivatives", evaluator, named)
        if model.robot.n and not model.robot.loaded:
            (M,) = in_c(evaluator["mass_matrix"], {key: named[key] for key in ("q", "X")})
            inverse["qdd"] = M[:, :, len(model.robot.free) :]
        if not model.robot.floating:  # it has several outputs there
            name = "forward_dynamics_derivatives"
            found["forward_dynamics"] = by_input(model, name, evaluator, inputs["forward_dynamics"])
    return found


def by_input(
    model: symgen.Model, name: str, evaluator: symgen.Evaluator, named: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Outputs dq_out, dqd_out .. of a derivative kernel in C, by the input q, qd .."""
    kernel = model.kernel(name)
    assert kernel is not None
    inputs = {a.name: named[a.name] for a in kernel.inputs}
    words = [output.name[1:].removesuffix("_out") for output in kernel.outputs]
    return dict(zip(words, in_c(evaluator[name], inputs), strict=True))


@pytest.mark.parametrize("library", ["jax", pytest.param("torch", marks=pytest.mark.slow)])
def test_an_x_for_each_state_and_nan_where_no_robot_has_it(library: str, tmp_path: Path) -> None:
    model = symgen.derive("planar2r", ("solve_mass_matrix",))
    X = np.array([[3.5, 0.06, 0.124, 0.006], [1.0, 0.0, 0.0, 0.0], [3.0, 0.1, 0.2, 0.0]])
    q, b = np.random.default_rng(0).uniform(-1, 1, (2, 3, 2))
    inputs = {"solve_mass_matrix": {"q": q, "b": b, "X": X}}
    found = called(model, library, inputs, tmp_path)["solve_mass_matrix/values/0"]
    assert np.isnan(found).all(axis=1).tolist() == [False, True, False]
    solve = symgen.load(model)["solve_mass_matrix"]
    for k in (0, 2):
        close(found[k], solve(q[k], b[k], X[k]), CLOSE, f"state {k}")


@pytest.mark.parametrize("library", ["jax", "torch"])
def test_the_text_depends_on_its_library_alone(library: str) -> None:
    model = symgen.derive("planar2r", ("inverse_dynamics",))
    first, again = (symgen.generate(model, target=library) for _ in range(2))
    source = first.files[f"planar2r_{library}.py"]
    assert source == again.files[f"planar2r_{library}.py"]
    imports = [x for x in source.decode().splitlines() if x.startswith(("import ", "from "))]
    assert imports == [{"jax": "import jax.numpy as jnp", "torch": "import torch"}[library]]
