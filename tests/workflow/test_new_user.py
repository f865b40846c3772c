"""A new user's path: a URDF with fingers and a recorder's CSV, six commands, a trusted model.

The commands are those of the quick start, read from its page. The first is what everybody tries;
each refusal names the next one. They run with the declared dependencies alone, as in a new
environment. `pytest -m slow tests/robustness/test_installed.py` runs them from an installed wheel.
"""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
from declared import declared
from documented import DOCS, blocks

pytest.importorskip("pinocchio", reason="Pinocchio (PyPI: pin) is not installed")

HEAVIER, TOOL = 1.15, (2.0, (0.02, 0.0, 0.2))


@pytest.mark.slow
def test_six_commands_from_a_urdf_and_a_log_to_a_trusted_model(tmp_path) -> None:
    from oracles import gripper_arm
    from oracles.pinocchio_arm import load_pinocchio

    (tmp_path / "site").mkdir()
    lines, said = six_commands(tmp_path, *declared(tmp_path / "site"))
    assert "columns by name: t = time, q = *_position, qd = *_velocity, tau = *_effort" in said[2]
    assert "time stamps jitter" in said[2]
    assert "verdict: trusted" in said[2]
    helps = re.search(r"symgen import panda.urdf --fix \S+ --into robot.toml", said[0])
    assert helps is not None, said[0]
    assert lines[1] == helps[0]

    estimate = json.loads((tmp_path / "result" / "estimate.json").read_text())
    assert estimate["verdict"] == "trusted"
    assert estimate["torque_residual"]["validation"]["relative"] < 0.02
    assert (tmp_path / "result" / "report.html").stat().st_size > 10_000
    assert (tmp_path / "generated" / "panda" / "panda.h").is_file()
    carried = json.loads((tmp_path / "load" / "payload.json").read_text())
    assert abs(carried["mass"]["value"] / TOOL[0] - 1) < 0.015

    pin = load_pinocchio()
    written = (tmp_path / "identified.urdf").read_text()
    moves = gripper_arm.urdf(HEAVIER)
    want, new, maker = (_weights(pin, t) for t in (moves, written, gripper_arm.urdf()))
    assert np.abs(new - want).max() < 0.02 * np.abs(want).max()
    assert np.abs(maker - want).max() > 0.1 * np.abs(want).max()  # what was to be learned


def six_commands(
    folder: Path, symgen: list[str], environment: dict[str, str]
) -> tuple[list[str], list[str]]:
    """Identify with fingers, which has to stop, and run the commands of the page.

    Returns:
        The commands and what they print.
    """
    from oracles import gripper_arm

    (folder / "panda.urdf").write_text(gripper_arm.urdf())
    moves = gripper_arm.urdf(HEAVIER)  # than its maker says
    (folder / "train.csv").write_text(gripper_arm.recorded(moves, 1))
    (folder / "test.csv").write_text(gripper_arm.recorded(moves, 2))
    (folder / "carried.csv").write_text(gripper_arm.recorded(gripper_arm.urdf(HEAVIER, TOOL), 3))
    first = "symgen identify panda.urdf train.csv --validation test.csv --into result"
    lines, said = [first, *_quick_start()], []
    for k, line in enumerate(lines):
        done = subprocess.run(
            [*symgen, *line.split()[1:]],
            cwd=folder, env=environment, capture_output=True, text=True,
        )  # fmt: skip
        assert done.returncode == (2 if k == 0 else 0), (line, done.stdout, done.stderr)
        said.append(done.stdout + done.stderr)
    return lines, said


def _quick_start() -> list[str]:
    """Return the commands of the page for a robot of one's own."""
    page = DOCS / "quick-start.md"
    block = next(b for b in blocks(page) if b.elsewhere.endswith("test_new_user.py"))
    return block.code.splitlines()


def _weights(pin, text: str) -> np.ndarray:
    """Torques of gravity of a URDF on joints 1 to 7 in 20 poses, by Pinocchio; fingers closed."""
    model = pin.buildModelFromXML(text)
    data = model.createData()
    poses = np.random.default_rng(9).uniform(-1, 1, (20, 7)) + np.array([0, 0, 0, -1.5, 0, 1.8, 0])
    return np.array([
        pin.computeGeneralizedGravity(model, data, np.append(q, [0.0, 0.0]))[:7] for q in poses
    ])  # fmt: skip
