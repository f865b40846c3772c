"""The possible robot nearest to an estimate: as near as the truth, and said where none is near."""

from __future__ import annotations

import random

import numpy as np
import pytest
from oracles.random_arms import random_arm, random_parameters
from support import robot_of, sampled

import symgen
from symgen import names
from symgen.codegen.model import regrouping
from symgen.codegen.verification import physical_parameters
from symgen.identification.possible import nearest_possible

URDF = """<robot name="one"><link name="base"/><link name="arm">
<inertial><origin xyz="0.1 0 0"/><mass value="2"/>
<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="90" velocity="9"/></joint></robot>
"""


def estimate_near_truth(seed: int):
    """Return a model, its true X and standard parameters, an estimate of X, and its covariance.

    Links become lighter to the tip and have no friction and no rotor inertia. Standard deviations
    span four decades, as those of a precise log of such an arm do.
    """
    arm = random_arm(seed, max_joints=6)
    model = symgen.derive(robot_of(arm, friction=("coulomb", "viscous", "offset")))
    links, _ = random_parameters(arm, seed)
    rng = np.random.default_rng(seed)
    truth = {p.name: 0.0 for p in model.base.standard}
    for number, row in enumerate(links, 1):
        light = 10.0 ** (-3 * number / len(links))
        truth |= {f"{k}{number}": light * x for k, x in zip(names.LINK, row, strict=True)}
    X = regrouping(model) @ [truth[p.name] for p in model.base.standard]
    std = np.abs(X).max() * 10.0 ** rng.uniform(-5, -1, len(X))
    Q = np.linalg.qr(rng.normal(size=(len(X), len(X))))[0]
    C = Q * 10.0 ** rng.uniform(-2, 0, len(X)) @ Q.T
    C *= np.outer(std, std) / np.sqrt(np.outer(np.diag(C), np.diag(C)))
    return model, X, truth, rng.multivariate_normal(X, C), C


def distance(X: np.ndarray, other: np.ndarray, C: np.ndarray) -> float:
    return float(np.sqrt((X - other) @ np.linalg.solve(C, X - other)))


@pytest.mark.parametrize("seed", sampled(range(12), 1, always=(5,)))
def test_the_nearest_robot_is_no_farther_than_the_true_one(seed: int) -> None:
    model, X, _, estimated, C = estimate_near_truth(seed)
    found = nearest_possible(model, estimated, C)
    assert found.distance <= distance(X, estimated, C)
    assert distance(found.X, estimated, C) == pytest.approx(found.distance, rel=1e-3, abs=1e-6)
    # A robot with these parameters exists, also for who asks again.
    assert not nearest_possible(model, found.X, C).fault
    links = symgen.link_parameters(model, estimated, nearest=C)
    assert distance(links.X, found.X, C) < 0.1
    # The same distance by another size of the covariance: the program has no scale of its own.
    half = nearest_possible(model, estimated, C / 4).distance
    assert half == pytest.approx(2 * found.distance, rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("seed", sampled(range(12), 2))
def test_friction_that_drives_is_zero_in_the_nearest_robot(seed: int) -> None:
    model, _, _, estimated, C = estimate_near_truth(seed)
    place = model.base.names.index("FV1")
    estimated[place] = -5 * np.sqrt(C[place, place])
    found = nearest_possible(model, estimated, C)
    assert found.X[place] == 0
    assert "FV1" in found.at_bound


def test_rounding_is_no_fault() -> None:
    model = symgen.derive("scara")
    X = np.array(physical_parameters(model, random.Random(2)))
    for name in ("FS1", "FV2"):
        X[model.base.names.index(name)] = -1e-13
    found = symgen.link_parameters(model, X)
    assert found.sigmas == 0
    assert (found.values["FS1"], found.values["FV2"]) == (0, 0)


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """A folder with a URDF and two logs of a joint whose viscous friction drives it."""
    folder = tmp_path_factory.mktemp("driven")
    (folder / "one.urdf").write_text(URDF)
    t = np.arange(0.0, 12.0, 0.01)
    w, a = np.array([[0.9], [2.3], [3.9]]), np.array([[0.8], [0.3], [0.1]])
    for seed, name in enumerate(("train.csv", "test.csv")):
        rng = np.random.default_rng(seed)
        phase = w * t + rng.uniform(0, 6, (3, 1))
        q, qd = (a * np.sin(phase)).sum(0), (a * w * np.cos(phase)).sum(0)
        tau = -0.5 * (a * w**2 * np.sin(phase)).sum(0) + 3 * np.tanh(qd / 0.01) - qd
        rows = np.column_stack([t, q, qd, tau + 0.02 * rng.normal(size=len(t))])
        np.savetxt(folder / name, rows, delimiter=",", header="t,q1,qd1,tau1", comments="")
    return folder


def test_a_file_that_predicts_worse_than_the_estimate_is_said(driven, command) -> None:
    urdf, test, into = driven / "one.urdf", driven / "test.csv", driven / "result"
    code, out, err = command("identify", urdf, driven / "train.csv", "--validation", test,
                             "--model", "momentum", "--into", into)  # fmt: skip
    assert code == 0, err  # friction that falls with speed still brakes
    assert not (into / "one.urdf").exists()
    assert "no URDF" in out
    estimate = symgen.read_estimate(into)
    assert not estimate.possible
    assert estimate.physical.distance_sigma > 50
    assert estimate.physical.reason.kind == "effect_missing"
    least, possible = estimate.physical.held_out
    assert possible > 1.1 * least
    written = driven / "written.urdf"
    export = ("export", into, "--from", urdf, "--to", written, "--log", test)
    code, out, err = command(*export)
    assert code == 1, err
    assert written.is_file()
    assert "--least" in out
    assert f"held-out folds of the training logs is {100 * possible:.3g}" in out
    assert command(*export, "--least", "60")[0] == 0
