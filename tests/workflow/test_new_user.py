"""A new user's path: a URDF with fingers and a recorder's CSV, six commands, a trusted model.

The commands are those of the quick start, read from its page. The first is what everybody tries;
each refusal names the next one.
"""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from documented import DOCS, blocks
from support import PROJECT

pytest.importorskip("pinocchio", reason="Pinocchio (PyPI: pin) is not installed")
pytest.importorskip("clarabel", reason="Clarabel is not installed")

HEAVIER, TOOL = 1.15, (2.0, (0.02, 0.0, 0.2))


def test_six_commands_from_a_urdf_and_a_log_to_a_trusted_model(
    tmp_path, command, monkeypatch
) -> None:
    from oracles import gripper_arm
    from oracles.pinocchio_arm import load_pinocchio

    monkeypatch.chdir(tmp_path)
    (tmp_path / "panda.urdf").write_text(gripper_arm.urdf())
    moves = gripper_arm.urdf(HEAVIER)  # than its maker says
    (tmp_path / "train.csv").write_text(gripper_arm.recorded(moves, 1))
    (tmp_path / "test.csv").write_text(gripper_arm.recorded(moves, 2))
    (tmp_path / "carried.csv").write_text(gripper_arm.recorded(gripper_arm.urdf(HEAVIER, TOOL), 3))
    lines = _quick_start()
    assert len(lines) == 6

    def run(line: str, expected: int = 0) -> str:
        code, out, err = command(*line.split()[1:])
        assert code == expected, err
        return out + err

    said = run(lines[0], expected=2)
    helps = re.search(r"symgen import panda.urdf --fix \S+ --into robot.toml", said)
    assert helps is not None, said
    assert lines[1] == helps[0]
    run(lines[1])
    said = run(lines[2])
    assert "columns by name: t = time, q = *_position, qd = *_velocity, tau = *_effort" in said
    assert "stamps jitter" in said
    assert "verdict: trusted" in said
    for line in lines[3:]:
        run(line)

    estimate = json.loads((tmp_path / "result" / "estimate.json").read_text())
    assert estimate["verdict"] == "trusted"
    assert estimate["torque_residual"]["validation"]["relative"] < 0.02
    assert (tmp_path / "result" / "report.html").stat().st_size > 10_000
    assert (tmp_path / "generated" / "panda" / "panda.h").is_file()
    carried = json.loads((tmp_path / "load" / "payload.json").read_text())
    assert abs(carried["mass"]["value"] / TOOL[0] - 1) < 0.015

    pin = load_pinocchio()
    written = (tmp_path / "identified.urdf").read_text()
    want, new, maker = (_weights(pin, t) for t in (moves, written, gripper_arm.urdf()))
    assert np.abs(new - want).max() < 0.02 * np.abs(want).max()
    assert np.abs(maker - want).max() > 0.1 * np.abs(want).max()  # what was to be learned


def _quick_start() -> list[str]:
    """Return the commands of the page, which are those of the README."""
    page = DOCS / "quick-start.md"
    block = next(b for b in blocks(page) if b.elsewhere.endswith("test_new_user.py"))
    assert block.code in (PROJECT / "README.md").read_text("utf-8")
    return block.code.splitlines()


def _weights(pin, text: str) -> np.ndarray:
    """Torques of gravity of a URDF on joints 1 to 7 in 20 poses, by Pinocchio; fingers closed."""
    model = pin.buildModelFromXML(text)
    data = model.createData()
    poses = np.random.default_rng(9).uniform(-1, 1, (20, 7)) + np.array([0, 0, 0, -1.5, 0, 1.8, 0])
    return np.array([
        pin.computeGeneralizedGravity(model, data, np.append(q, [0.0, 0.0]))[:7] for q in poses
    ])  # fmt: skip
