"""Torques of an MJCF in MuJoCo MJX: python in_mjx.py FILE states.json torques.json"""

import json
import sys
from importlib.metadata import version

import jax
import mujoco
from mujoco import mjx

jax.config.update("jax_enable_x64", True)
path, states, out = sys.argv[1:]
with open(states) as file:
    given = json.load(file)
model = mujoco.MjModel.from_xml_path(path)
for key in ("CONTACT", "LIMIT", "EQUALITY"):
    model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{key}"))
names = [model.joint(k).name for k in range(model.njnt)]
order = [given["joints"].index(name) for name in names]
ours = mjx.put_model(model)
data = mjx.make_data(ours)
evaluate = jax.jit(mjx.inverse)
inverse = []
for state in given["states"]:
    q, qd, qdd = (jax.numpy.array([state[key][k] for k in order]) for key in ("q", "qd", "qdd"))
    moved = evaluate(ours, data.replace(qpos=q, qvel=qd, qacc=qdd))
    inverse.append(moved.qfrc_inverse.tolist())
found = {"version": f"MJX {version('mujoco-mjx')}", "joints": names, "inverse": inverse}
with open(out, "w") as file:
    json.dump(found, file)
