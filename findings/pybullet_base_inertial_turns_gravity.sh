#!/usr/bin/env bash
# PyBullet 3.2.7: calculateInverseDynamics turns gravity by the orientation of the base's <inertial>.
#
# The <origin rpy> of an <inertial> says in which axes the six numbers of the inertia are written. For the base link of a
# robot on a fixed base, none of this has an effect on the motion, and stepSimulation has none. calculateInverseDynamics
# takes the axes of the base's <inertial> for those of the world, so gravity acts in a wrong direction: with a rotation by
# 90 degrees, the torque that holds a horizontal arm is 0.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install -q pybullet==3.2.7 'numpy<2'
cd "$folder"
"$folder/env/bin/python" - <<'EOF'
from importlib.metadata import version

import pybullet as p

STEP, ARM, G = 1e-4, 0.5, 10.0
INERTIA = '<mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
URDF = (
    f'<robot name="arm"><link name="base"><inertial><origin rpy="{{}}"/>{INERTIA}</inertial></link>'
    f'<link name="arm"><inertial><origin xyz="{ARM} 0 0"/>{INERTIA}</inertial></link>'
    '<joint name="j" type="continuous"><parent link="base"/><child link="arm"/>'
    '<axis xyz="0 1 0"/></joint></robot>'
)


def torques(k, rpy):
    """Return the torque that holds the arm, by inverse dynamics and by the motion without torque."""
    path = f"{k}.urdf"
    with open(path, "w") as file:
        file.write(URDF.format(rpy))
    robot = p.loadURDF(path, useFixedBase=True, flags=p.URDF_USE_INERTIA_FROM_FILE)
    p.setJointMotorControl2(robot, 0, p.VELOCITY_CONTROL, force=0)
    (inverse,) = p.calculateInverseDynamics(robot, [0.0], [0.0], [0.0])
    p.stepSimulation()
    acceleration = p.getJointState(robot, 0)[1] / STEP
    return inverse, -(1 + ARM**2) * acceleration


p.connect(p.DIRECT)
p.setGravity(0, 0, -G)
p.setTimeStep(STEP)
print("PyBullet", version("pybullet"))
for k, (rpy, expected) in enumerate({"0 0 0": -5.0, "1.5707963267948966 0 0": 0.0}.items()):
    inverse, forward = torques(k, rpy)
    print(f"base inertial rpy {rpy}: inverse dynamics {inverse:.4f} N m; motion {forward:.4f} N m")
    assert abs(inverse - expected) < 1e-6
    assert abs(forward + G * ARM) < 1e-2
EOF
