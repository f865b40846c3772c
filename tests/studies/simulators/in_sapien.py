"""Accelerations of a URDF in SAPIEN: python in_sapien.py FILE states.json torques.json"""

import json
import sys
from importlib.metadata import version

import numpy as np
import sapien

STEP = 1e-4
path, states, out = sys.argv[1:]
with open(states) as file:
    given = json.load(file)
scene = sapien.Scene([sapien.physx.PhysxCpuSystem()])
scene.set_timestep(STEP)
loader = scene.create_urdf_loader()
loader.fix_root_link = True
robot = loader.load(path)
names = [joint.name for joint in robot.active_joints]
order = [given["joints"].index(name) for name in names]
for link in robot.links:  # air, which SAPIEN has by default
    link.linear_damping = link.angular_damping = 0
for joint in robot.active_joints:  # friction of 0.05, which SAPIEN has by default
    joint.friction = 0
forward = []
for state in given["states"]:
    q, qd, tau = (np.array([state[key][k] for k in order]) for key in ("q", "qd", "tau"))
    robot.qpos, robot.qvel, robot.qf = q, qd, tau
    scene.step()
    forward.append(((robot.qvel - qd) / STEP).tolist())
found = {"version": f"SAPIEN {version('sapien')}", "joints": names, "forward": forward}
with open(out, "w") as file:
    json.dump(found, file)
