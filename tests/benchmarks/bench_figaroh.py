"""Torque error of held-out motion, and time to get there, beside FIGAROH.

    python tests/benchmarks/bench_figaroh.py --peer PYTHON [ur10 tx40]

PYTHON is that of an environment with `figaroh`. The logs are train.csv and test.csv of the robots
in the folder SYMGEN_DATA. Both identify links, rotor inertia, viscous and Coulomb friction and
offsets on train.csv. FIGAROH gets the robot as a URDF with links of 1 kg, and runs as its class
BaseIdentification does it: median filter, low-pass, differentiation, decimation, QR decomposition,
ordinary and weighted least squares. Its user chooses the low-pass. It gets each of CUTOFFS, and the
one with the least error on the test log is its result, which is more than a user can know. symgen
reads, repairs and filters the log, chooses a model and judges it with the test log: its time has
all of that; FIGAROH's has one cutoff and one method. The torque error is symgen's for both, in the
same band. FIGAROH's torque at random states becomes base parameters of symgen for it, and the
residual of that shows that both models are the same. Times are of the processor.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

DATA = Path(os.environ.get("SYMGEN_DATA", "../shared/data"))
CUTOFFS = (2.0, 4.0, 6.0, 8.0, 12.0, 16.0, 24.0)  # Hz
DECIMATION = 10  # FIGAROH's default
STATES = 400


def urdf(robot: Any) -> str:
    """Return a chain of links of 1 kg with the joints of a robot."""
    from symgen.robot import dh

    plain = robot.with_values()
    inertial = (
        '<inertial><mass value="1"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"'
        "/></inertial>"
    )
    out = ['<robot name="peer">', '<link name="l0"/>']
    for joint in plain.joints:
        gamma, b, alpha, d, theta, r = (
            float(getattr(joint, key)) for key in ("gamma", "b", "alpha", "d", "theta", "r")
        )
        pose = np.eye(4)
        for axis, angle, length in ((2, gamma, b), (0, alpha, d), (2, theta, r)):
            pose = pose @ np.asarray(dh.screw(axis, angle, length), dtype=float)
        R = pose[:3, :3]
        rpy = np.arctan2(R[2, 1], R[2, 2]), -np.arcsin(R[2, 0]), np.arctan2(R[1, 0], R[0, 0])
        words = (" ".join(repr(float(x)) for x in v) for v in (pose[:3, 3], rpy))
        xyz, turned = words
        k = joint.number
        out += [
            f'<link name="l{k}">{inertial}</link>',
            f'<joint name="j{k}" type="revolute"><parent link="l{joint.antecedent}"/>'
            f'<child link="l{k}"/><origin xyz="{xyz}" rpy="{turned}"/><axis xyz="0 0 1"/>'
            '<limit lower="-7" upper="7" effort="1e4" velocity="100"/></joint>',
        ]
    return "\n".join([*out, "</robot>"])


def peer(folder: Path) -> None:
    """Identify with FIGAROH at each cutoff; write torques at the states of a file."""
    from figaroh.identification.base_identification import BaseIdentification
    from figaroh.tools.load_robot import load_robot
    from figaroh.tools.regressor import build_regressor_basic

    given = np.load(folder / "log.npz")
    t, n = given["t"], given["q"].shape[1]
    step = float(np.median(np.diff(t)))

    class Log(BaseIdentification):  # type: ignore[misc]
        """The identification of a log at a cutoff."""

        def __init__(self, robot: Any, cutoff: float) -> None:
            self._cutoff = cutoff
            super().__init__(robot, "")

        def load_param(self, *_: Any, **__: Any) -> None:
            self.identif_config = {
                "robot_name": "peer", "has_friction": True, "has_actuator_inertia": True,
                "has_joint_offset": True, "is_joint_torques": True, "is_external_wrench": False,
                "force_torque": None, "has_coupled_wrist": False, "act_idxq": list(range(n)),
                "act_idxv": list(range(n)), "active_joints": [f"j{k + 1}" for k in range(n)],
                "ts": step, "has_custom_parameters": False, "fv": [0.0] * n, "fs": [0.0] * n,
                "Ia": [0.0] * n, "off": [0.0] * n,
                "filter_config": {
                    "differentiation_method": "central",
                    "filter_params": {"f_butter": self._cutoff, "f_sample": 1 / step},
                },
            }  # fmt: skip

        def load_trajectory_data(self) -> dict[str, Any]:
            velocities = given.get("qd")
            return {"timestamps": t, "positions": given["q"], "velocities": velocities,
                    "accelerations": None, "torques": given["tau"]}  # fmt: skip

    torques, times = [], []
    for cutoff in CUTOFFS:
        for weighted in (False, True):
            began = time.process_time()
            robot = load_robot(str(folder / "peer.urdf"), loader="figaroh")
            log = Log(robot, cutoff)
            log.initialize()
            phi = log.solve(decimation_factor=DECIMATION, plotting=False, wls=weighted)
            times.append(time.process_time() - began)
            W = build_regressor_basic(
                robot, given["at_q"], given["at_qd"], given["at_qdd"], log.identif_config
            )
            W = np.delete(W, log._idx_eliminated, 1)[:, log._base_indices]
            torques.append((W @ np.asarray(phi)).reshape(n, -1).T)
    np.savez(folder / "found.npz", tau=torques, times=times)


def main() -> None:
    """Fit both and print the errors of each on the held-out log."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--peer", default=sys.executable)
    parser.add_argument("robots", nargs="*", default=["ur10", "tx40"])
    parser.add_argument("--fit", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.fit:
        peer(given.fit)
        return
    for name in given.robots:
        compare(DATA / name, given.peer)


def compare(data: Path, python: str) -> None:
    """Print the torque errors of both on the logs of a folder."""
    import symgen
    from symgen.data.log import read_log
    from symgen.identification.prediction import torque_errors

    robot = symgen.read_robot(data / "robot.toml")
    evaluator = symgen.load(symgen.derive(robot, "all"))
    began = time.process_time()
    found = symgen.identify(robot, data / "train.csv", validation=data / "test.csv")
    own = time.process_time() - began
    n, rng = robot.n, np.random.default_rng(0)
    at_q, at_qd, at_qdd = rng.uniform(-2, 2, (3, STATES, n))
    log = read_log(data / "train.csv", robot.n)
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        (folder / "peer.urdf").write_text(urdf(robot))
        columns = {k: v for k in ("t", "q", "qd", "tau") if (v := getattr(log, k)) is not None}
        np.savez(folder / "log.npz", at_q=at_q, at_qd=at_qd, at_qdd=at_qdd, **columns)
        environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
        subprocess.run(
            [python, __file__, "--fit", folder], check=True, env=environment,
            stdout=subprocess.DEVNULL,
        )  # fmt: skip
        theirs = dict(np.load(folder / "found.npz"))
    W = evaluator.torque_regressor(at_q, at_qd, at_qdd).reshape(STATES * n, -1)
    X = [np.linalg.lstsq(W, tau.ravel(), rcond=None)[0] for tau in theirs["tau"]]
    apart = max(
        np.linalg.norm(W @ x - tau.ravel()) / np.linalg.norm(tau)
        for x, tau in zip(X, theirs["tau"], strict=True)
    )
    *errors, ours = torque_errors(robot, data / "test.csv", [*X, found.X], found.band, found.shifts)
    best = int(np.argmin(errors))
    method = "weighted" if best % 2 else "ordinary"
    print(f"{data.name}: torque error on test.csv; both models agree to {apart:.1e}")
    print(f"  symgen: {100 * ours:.3g} %, {own:.1f} s")
    print(f"  FIGAROH: {100 * errors[best]:.3g} %, {theirs['times'][best]:.1f} s, at "
          f"{CUTOFFS[best // 2]:g} Hz, {method} least squares")  # fmt: skip
    for k, cutoff in enumerate(CUTOFFS):
        print(f"    {cutoff:g} Hz: {100 * errors[2 * k]:.3g} % ordinary, "
              f"{100 * errors[2 * k + 1]:.3g} % weighted")  # fmt: skip


if __name__ == "__main__":
    main()
