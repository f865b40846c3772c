"""Accelerations of Newton's Featherstone: python in_newton.py FILE states.json torques.json"""

import json
import sys

import newton
import numpy as np

STEP = 1e-3
path, states, out = sys.argv[1:]
with open(states) as file:
    given = json.load(file)
builder = newton.ModelBuilder()
if path.endswith(".urdf"):
    builder.add_urdf(path, floating=False)
else:
    builder.add_mjcf(path)
model = builder.finalize(device="cpu")
solver = newton.solvers.SolverFeatherstone(model)
moving = np.diff(model.joint_qd_start.numpy()) > 0
names = [label.split("/")[-1] for label, on in zip(model.joint_label, moving, strict=True) if on]
order = [given["joints"].index(name) for name in names]
forward = []
for state in given["states"]:
    q, qd, tau = (np.array([state[key][k] for k in order], "f") for key in ("q", "qd", "tau"))
    before, after, control = model.state(), model.state(), model.control()
    before.joint_q.assign(q)
    before.joint_qd.assign(qd)
    control.joint_f.assign(tau)
    newton.eval_fk(model, before.joint_q, before.joint_qd, before)
    solver.step(before, after, control, None, STEP)
    forward.append(((after.joint_qd.numpy() - qd) / STEP).tolist())
version = f"Newton {newton.__version__}, Featherstone"
with open(out, "w") as file:
    json.dump({"version": version, "joints": names, "forward": forward}, file)
