"""Position error of exported arms with voltage servos that the recorded reference drives.

    python tests/studies/servo_simulation_study.py --seeds 2 --rate 200

Each case is an arm of random masses and drives. Four files follow the reference of a later log: the
export of an estimate from duty and a known mass; that of an estimate from the true torques of the
drives, with their true actuators; a maker's file, with masses and inertias 20 to 30 % off and usual
values of friction and servos; and the true arm. The controller of the log holds its duty for a
sample, which no file does: this is most of the error of the true arm. The last column is therefore
without it: RMS difference from the motion of the true arm, duty over torques.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from oracles import servos

import symgen
from symgen.data.drive import held
from symgen.data.raw import Log
from symgen.experiment.mujoco_robot import MujocoRobot
from symgen.experiment.playback import compare_simulations
from symgen.robot.tables import Servo


def with_servos(text: str, kp: Sequence[float], force: Sequence[float], more: str = "") -> str:
    """Return an MJCF with other actuators."""
    actuators = "".join(
        f'<position joint="joint{j}" kp="{gain!r}" forcerange="{-limit!r} {limit!r}"{more}/>'
        for j, (gain, limit) in enumerate(zip(kp, force, strict=True), 1)
    )
    return re.sub("<actuator>.*</actuator>", f"<actuator>{actuators}</actuator>", text)


def makers(arm: servos.Arm, rng: np.random.Generator) -> str:
    """Return the file of a maker."""
    off, other = 1 + rng.choice([-1, 1], (2, arm.n)) * rng.uniform(0.2, 0.3, (2, arm.n))
    usual = {key: np.full(arm.n, x) for key, x in (("rotor", 0.01), ("coulomb", 0.1))}
    wrong = replace(
        arm,
        mass=arm.mass * off,
        inertia=arm.inertia * other[:, None],
        viscous=np.full(arm.n, 0.1),
        **usual,
    )
    force = (1.1 * arm.a).tolist()
    return with_servos(servos.mjcf(wrong), [50.0] * arm.n, force, ' dampratio="1"')


def with_torques(log: Log, arm: servos.Arm) -> Log:
    """Return a log of duty as one of the torques of the drives at its stamps."""
    assert log.duty is not None
    duty = held(log.t, log.duty)
    return Log(log.name, log.t, log.q, None, duty * arm.a)


def case(kind: str, seed: int, rate: float, folder: Path) -> tuple[list[float], float]:
    """Return the errors of the files after 1 s, and the ratio of the differences."""
    rng = np.random.default_rng([seed, servos.ARMS.index(kind)])
    arm = servos.random_arm(kind, rng)
    files = [folder / f"{name}.xml" for name in ("duty", "torque", "makers", "true")]
    files[2].write_text(makers(arm, rng))
    gains = Servo((arm.gain,) * arm.n, (0.0,) * arm.n, unit="duty")
    robot = replace(symgen.read_robot(files[2]), payload=arm.n, controller=gains)
    mass, place = float(arm.mass[-1]), 1.2 * arm.centre[-1] + [0.01, 0.01, 0.01]
    train = [servos.recorded(arm, f"train{k}", rng, 60.0, rate) for k in range(2)]
    test = servos.recorded(arm, "test", rng, 30.0, rate)
    carried = servos.recorded(arm, "carried", rng, 60.0, rate, (mass, place))
    fit = symgen.FitOptions(carried=[carried], mass=mass)
    by_duty = symgen.identify(robot, train, validation=[test], fit=fit)
    logs = [with_torques(log, arm) for log in train]
    by_torque = symgen.identify(robot, logs, validation=[with_torques(test, arm)])
    for file, estimate in zip(files, (by_duty, by_torque), strict=False):
        result = folder / file.stem
        symgen.write(estimate, result, robot=robot)
        file.write_text(symgen.export(result, files[2]).text)
    true = replace(arm, viscous=arm.viscous + arm.b)
    servo = (arm.a * arm.gain).tolist(), arm.a.tolist()
    files[1].write_text(with_servos(files[1].read_text(), *servo))
    files[3].write_text(with_servos(servos.mjcf(true), *servo))
    found = compare_simulations(files, [test], robot=robot)
    assert found.driven_by == "reference"
    errors = [file.horizons[-1].position_error for file in found.files]
    return errors, _beside_the_true(files, test)


def _beside_the_true(files: Sequence[Path], log: Log) -> float:
    """Return the RMS difference of the first file from the last one, over that of the second."""
    joints = [f"joint{j + 1}" for j in range(log.q.shape[1])]
    ours, others, _, true = (_followed(file, joints, log) for file in files)
    return float(np.linalg.norm(ours - true) / np.linalg.norm(others - true))


def _followed(file: Path, joints: Sequence[str], log: Log) -> np.ndarray:
    """Return the positions of a file that follows the reference of a whole log."""
    robot, qr = MujocoRobot(file, joints), log.qr
    robot.follow()
    assert qr is not None
    bounds = np.full(len(joints), 100.0)

    def law(t: float, q: np.ndarray, qd: np.ndarray) -> np.ndarray:  # noqa: ARG001
        return qr[np.searchsorted(log.t, t, side="right") - 1]

    return robot(log.q[0], np.zeros(len(joints)), law, log.t, bounds)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--rate", type=float, default=200.0)
    parser.add_argument("--arms", nargs="*", default=servos.ARMS)
    args = parser.parse_args()
    print("arm   seed   duty %  torque %  maker %  true %  duty/torque  duty/maker  difference")
    for kind in args.arms:
        for seed in range(args.seeds):
            with TemporaryDirectory() as folder:
                errors, ratio = case(kind, seed, args.rate, Path(folder))
            ours, torque, maker, true = (100 * x for x in errors)
            print(
                f"{kind:6}{seed:4}{ours:9.4f}{torque:10.4f}{maker:9.3f}{true:8.4f}"
                f"{ours / torque:13.3f}{ours / maker:12.3f}{ratio:12.2f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
