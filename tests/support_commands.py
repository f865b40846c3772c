"""What tests of whole commands need: a terminal, parameters of planar2r, a URDF, limits."""

from __future__ import annotations

import os
import re
import struct
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

PARAMETERS = "[parameters]\nZZ1R = 3.5\nZZ2 = 0.06\nMX2 = 0.124\nMY2 = 0.006\n"
URDF = """<robot name="one"><link name="a"/><link name="b"><inertial><mass value="1"/>
<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit effort="1" velocity="1" lower="-1" upper="1"/></joint></robot>
"""
LIMITS = "--position 1 --velocity 2 --acceleration 8 --torque 100".split()
LOADED = "[parameters]\nZZ1R = 4.0\nZZ2 = 0.24\nMX2 = 0.724\nMY2 = 0.006\n"  # 2 kg at 0.3 m


def in_terminal(
    typed: list[str], width: int = 80, folder: Path | None = None, **environment: str
) -> str:
    """Return what a terminal of this width shows of a command, without colours."""
    fcntl, pty, termios = map(pytest.importorskip, ("fcntl", "pty", "termios"))
    ours, its = pty.openpty()
    fcntl.ioctl(its, termios.TIOCSWINSZ, struct.pack("HHHH", 40, width, 0, 0))
    own = {key: value for key, value in os.environ.items() if key != "COLUMNS"} | environment
    command = [sys.executable, "-m", "symgen", *typed]
    process = subprocess.Popen(command, stdout=its, stderr=subprocess.PIPE, env=own, cwd=folder)
    os.close(its)
    text = b""
    with suppress(OSError):  # how a terminal ends
        while more := os.read(ours, 65536):
            text += more
    os.close(ours)
    _, err = process.communicate(timeout=120)
    assert process.returncode in (0, 1), err
    return re.sub(r"\x1b\[[0-9;]*m", "", text.decode().replace("\r", ""))
