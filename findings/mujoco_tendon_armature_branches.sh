#!/usr/bin/env bash
# MuJoCo 4.0.0: the armature of a fixed tendon over joints of different branches has no coupling term.
#
# A fixed tendon of length q1 - q2 with armature a adds a (qd1 - qd2)^2 / 2 to the kinetic energy, hence
# a [[1, -1], [-1, 1]] to the mass matrix. MuJoCo adds only the entries between a joint and its ancestors. For joints of
# two branches the entries off the diagonal are missing: joints that turn at equal speed, so that the tendon stands
# still, have the kinetic energy of the armature, and mj_inverse asks for torque to accelerate a tendon that does not move.
# A drive between two fingers or two wheels of one base is such a tendon. Dampers of the same tendon are coupled.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install -q mujoco==4.0.0
"$folder/env/bin/python" - <<'EOF'
import mujoco
import numpy as np

BODY = (
    '<body><joint name="{0}" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>{1}'
    "</body>"
)
TENDON = (
    '<tendon><fixed name="drive" armature="0.5" damping="0.2"><joint joint="one" coef="1"/>'
    '<joint joint="two" coef="-1"/></fixed></tendon>'
)


def armature_and_damping(bodies):
    """Return what the tendon adds to the mass matrix and to the damping matrix."""
    out = []
    for key in ("qacc", "qvel"):
        matrices = []
        for tendon in (TENDON, ""):
            model = mujoco.MjModel.from_xml_string(
                f'<mujoco><option gravity="0 0 0"/><worldbody>{bodies}</worldbody>{tendon}</mujoco>'
            )
            data, columns = mujoco.MjData(model), []
            for unit in np.eye(2):
                getattr(data, key)[:] = unit
                mujoco.mj_inverse(model, data)
                columns.append(data.qfrc_inverse.copy())
            matrices.append(np.array(columns).T)
        out.append(matrices[0] - matrices[1])
    return out


coupled = np.array([[1.0, -1.0], [-1.0, 1.0]])
chain = armature_and_damping(BODY.format("one", BODY.format("two", "")))
branches = armature_and_damping(BODY.format("one", "") + BODY.format("two", ""))
print("MuJoCo", mujoco.__version__)
print("armature, joints of a chain:", chain[0].tolist())
print("armature, joints of two branches:", branches[0].tolist())
print("damping, joints of two branches:", branches[1].tolist())
assert np.allclose(chain[0], 0.5 * coupled)
assert np.allclose(branches[1], 0.2 * coupled)
assert np.allclose(branches[0], 0.5 * np.eye(2)), "the coupling term is there now"
EOF
