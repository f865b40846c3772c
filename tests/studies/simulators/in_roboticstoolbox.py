"""Torques of a URDF in the Robotics Toolbox: python in_... FILE states.json torques.json"""

import json
import os
import sys
from importlib.metadata import version

from roboticstoolbox import ERobot

path, states, out = sys.argv[1:]
with open(states) as file:
    given = json.load(file)
robot = ERobot.URDF(os.path.abspath(path))
moving = sorted((x for x in robot.links if x.isjoint), key=lambda link: link.jindex)
names = [link._joint_name for link in moving]
order = [given["joints"].index(name) for name in names]
inverse = []
for state in given["states"]:
    q, qd, qdd = ([state[key][k] for k in order] for key in ("q", "qd", "qdd"))
    inverse.append(robot.rne(q, qd, qdd, gravity=[0, 0, -9.81]).tolist())
found = {
    "version": f"Robotics Toolbox {version('roboticstoolbox-python')}",
    "joints": names,
    "inverse": inverse,
}
with open(out, "w") as file:
    json.dump(found, file)
