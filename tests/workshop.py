"""What the pages take for granted: an arm, its logs, its estimate, and robots in other formats."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
from documented import DOCS, blocks
from oracles import gripper_arm, wrist
from oracles.bags import State, write_bag, write_mcap
from support import PROJECT
from support_commands import URDF

import symgen
from symgen.experiment.reference import fourier

VALUES = {"ZZ1R": 1.9, "MX1R": 2.9, "MY1": 0.04, "FS1": 1.5, "FV1": 0.9, "ZZ2": 0.3, "MX2": 0.75,
          "MY2": 0.02, "IA2": 0.2, "FS2": 0.8, "FV2": 0.5, "OF2": 0.1}  # fmt: skip
MASS, AT = 2.0, 0.3
_MJCF = """<mujoco model="mjarm"><worldbody><body name="upper"><joint name="shoulder" axis="0 1 0"/>
<inertial pos="0.1 0 0.2" mass="2" diaginertia="0.05 0.06 0.02"/></body></worldbody></mujoco>"""


def furnish(folder: Path) -> None:
    """Put them into a folder; `arm.toml` is the one that the page on robots shows."""
    robot_page = DOCS / "robot-files.md"
    arm = next(b.code for b in blocks(robot_page) if b.file == "arm.toml")
    (folder / "arm.toml").write_text(arm)
    drive = "[drive]\ntorque_constant = [1.0, 1.0]\n"
    (folder / "geared.toml").write_text(f"{arm}\n{drive}")
    robot = symgen.read_robot(folder / "arm.toml")
    model = symgen.derive(robot, ("inverse_dynamics",))
    names, dynamics = model.base.names, symgen.load(model)
    (folder / "P.toml").write_text(
        "[parameters]\n" + "".join(f"{name} = {VALUES[name]}\n" for name in names)
    )
    carried = VALUES | {
        "ZZ2": VALUES["ZZ2"] + MASS * AT**2, "MX2": VALUES["MX2"] + MASS * AT,
        "ZZ1R": VALUES["ZZ1R"] + MASS * 0.25, "MX1R": VALUES["MX1R"] + MASS * 0.5,
    }  # fmt: skip
    rng = np.random.default_rng(7)
    for file, values, seed in (("train", VALUES, 1), ("test", VALUES, 2), ("empty", VALUES, 1),
                               ("carried", carried, 1)):  # fmt: skip
        motion = fourier(robot, duration=10.0, rate=200.0, seed=seed)
        t, q, qd = motion.t, motion.q, motion.qd
        tau = dynamics["inverse_dynamics"](q, qd, motion.qdd, [values[name] for name in names])
        q, qd, tau = (
            x + size * rng.standard_normal(x.shape)
            for x, size in ((q, 1e-5), (qd, 1e-3), (tau, 0.1))
        )
        table = np.column_stack([t, q, qd, tau])
        columns = "t,q1,q2,qd1,qd2,tau1,tau2"
        _write(folder / f"{file}.csv", columns, table)
        if file == "train":
            _write(folder / "trajectory.csv", "t,q1,q2", np.column_stack([t, motion.q]))
            _write(folder / "measured.csv", "t,tau1,tau2", table[:200, [0, 5, 6]])
            _write(folder / "run.csv", "time,shoulder,elbow,m_s,m_e", table[:, [0, 1, 2, 5, 6]])
            _write(folder / "a.csv", columns, table)
            (folder / "recorder.csv").write_text(_german(t, q, tau))
        if file == "test":
            _write(folder / "b.csv", columns, table)
    states = [
        State(round(1e9 * t), ("shoulder_joint", "elbow_joint"), q, qd, tau)
        for t, q, qd, tau in zip(t, q, qd, tau, strict=True)
    ]
    try:
        write_bag(folder / "bag", {"/joint_states": states}, "sqlite3")
        write_mcap(folder / "run.mcap", {"/joint_states": states, "/other": states[:9]})
    except ImportError:  # blocks that need them are left out
        shutil.rmtree(folder / "bag", ignore_errors=True)
    estimate = symgen.identify(folder / "arm.toml", [folder / "train.csv"],
                               validation=[folder / "test.csv"])  # fmt: skip
    from symgen.report.store import result_files

    (folder / "result").mkdir()
    for path, content in result_files(estimate, robot).items():
        (folder / "result" / path).write_bytes(content)
    wrist_page = DOCS / "wrist.md"
    robot_of_page = next(b.code for b in blocks(wrist_page) if b.file == "ur.toml")
    (folder / "ur.toml").write_text(robot_of_page)
    log, _ = wrist.recorded(wrist.tool(1.5), 3, wrist.NOISE, poses=8, rest=1.5, swing=6, rate=125)
    columns = "t,q1,q2,q3,q4,q5,q6,wfx,wfy,wfz,wnx,wny,wnz"
    _write(folder / "tool.csv", columns, np.column_stack([*log.values()]))
    (folder / "panda.urdf").write_text(gripper_arm.urdf())
    (folder / "panda_true.toml").write_text((DOCS / "files" / "panda_true.toml").read_text())
    (folder / "ur5.urdf").write_text(URDF)
    (folder / "rx90.par").write_text(_par())
    (folder / "scene").mkdir()
    (folder / "scene" / "arm.xml").write_text(_MJCF)


def _par() -> str:
    from unit.test_par import ARM

    return ARM


def _german(t: np.ndarray, q: np.ndarray, tau: np.ndarray) -> str:
    """Return a log in ms and degrees, with semicolons and decimal commas."""
    lines = [
        "Zeit [ms];joint_1 pos [deg];joint_2 pos [deg];joint_1 torque [Nm];joint_2 torque [Nm]"
    ]
    for row in np.column_stack([1000 * t, np.degrees(q), tau]):
        lines.append(";".join(f"{x:.5f}" for x in row).replace(".", ","))
    return "\n".join(lines) + "\n"


def _write(path: Path, columns: str, table: np.ndarray) -> None:
    rows = [columns, *(",".join(f"{x:.9g}" for x in row) for row in table)]
    path.write_text("\n".join(rows) + "\n")


def house(folder: Path) -> None:
    """Show the tree from a folder, as who contributes sees it; what is generated goes there."""
    for name in ("pyproject.toml", "tests", "symgen", "templates", "docs"):
        (folder / name).symlink_to(PROJECT / name)
