"""Effects that need the model itself, hidden in simulators that share no code with it.

Named first and of the true size: a turned base, a wrong length, an elastic joint; and, with the
parameters of an earlier state given, a load, a drive gain and friction that changed.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from oracles import planar2r
from oracles.hidden import cases, machines
from oracles.random_arms import to_toml
from support import sampled

import symgen
from symgen.diagnosis.diagnosis import Diagnosis
from symgen.diagnosis.model_based_effects import special_candidates
from symgen.diagnosis.workflow import diagnose
from symgen.symbolic.independence import random_states
from symgen.symbolic.variation import variation

SPECIAL = ["base_tilt", "geometry_error", "joint_elasticity", "payload"]


def _diagnosed(
    case: cases.Case, folder: Path, *, given: bool = False, effects: list[str] | None = None
) -> Diagnosis:
    f = cases.write(case, folder)
    parameters = f / "parameters.toml" if given else None
    return diagnose(f / "robot.toml", f / "train.csv", validation=f / "validation.csv",
                    parameters=parameters, effects=effects)  # fmt: skip


def _values(diagnosis: Diagnosis) -> dict[str, float]:
    return {p.name: p.value for p in diagnosis.effects[0].parameters}


@pytest.mark.parametrize("robot", ["planar2r", "arm6r"])
def test_the_torque_of_links_with_a_free_length_and_gravity_is_pinocchios(robot: str) -> None:
    from dataclasses import replace

    pytest.importorskip("pinocchio")
    from oracles.hidden.engines import PinocchioEngine

    machine = machines.MACHINES[robot]
    v = variation(symgen.parse_robot(to_toml(machine.arm, robot)))
    number, key = v.lengths[0]
    lengths = list(getattr(machine.arm, key))
    lengths[number - 1] += 0.07
    gravity = np.array([1.0, -2.0, 3.0])
    arm = replace(machine.arm, **{key: tuple(lengths)}, gravity=tuple(gravity))
    states = random_states(v.robot, 20)
    bare = replace(machine, arm=arm, rotor=np.zeros(machine.n))
    theirs = PinocchioEngine(bare).torque(*states)
    ours = v.torque(states, machine.links, gravity, {(number, key): 0.07})
    assert np.allclose(ours, theirs, rtol=0, atol=1e-10)


@pytest.mark.parametrize("robot", sampled(["planar2r", "arm3r"], 1))
def test_a_turned_base_is_named_with_its_angles(robot: str, tmp_path: Path) -> None:
    case = cases.case(robot, "base_tilt")
    found = _diagnosed(case, tmp_path)
    assert [e.name for e in found.effects] == ["base_tilt"]
    truth, values = case.truth[0][2], _values(found)
    size = float(np.linalg.norm(list(truth.values())))
    for name, value in values.items():
        assert abs(value - truth[f"beta_{name[1].lower()}"]) < 0.15 * size


def test_a_wrong_length_is_named_with_its_error(tmp_path: Path) -> None:
    case = cases.case("arm3r", "geometry_error")
    found = _diagnosed(case, tmp_path)
    assert (found.effects[0].name, found.effects[0].joints) == ("geometry_error", (3,))
    assert _values(found)["delta_d3"] == pytest.approx(case.truth[0][2]["delta_d"], rel=0.07)


def test_lengths_that_scale_together_are_one_class(tmp_path: Path) -> None:
    """Of an upright planar arm only the ratio of the two lengths has a torque."""
    found = _diagnosed(cases.case("scara", "geometry_error"), tmp_path, effects=SPECIAL)
    first = found.effects[0]
    both = {(first.name, first.joints), *first.indistinguishable_from}
    assert both == {("geometry_error", (2,)), ("geometry_error", (3,))}


def test_an_elastic_joint_is_named_with_its_compliance(tmp_path: Path) -> None:
    case = cases.case("planar2r", "joint_elasticity")
    found = _diagnosed(case, tmp_path)
    name, joints, truth = case.truth[0]
    assert (found.effects[0].name, found.effects[0].joints) == (name, joints)
    assert _values(found)[f"CE{joints[0]}"] == pytest.approx(1 / truth["K"], rel=0.3)


@pytest.mark.parametrize("robot", sampled(["planar2r", "scara"], 1))
def test_a_load_is_named_by_what_shows_of_it(robot: str, tmp_path: Path) -> None:
    case = cases.case(robot, "payload")
    found = _diagnosed(case, tmp_path, given=True)
    _, joints, truth = case.truth[0]
    assert [(e.name, e.joints) for e in found.effects] == [("payload", joints)]
    values = _values(found)
    assert set(values) == {"ML", "MXL", "MYL", "ZZL"}  # four of ten on arms with parallel axes
    for name in ("ML", "MXL", "MYL"):
        assert values[name] == pytest.approx(truth[name], rel=0.05)
    assert found.extended.payload == joints[0]
    assert found.after.total < 0.3 * found.before.total
    loaded = {p.name: p.value for p in found.parameters}
    own = case.parameters[f"MX{joints[0]}"]
    assert loaded[f"MX{joints[0]}R"] == pytest.approx(own + truth["MXL"], rel=0.02)


def test_a_drive_gain_that_changed_is_named(tmp_path: Path) -> None:
    case = cases.case("planar2r", "drive_gain_error")
    found = _diagnosed(case, tmp_path, given=True)
    name, joints, truth = case.truth[0]
    assert [(e.name, e.joints) for e in found.effects] == [(name, joints)]
    assert _values(found)[f"G{joints[0]}"] == pytest.approx(truth["gain"] - 1, rel=0.02)


@pytest.mark.parametrize("factor", sampled([0.6, 1.5], 1))
def test_friction_that_drifted_is_named_with_its_change(factor: float, tmp_path: Path) -> None:
    """The parameters are those of a state in which Coulomb friction of joint 2 was different."""
    case = cases.case("planar2r", None)
    f = cases.write(case, tmp_path)
    before = case.parameters["FS2"] / factor
    text = (f / "parameters.toml").read_text().replace(
        f"FS2 = {case.parameters['FS2']!r}", f"FS2 = {before!r}"
    )  # fmt: skip
    (f / "parameters.toml").write_text(text)
    found = diagnose(f / "robot.toml", f / "train.csv", validation=f / "validation.csv",
                     parameters=f / "parameters.toml")  # fmt: skip
    assert [(e.name, e.joints) for e in found.effects] == [("coulomb_friction", (2,))]
    assert _values(found)["FS2"] == pytest.approx(case.parameters["FS2"] - before, rel=0.05)
    now = {p.name: p.value for p in found.parameters}
    assert now["FS2"] == pytest.approx(case.parameters["FS2"], rel=0.03)


@pytest.mark.parametrize(
    ("robot", "given"),
    sampled([(r, g) for r in ("planar2r", "arm3r") for g in (False, True)], 1,
            always=[("planar2r", True)]),
)  # fmt: skip
def test_a_robot_as_its_file_says_has_none_of_them(robot: str, given: bool, tmp_path: Path) -> None:
    found = _diagnosed(cases.case(robot, None), tmp_path, given=given)
    assert (found.verdict, found.effects) == ("consistent", ())


def test_a_planar_arm_feels_its_base_turn_about_its_axes_alone() -> None:
    """In a vertical plane; of the two other axes one is vertical, and one lies in the plane."""
    robot = symgen.parse_robot(machines.MACHINES["planar2r"].robot_toml())
    (tilt,) = special_candidates(robot, None, ["base_tilt"])  # type: ignore[arg-type]
    assert [name for name, _ in tilt.coefficients] == ["TZ"]


def hung(seed: int, share: float) -> symgen.Log:
    """A planar arm in a vertical plane; its motors carry a share of the weight of link 2."""
    rng = np.random.default_rng(seed)
    t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
    (q1, q2), (v1, v2), (a1, a2) = q.T, qd.T, qdd.T
    c, s, both = np.cos(q2), np.sin(q2), 0.8 * (a1 + a2)
    weight = 9.81 * 1.2 * share * np.cos(q1 + q2)
    first = 3.0 * a1 + both + 0.6 * (c * (2 * a1 + a2) - s * v2 * (2 * v1 + v2))
    second = both + 0.6 * (c * a1 + s * v1**2)
    tau = np.stack([first + 9.81 * 4.0 * np.cos(q1) + weight, second + weight], axis=1)
    tau += np.sign(qd) + 0.5 * qd + 0.02 * rng.normal(size=q.shape)
    return symgen.make_log(f"log {seed}", t, q, tau)


def test_a_carried_weight_is_no_slow_clock() -> None:
    """Half the weight of link 2 beside its whole inertia is what a clock gives that is too slow."""
    text = (
        '[robot]\nname = "hung"\nconvention = "modified-dh"\ngravity = [0.0, -9.81, 0.0]\n'
        "[[joint]]\n[[joint]]\nd = 0.5\n"
    )
    robot = symgen.parse_robot(text, "hung.toml")
    found = diagnose(robot, hung(2, 0.5), validation=hung(3, 0.5))
    assert found.verdict == "explained"
    assert {e.name for e in found.effects} == {"gravity_compensation"}
    assert found.after.total < 0.1 * found.before.total
    estimate = symgen.identify(robot, hung(2, 0.5), validation=hung(3, 0.5))
    told = " ".join(estimate.reasons)
    assert "of the weight of the links" in told
    assert "times too fast" in told


def test_a_rotor_of_one_joint_is_no_drive_of_two() -> None:
    """On a planar arm a drive of both joints, of half the inertia, is the same torque."""
    text = planar2r.robot_toml("rotor")
    head, last = text.rsplit("friction", 1)
    robot = symgen.parse_robot(f"{head}rotor_inertia = false\nfriction{last}", "rotor.toml")

    def log(seed: int) -> symgen.Log:
        rng, X = np.random.default_rng(seed), np.array([3.7, 0.8, 1.2, 0.3])
        t, q, qd, qdd = planar2r.harmonic_motion(rng, seed)
        tau = [planar2r.inverse_dynamics(*s, X, 0.5) for s in zip(q, qd, qdd, strict=True)]
        tau = np.array(tau) + np.sign(qd) + 0.5 * qd + 0.02 * rng.normal(size=q.shape)
        tau[:, 1] += 0.3 * qdd[:, 1]
        return symgen.make_log(f"log {seed}", t, q, tau, qd)

    found = diagnose(robot, log(2), validation=log(3))
    assert [(e.name, e.joints) for e in found.effects] == [("rotor_inertia", (2,))]
