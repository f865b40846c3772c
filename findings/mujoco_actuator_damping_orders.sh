#!/usr/bin/env bash
# MuJoCo 4.0.0: all orders of an actuator's damping polynomial scale with the square of its gear.
#
# An actuator of gear g turns with the speed w = g qd. A damper d1 w + d2 w |w| + d3 w^3 of the motor shaft gives the joint
# the torque g d1 (g qd) + g d2 (g qd)|g qd| + g d3 (g qd)^3: the orders scale with g^2, g^3 and g^4. MuJoCo evaluates
# the polynomial at the speed of the joint and multiplies by g^2. Coefficients from a motor's data sheet are therefore too
# small by g and by g^2: with a gear of 10, by factors of 10 and 100.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/env"
"$folder/env/bin/pip" install -q mujoco==4.0.0
"$folder/env/bin/python" - <<'EOF'
import mujoco

GEAR, D = 10.0, (0.003, 0.01, 0.02)
XML = (
    '<mujoco><option gravity="0 0 0"/><worldbody><body><joint name="j" axis="0 0 1"/>'
    '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></worldbody>'
    f'<actuator><motor joint="j" gear="{GEAR}" damping="{D[0]} {D[1]} {D[2]}"/></actuator></mujoco>'
)


def polynomial(speed):
    return D[0] * speed + D[1] * speed * abs(speed) + D[2] * speed**3


model = mujoco.MjModel.from_xml_string(XML)
data = mujoco.MjData(model)
print("MuJoCo", mujoco.__version__)
for speed in (-1.0, 0.5, 2.0):
    data.qvel[0] = speed
    mujoco.mj_inverse(model, data)
    torque = float(data.qfrc_inverse[0])
    shaft, joint = GEAR * polynomial(GEAR * speed), GEAR**2 * polynomial(speed)
    print(f"speed {speed:g}: torque {torque:.6g}; damper on the shaft {shaft:.6g}; g^2 at the joint {joint:.6g}")
    assert abs(torque - joint) < 1e-9 * abs(joint)
    assert abs(torque - shaft) > 0.5 * abs(shaft)
EOF
