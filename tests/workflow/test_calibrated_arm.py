"""Identification of an arm as a calibration leaves it, beside the arm that its maker drew."""

import numpy as np
import pytest
from oracles.calibrated import calibrated_urdf
from oracles.urdf_arm import PinocchioUrdf

import symgen

pytest.importorskip("pinocchio", reason="Pinocchio (PyPI: pin) is not installed")
STEP, SAMPLES, HARMONICS = 0.004, 6000, 5  # s
COULOMB, VISCOUS, NOISE = 2.0, 1.0, 0.01


def motion(seed, joints):
    """Return t and q, qd, qdd of a Fourier series of 10 s."""
    draw, t = np.random.default_rng(seed), STEP * np.arange(SAMPLES)
    q, qd, qdd = np.zeros((3, SAMPLES, joints))
    for k in range(1, HARMONICS + 1):
        w = 0.2 * np.pi * k
        a, b = draw.uniform(-0.8, 0.8, (2, joints)) / k
        c, s = np.cos(w * t)[:, None], np.sin(w * t)[:, None]
        q += a * s + b * c
        qd += w * (a * c - b * s)
        qdd -= w**2 * (a * s + b * c)
    return t, q, qd, qdd


def recorded(text, seed, noise, path):
    """Write a log with the torques of Pinocchio and friction; return its path."""
    arm, draw = PinocchioUrdf(text), np.random.default_rng(seed + 100)
    t, q, qd, qdd = motion(seed, len(arm.joints))
    state = zip(q, qd, qdd, strict=True)
    tau = np.array([arm.pin.rnea(arm.model, arm.data, *x) for x in state])
    tau += COULOMB * np.sign(qd) + VISCOUS * qd
    tau += noise * np.sqrt(np.mean(tau**2, axis=0)) * draw.standard_normal(tau.shape)
    np.savez(path, t=t, q=q, qd=qd, tau=tau)
    return path


@pytest.mark.slow
@pytest.mark.parametrize("seed", [8, 9])
def test_errors_of_the_geometry_cost_neither_condition_nor_prediction(tmp_path, seed):
    drawn = symgen.read_robot("ur10e")
    found = []
    for number, errors in enumerate([(), (0.7e-3, 0.5e-3, seed)]):
        path = tmp_path / f"arm{number}.urdf"
        path.write_text(calibrated_urdf(drawn, *errors).replace("continuous", "revolute"), "utf-8")
        text = path.read_text("utf-8")
        train, test, clean = (
            recorded(text, kind, noise, tmp_path / f"{number}{kind}{noise}.npz")
            for kind, noise in ((1, NOISE), (2, NOISE), (1, 0.0))
        )
        robot = symgen.read_robot(path)
        estimate = symgen.identify(robot, [train], validation=[test], model="torque")
        truth = symgen.identify(robot, [clean], validation=[test], model="torque")
        assert estimate.possible
        far = np.abs(estimate.X - truth.X) / [p.std for p in estimate.parameters]
        assert far.max() < 4
        found.append(estimate)
    nominal, calibrated = found
    assert calibrated.condition_number < 1.2 * nominal.condition_number
    theirs, ours = (np.array(e.torque_validation.per_joint) for e in found)
    assert np.all(ours < 1.05 * theirs), ours / theirs
