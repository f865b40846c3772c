"""Torques of a URDF or MJCF in MuJoCo: python in_mujoco.py FILE states.json torques.json"""

import json
import sys

import mujoco

path, states, out = sys.argv[1:]
with open(states) as file:
    given = json.load(file)
model = mujoco.MjModel.from_xml_path(path)
for key in ("CONTACT", "LIMIT", "EQUALITY"):
    model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{key}"))
data = mujoco.MjData(model)
names = [model.joint(k).name for k in range(model.njnt)]
order = [given["joints"].index(name) for name in names]
losses = (model.dof_frictionloss.copy(), model.tendon_frictionloss.copy())
inverse, forward, friction = [], [], []
for state in given["states"]:
    data.qpos[:], data.qvel[:], data.qacc[:], tau = (
        [state[key][k] for k in order] for key in ("q", "qd", "qdd", "tau")
    )
    model.dof_frictionloss[:], model.tendon_frictionloss[:] = losses
    mujoco.mj_inverse(model, data)
    with_friction = data.qfrc_inverse.copy()
    model.dof_frictionloss[:] = model.tendon_frictionloss[:] = 0
    mujoco.mj_inverse(model, data)
    inverse.append(data.qfrc_inverse.tolist())
    friction.append((with_friction - data.qfrc_inverse).tolist())
    if model.nu == model.nv:  # one motor on each joint
        data.ctrl[:] = tau / model.actuator_gear[:, 0]
    else:
        data.qfrc_applied[:] = tau
    mujoco.mj_forward(model, data)
    forward.append(data.qacc.tolist())
found = {
    "version": f"MuJoCo {mujoco.__version__}",
    "joints": names,
    "inverse": inverse,
    "forward": forward,
    "friction": friction,
}
with open(out, "w") as file:
    json.dump(found, file)
