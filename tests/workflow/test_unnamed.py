"""What no name fits becomes an expression in C, and a portrait says what a gap is organised by.

The logs are those of simulators that share no code with the package; the torque of the hidden
expression is written here once more.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pinocchio")
pytest.importorskip("mujoco")

from oracles.hidden.cases import Case, Spec, write
from support import sampled

import symgen
from symgen.diagnosis.diagnosis import Diagnosis, FoundEffect
from symgen.diagnosis.workflow import diagnose

#: The larger arms take half a minute each.
ROBOTS = ("planar2r", "arm3r", "scara", "arm6r")
FUNCTIONS = {"sin": np.sin, "cos": np.cos, "exp": np.exp, "abs": np.abs, "sign": np.sign}


def _diagnosed(spec: Spec, folder: Path, **options: object) -> tuple[Case, Diagnosis]:
    case = spec.run()
    write(case, folder)
    found = diagnose(
        folder / "robot.toml",
        folder / "train.csv",
        validation=[folder / "validation.csv"],
        **options,
    )
    return case, found


def _torque(effect: FoundEffect, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    """Read the expression of a diagnosis with Python's own evaluation."""
    values = {p.name: p.value for p in effect.parameters}
    for j in range(q.shape[1]):
        values |= {f"q{j + 1}": q[:, j], f"qd{j + 1}": qd[:, j]}
    return eval(effect.expression, {"__builtins__": {}}, FUNCTIONS | values)


def _true(case: Case, q: np.ndarray, qd: np.ndarray) -> np.ndarray:
    (_, (joint,), p), j = case.truth[0], case.truth[0][1][0] - 1
    if "other" in p:
        return p["a"] * q[:, j] * qd[:, int(p["other"]) - 1]
    x = q[:, joint - 1] - p["c"]
    return -p["A"] * x * np.exp(-((x / p["w"]) ** 2))


@pytest.mark.parametrize(
    ("robot", "effect"),
    sampled([(r, e) for r in ROBOTS for e in ("unnamed_bump", "unnamed_product")], 0,
            always=[("planar2r", "unnamed_bump")]),
)  # fmt: skip
def test_what_has_no_name_is_found_as_an_expression_and_emitted(
    robot: str, effect: str, tmp_path: Path
) -> None:
    case, found = _diagnosed(Spec(robot, effect, "moderate", 1), tmp_path)
    joint = case.truth[0][1][0]
    assert [(e.name, e.joints) for e in found.effects] == [("unnamed", (joint,))]
    # A floor of its own: that of the diagnosis counts white noise only.
    assert found.after.total < 1.3 * max(np.sqrt(np.mean(case.floor**2)), found.floor.total) + 0.003
    assert found.after.per_joint[joint - 1] < 0.2 * found.before.per_joint[joint - 1]
    assert found.where[0].joint == joint
    q, qd = case.true["validation"]["q"], case.true["validation"]["qd"]
    said, true = _torque(found.effects[0], q, qd), _true(case, q, qd)
    assert np.linalg.norm(said - true) < 0.05 * np.linalg.norm(true)

    # The compiled code of the extended robot says the same as the diagnosis.
    again = symgen.parse_robot(symgen.robot_toml(found.extended))
    compiled = symgen.load(symgen.derive(again, ("torque_regressor",)))
    names = compiled.model.base.names
    values = {p.name: p.value for p in found.effects[0].parameters}
    X = np.array([values.get(name, 0.0) if name.startswith("U") else 0.0 for name in names])
    given = compiled["torque_regressor"](q[::50], qd[::50], 0 * q[::50]) @ X
    np.testing.assert_allclose(given[:, joint - 1], -said[::50], rtol=1e-5, atol=1e-9)
    assert not np.delete(given, joint - 1, axis=1).any()


@pytest.mark.parametrize(
    ("robot", "misfit"),
    sampled([(r, m) for r in ROBOTS for m in (0.0, 0.01)], 0,
            always=[("planar2r", 0.01)]),
)  # fmt: skip
def test_a_clean_log_holds_no_expression(robot: str, misfit: float, tmp_path: Path) -> None:
    spec = Spec(robot, None, "moderate", 7, misfit=misfit)
    _, found = _diagnosed(spec, tmp_path, effects=["unnamed"])
    assert not found.effects
    if not misfit:
        assert found.verdict == "consistent"
        assert not found.where


def test_a_named_effect_comes_before_an_expression(tmp_path: Path) -> None:
    case, found = _diagnosed(Spec("planar2r", "gravity_spring", "moderate", 1), tmp_path)
    assert [(e.name, e.joints) for e in found.effects] == [case.truth[0][:2]]


@pytest.mark.parametrize(
    ("effect", "pattern"),
    sampled(
        [
            ("coulomb_friction", "velocity-sign"),
            ("viscous_friction", "velocity"),
            ("stribeck_friction", "low-speed"),
            ("load_dependent_friction", "load"),
            ("gravity_spring", "position"),
            ("rotor_inertia", "acceleration"),
            ("coupled_transmission", "other-joint"),
        ],
        3,
    ),
)
def test_a_portrait_says_what_a_gap_is_organised_by(
    effect: str, pattern: str, tmp_path: Path
) -> None:
    # One effect that explains nothing here: the pattern has to come from the residual alone.
    case, found = _diagnosed(
        Spec("planar2r", effect, "moderate", 1), tmp_path, effects=["external_contact"]
    )
    assert not found.effects
    assert found.where[0].joint in case.truth[0][1]
    assert found.where[0].pattern == pattern
    assert sum(p.share for p in found.where) == pytest.approx(1.0)


def test_a_short_contact_is_given_its_time(tmp_path: Path) -> None:
    case, found = _diagnosed(
        Spec("planar2r", "external_contact", "moderate", 1), tmp_path, effects=["external_contact"]
    )
    acts = np.flatnonzero(np.any(np.abs(case.hidden["train"]) > 1e-9, axis=1))
    begin, end = case.train["t"][acts[[0, -1]]]
    assert found.where[0].pattern == "time"
    first, last = found.where[0].time_window
    assert begin - 0.3 < first < last < end + 0.3
