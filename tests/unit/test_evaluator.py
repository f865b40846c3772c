"""The evaluator: every way of computing a kernel gives the same numbers, whatever comes in."""

from __future__ import annotations

import multiprocessing
import pickle
import shutil
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from pathlib import Path

import casadi
import numpy as np
import pytest

import symgen
from symgen.runtime.evaluator import Evaluator

ROBOTS = ("planar2r", "smooth")
BACKENDS = ("c", "casadi")
TOLERANCE = 1e-13
SMOOTH = """
[robot]
name = "smooth"
gravity = [0.0, -9.81, 0.0]
[[joint]]
coulomb_width = 0.05
[[joint]]
d = 0.5
friction = ["offset"]
[[joint]]
sigma = 1
alpha = 1.2
[[coupling]]
joints = [1, 3]
ratio = -0.75
"""


@cache
def loaded(name: str, backend: str) -> Evaluator:
    """An evaluator, loaded once."""
    if backend == "c" and shutil.which("cc") is None:
        pytest.skip("no C compiler (cc) on this machine")
    robot = symgen.parse_robot(SMOOTH) if name == "smooth" else symgen.read_robot(name)
    return symgen.load(robot, backend=backend)


def points(evaluator: Evaluator, kernel: str, count: int, seed: int = 5) -> list[np.ndarray]:
    """Random inputs (count, n) of a kernel."""
    draw = np.random.default_rng(seed)
    inputs = evaluator[kernel].kernel.tape.inputs
    return [draw.uniform(-2, 2, (count, len(symbols))).round(6) for _, symbols in inputs]


def kernels(evaluator: Evaluator) -> list[str]:
    return [k.name for k in evaluator.model.kernels]


def agree(found: np.ndarray, expected: np.ndarray) -> None:
    """Equal to 1e-13 of the largest entry, sample by sample."""
    assert found.shape == expected.shape
    assert found.dtype == np.float64
    error = np.abs(found - expected).max(axis=-1)
    assert (error <= TOLERANCE * np.abs(expected).max(axis=-1)).all()


# The same numbers.


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", ROBOTS)
def test_single_batch_and_bound_buffers_are_bit_for_bit_the_same(name, backend):
    evaluator = loaded(name, backend)
    for kernel in kernels(evaluator):
        function = evaluator[kernel]
        batch = points(evaluator, kernel, 5)
        whole = function(*batch)
        bound = function.bind()
        for i in range(5):
            one = [a[i] for a in batch]
            np.testing.assert_array_equal(function(*one), whole[i])
            for buffer, value in zip(bound.inputs, one, strict=True):
                buffer[:] = value
            bound()
            np.testing.assert_array_equal(bound.out, whole[i])


@pytest.mark.parametrize("name", ["scara", "smooth"])
def test_a_saved_casadi_file_loads_in_casadi_and_agrees(name, tmp_path):
    evaluator = loaded(name, "casadi")
    tree = symgen.generate(evaluator.model, target="casadi")
    symgen.write_package(tree, tmp_path / name)
    command = [sys.executable, f"{name}_casadi.py", "--save", "saved"]
    subprocess.run(command, cwd=tmp_path / name, check=True)
    files = sorted((tmp_path / name / "saved").glob("*.casadi"))
    assert [f.stem for f in files] == sorted(f"{name}_{k}" for k in kernels(evaluator))
    for file in files:
        function = casadi.Function.load(str(file))
        kernel = file.stem.removeprefix(f"{name}_")
        inputs = evaluator[kernel].kernel.tape.inputs
        assert [function.name_in(i) for i in range(function.n_in())] == [a for a, _ in inputs]
        assert function.name_out(0) == "out"
        batch = points(evaluator, kernel, 3)
        for i in range(3):
            found = np.array(function(*(a[i] for a in batch))).ravel()
            agree(found, evaluator[kernel](*(a[i] for a in batch)))


def test_a_package_for_casadi_alone_does_not_describe_c():
    evaluator = loaded("scara", "casadi")
    text = symgen.generate(evaluator.model, target="casadi").files["README.md"].decode()
    assert "scara_casadi.py" in text
    assert not [
        word for word in ("C99", "cmake", "MISRA", "```c", "scara_panels.h") if word in text
    ]


# Pickled.


def test_a_spawned_process_takes_an_evaluator():
    evaluator = loaded("planar2r", "c")
    for backend in BACKENDS:
        again = pickle.loads(pickle.dumps(loaded("planar2r", backend)))
        assert (again.backend, again.model) == (backend, evaluator.model)
    q, qd = [0.1, 0.2], [1.0, -1.0]
    spawned = ProcessPoolExecutor(1, multiprocessing.get_context("spawn"))
    with spawned as executor:
        found = executor.submit(evaluator.energy_regressor, q, qd).result()
    np.testing.assert_array_equal(found, evaluator.energy_regressor(q, qd))


# Shapes.


@pytest.mark.parametrize("backend", BACKENDS)
def test_an_empty_batch_gives_an_empty_result(backend):
    evaluator = loaded("scara", backend)
    q = np.zeros((0, 4))
    assert evaluator.energy_regressor(q, q).shape == (0, evaluator.model.inertial)
    assert evaluator.friction_power(q, q).shape == (0, 8)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("q", "qd"),
    [
        ((3,), (3,)),
        ((2,), (3, 2)),
        ((3, 2), (4, 2)),
        ((2, 3), (2, 3)),
        ((2, 2, 2),) * 2,
        ((), ()),
        ((0,), (0,)),
    ],
)
def test_wrong_shapes_are_parameter_errors_that_name_the_array(q, qd, backend):
    evaluator = loaded("planar2r", backend)
    with pytest.raises(symgen.ParameterError, match=r"energy_regressor: qd? has shape.*accepted"):
        evaluator.energy_regressor(np.zeros(q), np.zeros(qd))


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("q", [["a", "b"], [None, {}], [[0.0, 1.0], [0.0]], [1j, 0.0]])
def test_what_is_no_array_of_numbers_is_refused(q, backend):
    with pytest.raises((symgen.ParameterError, TypeError, ValueError)):
        loaded("planar2r", backend).energy_regressor(q, [0.0, 0.0])


@pytest.mark.parametrize("count", [0, 1, 3])
def test_a_wrong_number_of_arrays_is_a_parameter_error(count):
    function = loaded("planar2r", "casadi")["energy_regressor"]
    with pytest.raises(symgen.ParameterError, match=r"takes 2 arrays \(q, qd\)"):
        function(*[np.zeros(2)] * count)


# Layouts and types.


@pytest.mark.parametrize("backend", BACKENDS)
def test_layout_and_type_of_the_inputs_do_not_matter(backend):
    evaluator = loaded("scara", backend)
    q, qd = points(evaluator, "energy_regressor", 6)
    expected = evaluator.energy_regressor(q, qd)

    def strided(a: np.ndarray) -> np.ndarray:
        wide = np.full((12, 9), np.nan)
        wide[::2, 1::2] = a
        return wide[::2, 1::2]

    def reverse(a: np.ndarray) -> np.ndarray:
        return np.ascontiguousarray(a[::-1, ::-1])[::-1, ::-1]

    for layout in (np.asfortranarray, strided, reverse, np.ndarray.tolist):
        np.testing.assert_array_equal(evaluator.energy_regressor(layout(q), layout(qd)), expected)
        row = layout(q)[1]
        np.testing.assert_array_equal(evaluator.energy_regressor(row, qd[1]), expected[1])
    swapped = q.astype(q.dtype.newbyteorder())
    np.testing.assert_array_equal(evaluator.energy_regressor(swapped, qd), expected)
    frozen = q.copy()
    frozen.flags.writeable = False
    np.testing.assert_array_equal(evaluator.energy_regressor(frozen, qd), expected)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("kind", [np.int64, np.int8, np.float32, np.bool_])
def test_other_types_of_numbers_are_read_by_value(kind, backend):
    evaluator = loaded("scara", backend)
    q = np.array([[1, 0, 1, 1], [0, 1, 1, 0]])
    expected = evaluator.energy_regressor(q.astype(float), q[::-1].astype(float))
    found = evaluator.energy_regressor(q.astype(kind), q[::-1].astype(kind))
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("backend", BACKENDS)
def test_inputs_are_not_written_and_results_share_no_memory(backend):
    evaluator = loaded("scara", backend)
    q, qd = points(evaluator, "energy_regressor", 3)
    before = q.copy(), qd.copy()
    first = evaluator.energy_regressor(q, qd)
    kept = first.copy()
    second = evaluator.energy_regressor(qd, q)
    np.testing.assert_array_equal(q, before[0])
    np.testing.assert_array_equal(qd, before[1])
    np.testing.assert_array_equal(first, kept)
    assert first.flags.c_contiguous
    assert first.flags.writeable
    assert not any(np.shares_memory(first, other) for other in (q, qd, second))


@pytest.mark.parametrize("backend", BACKENDS)
def test_two_bound_kernels_do_not_share_buffers(backend):
    function = loaded("planar2r", backend)["energy_regressor"]
    one, two = function.bind(), function.bind()
    one.inputs[1][:] = [1.0, 0.0]
    two.inputs[1][:] = [2.0, 0.0]
    one()
    two()
    assert (one.out[0], two.out[0]) == (0.5, 2.0)


# Friction.


@pytest.mark.parametrize("backend", BACKENDS)
def test_smooth_coulomb_friction_and_couplings_have_their_columns(backend):
    evaluator = loaded("smooth", backend)
    names = [p.name for p in evaluator.model.base.parameters[evaluator.model.inertial :]]
    q, qd = points(evaluator, "friction_power", 5)
    a, b, c = qd.T
    u = a - 0.75 * c
    columns = {
        "FS1": a * np.tanh(a / 0.05),
        "FV1": a * a,
        "OF2": b,
        "FS3": np.abs(c),
        "FV3": c * c,
        "FVM3": u * u,
        "FSM3": np.abs(u),
    }
    assert set(names) == set(columns)
    expected = np.stack([columns[name] for name in names], axis=-1)
    np.testing.assert_allclose(evaluator.friction_power(q, qd), expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_robot_without_friction_has_no_friction_columns(backend):
    evaluator = loaded("planar2r", backend)
    for shape in ((3, 2), (0, 2)):
        found = evaluator.friction_power(np.zeros(shape), np.zeros(shape))
        assert found.shape == (shape[0], 0)
        assert found.dtype == np.float64
    assert evaluator.friction_power([0.0, 0.0], [0.0, 0.0]).shape == (0,)


# Loading.


def test_load_takes_a_name_a_path_a_robot_or_a_model(tmp_path: Path):
    robot = symgen.read_robot("planar2r")
    (tmp_path / "robot.toml").write_text(symgen.robot_toml(robot))
    sources = ["planar2r", tmp_path / "robot.toml", str(tmp_path), robot, symgen.derive(robot)]
    for source in sources:
        found = symgen.load(source, backend="casadi").energy_regressor([0.1, 0.2], [1.0, 0.0])
        assert found[0] == 0.5


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_mass_matrix_that_is_not_positive_definite_is_refused(backend):
    forward = symgen.load(symgen.derive(symgen.read_robot("planar2r"), "all"), backend=backend)[
        "forward_dynamics"
    ]
    good = [1.702, 0.056, 0.15, 0.075]
    assert np.isfinite(forward([0.1, 0.2], [0.0, 0.0], [1.0, 1.0], good)).all()
    with pytest.raises(symgen.ParameterError, match="positive definite"):
        forward([0.1, 0.2], [0.0, 0.0], [1.0, 1.0], [-good[0], *good[1:]])
