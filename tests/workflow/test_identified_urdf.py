"""identify on a URDF writes it again with link parameters that move as the estimate says."""

from __future__ import annotations

import re
import subprocess
import sys

import numpy as np
import pytest

import symgen

URDF = """<?xml version="1.0"?>
<!-- an arm -->
<robot name="two-link">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="0.1 0.02 0.2"/><mass value="2.0"/>
    <inertia ixx="0.05" ixy="0.001" ixz="0" iyy="0.06" iyz="0" izz="0.02"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 0.15" rpy="0.1 0 0"/><mass value="1.2"/>
    <inertia ixx="0.02" ixy="0" ixz="0.001" iyy="0.02" iyz="0" izz="0.005"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.3" rpy="0 0.4 0"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="3"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0.05 0.4"/><axis xyz="1 0 0"/>
    <limit lower="-2" upper="2" effort="50" velocity="3"/></joint>
</robot>
"""


def test_the_written_urdf_has_the_torques_of_the_estimate(tmp_path) -> None:
    pytest.importorskip("pinocchio", reason="Pinocchio (pin) is not installed")
    from oracles.pinocchio_arm import load_pinocchio

    pin = load_pinocchio()
    path = tmp_path / "arm.urdf"
    path.write_text(URDF)
    robot = symgen.read_robot(path)
    model = symgen.derive(robot, ("inverse_dynamics", "gravity_torque", "mass_matrix"))
    evaluator = symgen.load(model)
    # The robot is heavier than its CAD says, and has rotors and friction that this does not know.
    true = 1.2 * _cad(path, model)
    names = list(model.base.names)
    for name, value in (("FS1", 0.4), ("FV1", 0.7), ("FS2", 0.9), ("FV2", 0.2)):
        true[names.index(name)] = value
    true[names.index("ZZ1R")] += 0.3
    t = np.arange(0, 12, 0.004)
    w = np.array([[1.3, 2.9, 4.1], [1.7, 2.3, 5.3]])
    q = np.stack([sum(0.4 * np.sin(k * t + i) for k in w[i]) for i in range(2)], 1)
    qd = np.stack([sum(0.4 * k * np.cos(k * t + i) for k in w[i]) for i in range(2)], 1)
    qdd = np.stack([sum(-0.4 * k * k * np.sin(k * t + i) for k in w[i]) for i in range(2)], 1)
    tau = evaluator["inverse_dynamics"](q, qd, qdd, true)
    log = tmp_path / "log.csv"
    table = np.column_stack([t, q, qd, tau])
    np.savetxt(log, table, delimiter=",", header="t,q1,q2,qd1,qd2,tau1,tau2", comments="")
    command = [sys.executable, "-m", "symgen", "identify", str(path), str(log)]
    command += ["--model", "momentum", "--into", str(tmp_path / "out")]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    assert "base parameters do not determine link parameters" in done.stdout
    written = (tmp_path / "out" / "two_link.urdf").read_text()
    assert "<!-- an arm -->" in written
    assert "do not determine" in written
    assert _rest(written) == _rest(URDF)
    again = tmp_path / "again.urdf"
    export = [sys.executable, "-m", "symgen", "export", str(tmp_path / "out")]
    export += ["--from", str(path), "--to", str(again)]
    done = subprocess.run(export, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    text, _, mark = again.read_text().rstrip().rpartition("\n")
    assert text == written.rstrip()
    assert mark.startswith("<!-- written by symgen, digest ")
    X = _cad(tmp_path / "out" / "estimate.json", model)
    np.testing.assert_allclose(X, true, atol=0.01 * np.abs(true).max())
    np.testing.assert_allclose(_cad(again, model), X, rtol=1e-9, atol=1e-9)
    links = pin.buildModelFromXML(written)
    np.testing.assert_allclose(links.friction, X[[names.index(n) for n in ("FS1", "FS2")]])
    np.testing.assert_allclose(links.damping, X[[names.index(n) for n in ("FV1", "FV2")]])
    data = links.createData()
    rest = np.zeros(2)
    # Pinocchio does not read the inertia of rotors.
    rotors = np.diag([float(v) for v in re.findall(r'armature="(.*?)"', written)])
    assert rotors.shape == (2, 2)
    for k in range(0, len(t), 500):
        weight = pin.rnea(links, data, q[k], rest, rest)
        np.testing.assert_allclose(weight, evaluator["gravity_torque"](q[k], X), atol=1e-9)
        M = pin.crba(links, data, q[k]) + rotors
        np.testing.assert_allclose(M, evaluator["mass_matrix"](q[k], X), atol=1e-9)


def _rest(text: str) -> str:
    """All of a URDF but the elements that an estimate sets."""
    text = re.sub(r"\s*<inertial\b.*?</inertial>", "", text, flags=re.DOTALL)
    text = re.sub(r"\s*<dynamics [^>]*>", "", text).replace("></link>", "/>")
    return re.sub(r"\s+", "", text)


def _cad(path, model) -> np.ndarray:
    from symgen.identification.parameters import read_parameters

    return read_parameters(path, model)
