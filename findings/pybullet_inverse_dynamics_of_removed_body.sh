#!/usr/bin/env bash
# PyBullet 3.2.7: calculateInverseDynamics of a new body returns the torques of a body that was removed before.
#
# A program loads a URDF, computes torques, removes the body and loads another robot. getDynamicsInfo has the values of the new
# robot, and calculateInverseDynamics has those of the removed one. The file cache of loadURDF is off. A comparison of
# several sets of parameters in one process finds that all give the same torques.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install -q pybullet==3.2.7 'numpy<2'
cd "$folder"
"$folder/env/bin/python" - <<'EOF'
from importlib.metadata import version

import pybullet as p

INERTIAL = (
    '<inertial><mass value="{0}"/>'
    '<inertia ixx="{0}" ixy="0" ixz="0" iyy="{0}" iyz="0" izz="{0}"/></inertial>'
)
URDF = (
    f'<robot name="arm"><link name="base">{INERTIAL}</link><link name="arm">{INERTIAL}</link>'
    '<joint name="j" type="continuous"><parent link="base"/><child link="arm"/>'
    '<axis xyz="0 0 1"/></joint></robot>'
)


def loaded(inertia):
    """Load an arm of this mass and inertia; return the body, its mass and its torque at 1 rad/s2."""
    with open("arm.urdf", "w") as file:
        file.write(URDF.format(inertia))
    body = p.loadURDF("arm.urdf", useFixedBase=True, flags=p.URDF_USE_INERTIA_FROM_FILE)
    (torque,) = p.calculateInverseDynamics(body, [0.0], [0.0], [1.0])
    return body, p.getDynamicsInfo(body, 0)[0], torque


p.connect(p.DIRECT)
p.setPhysicsEngineParameter(enableFileCaching=0)
print("PyBullet", version("pybullet"))
for removes in (False, True):
    rows = []
    for inertia in (1.0, 2.0, 3.0):
        body, mass, torque = loaded(inertia)
        rows.append((inertia, mass, round(torque, 9)))
        if removes:
            p.removeBody(body)
    print("removed before the next one:" if removes else "kept:", "(inertia, mass, torque)", rows)
    p.resetSimulation()
    p.setPhysicsEngineParameter(enableFileCaching=0)
    assert all(mass == inertia for inertia, mass, _ in rows)
    wrong = [inertia for inertia, _, torque in rows if torque != inertia]
    assert bool(wrong) == removes
EOF
