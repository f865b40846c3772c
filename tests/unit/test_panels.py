"""A batch on panels: the values of the single call, at every width, place, length and layout."""

from __future__ import annotations

import ctypes
import random
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import symgen
from symgen.codegen import panels as panelling
from symgen.codegen.verification import physical_parameters
from symgen.runtime import evaluator as evaluators
from symgen.runtime.build import find_compiler
from symgen.runtime.panels import Panels

PROJECT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc) here")
# Kinds of joints, friction with both signs' functions, and torques with functions of angles.
MIXED = """
[robot]
name = "mixed"
convention = "modified-dh"
gravity = [0.0, 1.0, -9.81]
[[joint]]
friction = ["coulomb", "viscous", "offset"]
[[joint]]
alpha = 1.1
d = 0.4
coulomb_width = 0.05
[[joint]]
sigma = 1
alpha = -0.7
[[joint]]
alpha = 0.3
d = 0.2
[[effect]]
name = "hose"
joints = [4]
torque = "-A*tanh((q4-0.2)/0.5) - B*abs(qd4)*exp(-q4**2)"
linear = { A = "N m", B = "N m s/rad" }
"""
KERNELS = (
    "energy_regressor",
    "torque_regressor",
    "momentum_regressor",
    "inverse_dynamics",
    "mass_matrix",
    "forward_dynamics",
    "solve_mass_matrix",
)


@cache
def loaded(name: str) -> symgen.Evaluator:
    """An evaluator with every kernel that is compared."""
    robot = symgen.parse_robot(MIXED) if name == "mixed" else symgen.read_robot(name)
    return symgen.load(symgen.derive(robot, KERNELS), backend="c")


@cache
def panels_of(name: str, kernel: str) -> Panels:
    """A kernel on panels."""
    compiler = find_compiler()
    assert compiler is not None
    found = loaded(name)
    return Panels(found.model, compiler, found[kernel].kernel)


def points(name: str, kernel: str, count: int) -> list[np.ndarray]:
    """Random inputs of a kernel; X of an arm that can exist."""
    draw = np.random.default_rng(3)
    model = loaded(name).model
    X = draw.uniform(0.5, 1.0, len(model.base.parameters))
    if loaded(name)[kernel].kernel.guards:
        X = np.array(physical_parameters(model, random.Random(1)))
    inputs = loaded(name)[kernel].kernel.tape.inputs
    return [X if n == "X" else draw.uniform(-3, 3, (count, len(s))) for n, s in inputs]


def parts(result) -> list[np.ndarray]:
    return list(result) if isinstance(result, tuple) else [result]


def agree(found, expected, tolerance=1e-13) -> None:
    """Equal to 1e-13 of the largest entry of all samples."""
    for one, other in zip(parts(found), parts(expected), strict=True):
        assert one.shape == other.shape
        np.testing.assert_allclose(one, other, rtol=0, atol=tolerance * np.abs(other).max())


@pytest.mark.parametrize(
    ("name", "kernel"),
    [("mixed", k) for k in KERNELS],
)
def test_panels_give_the_values_of_the_single_call(name, kernel):
    panels = panels_of(name, kernel)
    single = loaded(name)[kernel]
    # forward_dynamics solves with M: rounding grows with its condition number
    tolerance = 1e-11 if kernel == "forward_dynamics" else 1e-13
    for count in (1, 2, panels.width + 1, 27):
        inputs = points(name, kernel, count)
        agree(panels(*inputs), single(*inputs), tolerance)


@pytest.mark.parametrize("stream", [False, True])
@pytest.mark.parametrize("kernel", ["energy_regressor", "momentum_regressor", "inverse_dynamics"])
def test_bound_panels_and_rows_hold_the_same_values(kernel, stream):
    panels = panels_of("mixed", kernel)
    width, count = panels.width, 3 * panels.width + 1
    inputs = points("mixed", kernel, count)
    rows = panels.bind(count, stream=stream)
    blocks = panels.bind(count, rows=False, stream=stream)
    for out in rows.outputs:
        out.fill(np.nan)  # what is not written shows
    for out in blocks.outputs:  # what is always zero is written once, and nobody writes over it
        with pytest.raises(ValueError, match="read-only"):
            out.fill(np.nan)
    for bound in (rows, blocks):
        for place, given in zip(bound.inputs, inputs, strict=True):
            place[...] = given
        for _ in range(2):
            bound()
    agree(tuple(rows.outputs), panels(*inputs), 0.0)
    for block, row in zip(blocks.outputs, rows.outputs, strict=True):
        samples = block.transpose(0, 2, 1).reshape(4 * width, -1)
        np.testing.assert_array_equal(samples[:count], row.reshape(count, -1))
        np.testing.assert_array_equal(samples[count:], samples[count - 1 :][: width - 1])


@pytest.mark.parametrize("odd", [np.nan, np.inf, -np.inf, 1e6, -3.7e11, 1e300, 5e-324, -0.0])
def test_an_odd_sample_gives_what_the_single_call_gives_and_spoils_no_other(odd):
    panels, single = panels_of("mixed", "energy_regressor"), loaded("mixed")
    q, qd = points("mixed", "energy_regressor", 19)
    clean = panels(q, qd)
    q[5, 1], q[18, 3] = odd, odd
    with np.errstate(all="ignore"):
        found, expected = panels(q, qd), single["energy_regressor"](q, qd)
    others = np.delete(np.arange(19), [5, 18])
    np.testing.assert_array_equal(found[others], clean[others])
    for i in (5, 18):
        np.testing.assert_array_equal(np.isfinite(found[i]), np.isfinite(expected[i]))
        good = np.isfinite(expected[i])
        np.testing.assert_allclose(found[i][good], expected[i][good], rtol=1e-12, atol=1e-12)


def test_angles_near_every_multiple_of_a_quarter_turn_are_reduced_without_loss():
    """Against mpmath: the sine of a one-joint arm's angle is its potential energy's column."""
    import mpmath

    text = (
        '[robot]\nname = "swing"\nconvention = "modified-dh"\ngravity = [0.0, -1.0, 0.0]\n'
        "[[joint]]\nrotor_inertia = false\n"
    )
    model = symgen.derive(symgen.parse_robot(text))
    compiler = find_compiler()
    assert compiler is not None
    panels = Panels(model, compiler, model.kernels[0])
    quarters = np.unique(np.geomspace(1, 63000, 200).round())
    q = np.concatenate(
        [s * np.nextafter(quarters * np.pi / 2, b) for s in (1, -1) for b in (0, 1e9)]
    )
    h = panels(q[:, None], np.zeros((len(q), 1)))
    names = list(model.base.names)
    for column, exact in (("MX1", mpmath.sin), ("MY1", mpmath.cos)):
        with mpmath.workdps(40):
            expected = np.array([float(exact(mpmath.mpf(float(x)))) for x in q])
        np.testing.assert_allclose(h[:, names.index(column)], expected, rtol=5e-16)


# Inputs that end where the process may read no further: reading past them kills it.
GUARDED = """
import ctypes, mmap, sys
import numpy as np
from symgen.runtime.panels import Panels
from symgen.runtime.build import find_compiler
import symgen
from pathlib import Path
model = symgen.derive(symgen.parse_robot(sys.stdin.read()), ("inverse_dynamics",))
panels = Panels(model, find_compiler(), model.kernel("inverse_dynamics"))
libc = ctypes.CDLL(None)
page = mmap.PAGESIZE
def at_the_edge(shape):
    room = mmap.mmap(-1, 2 * page)
    start = ctypes.addressof(ctypes.c_char.from_buffer(room))
    assert libc.mprotect(ctypes.c_void_p(start + page), ctypes.c_size_t(page), 0) == 0
    size = int(np.prod(shape))
    return np.frombuffer(room, count=size, offset=page - 8 * size).reshape(shape)
X = np.ones(len(model.base.parameters))
for count in range(1, 20):
    panels(*(at_the_edge((count, 4)) for _ in range(3)), X)
print("whole")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="guards pages as Linux does")
def test_nothing_is_read_behind_the_inputs():
    panels_of("mixed", "inverse_dynamics")
    done = subprocess.run(
        [sys.executable, "-c", GUARDED],
        cwd=PROJECT,
        input=MIXED,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "whole\n"), done.stderr


def test_one_sample_without_a_result_is_said_for_the_batch():
    panels = panels_of("mixed", "forward_dynamics")
    q, qd, tau, X = points("mixed", "forward_dynamics", 5)
    panels(q, qd, tau, X)
    with pytest.raises(symgen.ParameterError, match="mass matrix is not positive definite"):
        panels(q, qd, tau, -X)


def test_where_there_are_no_panels_none_are_given(monkeypatch):
    assert symgen.load("planar2r", backend="casadi")["energy_regressor"].panels() is None
    monkeypatch.setattr(panelling, "LARGEST", 2)
    assert symgen.load("planar2r", backend="c")["energy_regressor"].panels() is None


def test_a_link_or_what_is_changed_in_place_has_no_panels_and_keeps_its_own_loop(monkeypatch):
    monkeypatch.setattr(evaluators, "MANY", 2)
    model = symgen.derive(symgen.read_robot("planar2r"), ("link_jacobian", "add_body"))
    found = symgen.load(model, backend="c")
    assert found["link_jacobian"].panels() is None
    assert found["add_body"].panels() is None
    q, point = np.linspace(-1, 1, 6).reshape(3, 2), np.ones((3, 3))
    many = found["link_jacobian"](q, 2, point)
    np.testing.assert_array_equal(
        many, [found["link_jacobian"](*one) for one in zip(q, [2] * 3, point, strict=True)]
    )


def test_panels_refuse_one_sample_and_wrong_shapes():
    panels = panels_of("mixed", "energy_regressor")
    with pytest.raises(symgen.ParameterError, match="panels take a batch"):
        panels(np.zeros(4), np.zeros(4))
    with pytest.raises(symgen.ParameterError, match="q has shape"):
        panels(np.zeros((3, 5)), np.zeros((3, 4)))
    assert ctypes.sizeof(ctypes.c_double) * panels.width in (16, 32, 64)
