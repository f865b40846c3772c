"""Torques of a URDF in PyBullet: python in_pybullet.py FILE states.json torques.json"""

import json
import sys
from importlib.metadata import version

import pybullet as p

STEP = 1e-5
path, states, out = sys.argv[1:]
with open(states) as file:
    given = json.load(file)
p.connect(p.DIRECT)
p.setGravity(0, 0, -9.81)
p.setTimeStep(STEP)
robot = p.loadURDF(path, useFixedBase=True, flags=p.URDF_USE_INERTIA_FROM_FILE)
infos = [p.getJointInfo(robot, k) for k in range(p.getNumJoints(robot))]
joints = [info[0] for info in infos if info[2] != p.JOINT_FIXED]
names = [info[1].decode() for info in infos if info[2] != p.JOINT_FIXED]
order = [given["joints"].index(name) for name in names]
for link in range(-1, len(infos)):  # air, which PyBullet has by default
    p.changeDynamics(robot, link, linearDamping=0, angularDamping=0)
for joint in joints:  # a brake of 1 N m, which PyBullet has by default
    p.setJointMotorControl2(robot, joint, p.VELOCITY_CONTROL, force=0)


def step(q, qd, tau):
    """Return the acceleration of one step."""
    for joint, x, v in zip(joints, q, qd, strict=True):
        p.resetJointState(robot, joint, x, v)
    p.setJointMotorControlArray(robot, joints, p.TORQUE_CONTROL, forces=tau)
    p.stepSimulation()
    return [(p.getJointState(robot, j)[1] - v) / STEP for j, v in zip(joints, qd, strict=True)]


inverse, forward = [], []
for state in given["states"]:
    q, qd, qdd, tau = ([state[key][k] for k in order] for key in ("q", "qd", "qdd", "tau"))
    inverse.append(p.calculateInverseDynamics(robot, q, qd, qdd))
    forward.append(step(q, qd, tau))
found = {
    "version": f"PyBullet {version('pybullet')}",
    "joints": names,
    "inverse": inverse,
    "forward": forward,
}
with open(out, "w") as file:
    json.dump(found, file)
