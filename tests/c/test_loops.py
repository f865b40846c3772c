"""Kernels as loops over the joints: right on large trees, and on every kind of joint."""

from __future__ import annotations

import ctypes
import json
import random
import re
import shutil
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from oracles.large_arms import LARGE
from oracles.pinocchio_arm import PinocchioArm
from oracles.random_arms import random_arm, random_parameters, to_toml
from oracles.transforms import Arm
from packages import STRICT, c_files, casadi_functions, run
from support import sampled

import symgen
from symgen.codegen.kernels import regrouped
from symgen.codegen.loops import MANY_OF, PROGRAMS
from symgen.codegen.verification import physical_parameters
from symgen.robot.toml_io import parse_robot

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler (cc)")
FRICTION = ("coulomb", "viscous", "offset")
DERIVATIVES = ("inverse_dynamics_derivatives", "forward_dynamics_derivatives")
#: Kernels whose single statements are derived in seconds for large robots too.
FIRST = tuple(name for name in PROGRAMS if name not in DERIVATIVES)


def written(
    text: str, folder: Path, kernels: Sequence[str] = tuple(PROGRAMS), **options: str
) -> symgen.Model:
    """Derive a robot and write its kernels that can be loops."""
    model = symgen.derive(parse_robot(text, "robot.toml"), tuple(kernels))
    symgen.write_package(symgen.generate(model, target="c", **options), folder)
    return model


def loaded(folder: Path) -> ctypes.CDLL:
    """Compile the single calls of the package in a folder, strictly, and load them."""
    sources = [f for f in c_files(folder / "package") if not f.stem.endswith("_panels")]
    run(["cc", *STRICT, "-O1", "-fPIC", "-shared", *sources, "-lm", "-o", "arm.so"], folder)
    return ctypes.CDLL(str(folder / "arm.so"))


class Case:
    """An arm as loops in C, and the same arm in Pinocchio."""

    def __init__(self, arm: Arm, name: str, kernels: Sequence[str], folder: Path) -> None:
        text, self.name = to_toml(arm, name, FRICTION), name
        self.model = written(text, folder / "package", kernels, loops="always")
        self.n = self.model.robot.n
        links, rotors = random_parameters(arm, 5)
        values = dict.fromkeys((p.name for p in self.model.base.standard), 0.0)
        for j, link in enumerate(links, 1):
            prefixes = "XX XY XZ YY YZ ZZ MX MY MZ M".split()
            values |= {f"{p}{j}": float(v) for p, v in zip(prefixes, link, strict=True)}
        moving = zip(self.model.robot.numbers, rotors, strict=True)
        values |= {f"IA{j}": float(v) for j, v in moving}
        numbers = self.model.robot.values()
        order = [values[p.name] for p in self.model.base.standard]
        self.X = np.array(regrouped(self.model.base, order, numbers))
        for kernel in kernels:
            source = (folder / f"package/{name}_{kernel}.c").read_text()
            assert "for (size_t j = 0u; j < " in source
        self.library = loaded(folder)
        self.witness = PinocchioArm(arm, links, rotors)

    def __call__(self, kernel: str, *states: np.ndarray) -> np.ndarray:
        """Call a kernel in C; return its outputs in one array."""
        outputs = self.model.kernel(kernel).outputs
        arrays = [np.full(output.shape, np.nan) for output in outputs]
        given = (*states, self.X, *arrays)
        call = getattr(self.library, f"{self.name}_{kernel}")
        call(*(a.ctypes.data_as(ctypes.c_void_p) for a in given))
        alike = len({a.shape for a in arrays}) == 1
        return arrays[0] if len(arrays) == 1 else np.array(arrays) if alike else arrays


@pytest.mark.parametrize("name", sampled([n for n in LARGE if n != "chain7"], 1, ["humanoid"]))
def test_a_large_tree_has_loops_that_agree_with_pinocchio(name: str, tmp_path: Path) -> None:
    called = Case(LARGE[name], name, FIRST, tmp_path)
    n, witness = called.n, called.witness
    zero = np.zeros(n)
    for q, qd, qdd in np.random.default_rng(1).uniform(-2, 2, (4, 3, n)):
        gravity = witness.inverse_dynamics(q, zero, zero)
        for ours, theirs in (
            (called("inverse_dynamics", q, qd, qdd), witness.inverse_dynamics(q, qd, qdd)),
            (called("bias_torque", q, qd), witness.inverse_dynamics(q, qd, zero)),
            (called("gravity_torque", q), gravity),
            (called("mass_matrix", q), witness.mass_matrix(q)),
            (called("coriolis", q, qd) @ qd, witness.inverse_dynamics(q, qd, zero) - gravity),
            (called("generalized_momentum", q, qd)[0], witness.mass_matrix(q) @ qd),
            (called("slotine_li_torque", q, qd, qd, qdd), witness.inverse_dynamics(q, qd, qdd)),
            (witness.mass_matrix(q) @ called("solve_mass_matrix", q, qdd), qdd),
        ):
            np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-12 * np.abs(theirs).max())
        L, D = called("mass_matrix_factor", q)
        M = witness.mass_matrix(q)
        np.testing.assert_allclose(L @ np.diag(D) @ L.T, M, rtol=0, atol=1e-12 * np.abs(M).max())
        accelerations = called("forward_dynamics", q, qd, qdd)  # qdd: torques
        back = witness.inverse_dynamics(q, qd, accelerations)
        terms = np.abs(witness.mass_matrix(q)) @ np.abs(accelerations)
        np.testing.assert_allclose(back, qdd, rtol=0, atol=1e-12 * terms.max())


@pytest.mark.parametrize(
    ("joints", "tree", "fixed"),
    sampled(
        product((5, 8, 15, 30), (False, True), (False, True)),
        0,
        [(5, False, False), (8, True, False), (8, True, True)],
    ),
)
def test_loops_of_derivatives_agree_with_pinocchio(
    joints: int, tree: bool, fixed: bool, tmp_path: Path
) -> None:
    arm = random_arm(5, min_joints=joints, max_joints=joints, tree=tree, fixed=fixed)
    called = Case(arm, "arm", ("mass_matrix", *DERIVATIVES), tmp_path)
    witness, zero = called.witness, np.zeros(called.n)
    for q, qd, qdd in np.random.default_rng(6).uniform(-2, 2, (4, 3, called.n)):
        ours = called("inverse_dynamics_derivatives", q, qd, qdd)
        theirs = witness.inverse_dynamics_derivatives(q, qd, qdd)
        for own, their in zip(ours, theirs, strict=True):
            np.testing.assert_allclose(own, their, rtol=0, atol=1e-10 * np.abs(their).max())
        M = witness.mass_matrix(q)
        own = called("mass_matrix", q)
        np.testing.assert_allclose(own, M, rtol=0, atol=1e-12 * np.abs(M).max())
        tau = M @ qdd + witness.inverse_dynamics(q, qd, zero)
        ours = called("forward_dynamics_derivatives", q, qd, tau)
        for own, back in zip(ours, (*-theirs, np.eye(called.n)), strict=True):
            terms = np.abs(M) @ np.abs(own)
            np.testing.assert_allclose(M @ own, back, rtol=0, atol=1e-10 * terms.max())


def test_loops_say_where_a_mass_matrix_is_not_positive_definite(tmp_path: Path) -> None:
    text = to_toml(LARGE["chain15"], "chain15")
    written(text, tmp_path / "auto", FIRST)
    texts = {k: (tmp_path / f"auto/chain15_{k}.c").read_text() for k in FIRST}
    model = written(text, tmp_path / "package", FIRST, loops="always")
    assert {k for k, text in texts.items() if "size_t j" not in text} == set(MANY_OF)
    library = loaded(tmp_path)
    X = np.array(physical_parameters(model, random.Random(2)))
    states = np.random.default_rng(2).uniform(-1, 1, (3, 15))
    for name, count in (
        ("forward_dynamics", 3),
        ("solve_mass_matrix", 2),
        ("mass_matrix_factor", 1),
    ):
        outputs = [np.zeros(o.shape) for o in model.kernel(name).outputs]
        for spoiled, status in ((X, 0), (-X, 1), (np.nan * X, 2)):
            given = (*states[:count], spoiled, *outputs)
            arguments = (a.ctypes.data_as(ctypes.c_void_p) for a in given)
            assert getattr(library, f"chain15_{name}")(*arguments) == status


def every_kind(seed: int, gravity: bool) -> str:
    """Return an arm of many kinds of joints; gravity is an input, or some joints are fixed."""
    sharp = 'friction = ["coulomb"'
    arm = random_arm(seed, min_joints=5, max_joints=6, tree=True, fixed=not gravity)
    text = to_toml(arm, "arm", FRICTION).replace(sharp, f"coulomb_width = 0.05\n{sharp}", 2)
    if gravity:
        line = next(x for x in text.splitlines() if x.startswith("gravity"))
        text = text.replace(line, 'gravity = "input"')
    return text


def test_loops_of_every_kind_of_joint_agree_with_their_50_digits(tmp_path: Path) -> None:
    """The check program of a package compares them with values of the straight-line tapes."""
    for seed, dtype, gravity in ((3, "double", False), (8, "float", True)):
        folder = tmp_path / str(seed)
        written(every_kind(seed, gravity), folder, dtype=dtype, loops="always")
        name = "armf" if dtype == "float" else "arm"
        assert "[j + 1u]" in (folder / f"{name}_inverse_dynamics.c").read_text()
        texts = [f.read_text() for f in c_files(folder) if not f.stem.endswith("_panels")]
        own = [f for text in texts for f in re.findall(r"^static .* (\w+)\(", text, re.MULTILINE)]
        assert len(set(own)) == len(own) >= 2  # MISRA C:2012 5.9
        run(["cc", *STRICT, "-O1", *c_files(folder, check=True), "-lm", "-o", "check"], folder)
        run([folder / "check"], folder)


def test_casadi_loops_of_every_kind_of_joint_agree_with_their_50_digits(tmp_path: Path) -> None:
    """symgen check evaluates them; regressors are derivatives of loops there."""
    regressors = ("torque_regressor", "slotine_li_regressor", "momentum_regressor")
    for seed, gravity in ((3, False), (5, False), (8, True)):  # of 5, constants fill a line
        robot = parse_robot(every_kind(seed, gravity), "arm.toml")
        model = symgen.derive(robot, (*PROGRAMS, *regressors))
        folder = tmp_path / str(seed)
        symgen.write_package(symgen.generate(model, target="casadi", loops="always"), folder)
        (checked,) = symgen.check(folder)
        assert not checked.differences
        measured = {kernel for backend, kernel, _ in checked.errors if backend == "casadi"}
        assert measured == {*PROGRAMS, *regressors}
        source = (folder / "arm_casadi.py").read_text()
        assert source.count("_started(q, X)\n") == len(PROGRAMS) + len(regressors)


def test_casadi_functions_are_nan_where_a_mass_matrix_is_not_positive_definite(
    tmp_path: Path,
) -> None:
    text = to_toml(random_arm(2, min_joints=3, max_joints=3), "arm")
    kernels = ("forward_dynamics", "solve_mass_matrix", "mass_matrix_factor")
    model = symgen.derive(parse_robot(text, "arm.toml"), kernels)
    X = np.array(physical_parameters(model, random.Random(2)))
    for loops in ("never", "always"):
        package = symgen.generate(model, target="casadi", loops=loops)
        symgen.write_package(package, tmp_path / loops)
        for name, function in casadi_functions(tmp_path / loops, "arm").items():
            size = next(k for k in model.kernels if k.name == name).inputs[-1].size
            states = [np.full(3, 0.3)] * (function.n_in() - 1)
            for spoiled, finite in ((X, True), (-X, False), (np.nan * X, False)):
                for found in function.call([*states, spoiled[:size]]):
                    values = np.array(found)
                    assert np.isfinite(values).all() if finite else np.isnan(values).all(), name


def test_a_choice_of_loops_is_kept_in_the_manifest_and_checked(tmp_path: Path) -> None:
    text = to_toml(random_arm(2, min_joints=3, max_joints=3), "arm")
    written(text, tmp_path / "always", FIRST, loops="always")
    written(text, tmp_path / "auto", FIRST)
    place = "arm_inverse_dynamics.c"
    texts = {w: (tmp_path / w / place).read_text() for w in ("always", "auto")}
    assert "for (size_t j" in texts["always"]
    assert "for (size_t j" not in texts["auto"]
    (checked,) = symgen.check(tmp_path / "always")
    assert not checked.differences
    with pytest.raises(symgen.SymgenError, match=r"loops 'often'; accepted: auto, always, never"):
        written(text, tmp_path / "often", FIRST, loops="often")


def test_kinds_that_differ_by_friction_alone_are_told_apart(tmp_path: Path) -> None:
    smooth = "coulomb_width = 0.05\n"
    text = "".join(
        f'[[joint]]\nalpha = "{alpha}"\nd = 0.3\n{width}'
        for alpha, width in (("0", smooth), ("pi/2", ""), ("pi/2", smooth), ("pi/2", ""))
    )
    kernels = ("inverse_dynamics", "inverse_dynamics_derivatives")
    head = '[robot]\nname = "arm"\ngravity = [0.0, 0.0, -9.81]\n'
    written(head + text, tmp_path, kernels, loops="always")
    run(["cc", *STRICT, "-O1", *c_files(tmp_path, check=True), "-lm", "-o", "check"], tmp_path)
    run([tmp_path / "check"], tmp_path)


def test_a_kernel_of_thousands_of_entries_is_checked_at_fewer_points(tmp_path: Path) -> None:
    text = to_toml(LARGE["chain15"], "chain15", FRICTION)
    model = written(text, tmp_path, ("mass_matrix", "torque_regressor"))
    checked = json.loads((tmp_path / "manifest.json").read_text())["verification"]
    for kernel, points in zip(model.kernels, (1, 4), strict=True):
        assert len(checked["points"][kernel.name]) == points
        assert [len(row) for row in checked["expected"][kernel.name]] == [kernel.size] * points
    run(["cc", *STRICT, "-O1", *c_files(tmp_path, check=True), "-lm", "-o", "check"], tmp_path)
    run([tmp_path / "check"], tmp_path)
