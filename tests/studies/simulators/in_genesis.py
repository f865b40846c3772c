"""Accelerations of a URDF or MJCF in Genesis: python in_genesis.py FILE states.json torques.json"""

import json
import sys

import genesis as gs
import numpy as np

STEP = 1e-4
path, states, out = sys.argv[1:]
with open(states) as file:
    given = json.load(file)
gs.init(backend=gs.cpu, precision="64", logging_level="error")
options = gs.options.SimOptions(dt=STEP, gravity=(0, 0, -9.81))
scene = gs.Scene(sim_options=options, show_viewer=False)
kind = gs.morphs.MJCF(file=path) if path.endswith(".xml") else gs.morphs.URDF(file=path, fixed=True)
robot = scene.add_entity(kind)
scene.build()
names = [joint.name for joint in robot.joints if joint.n_dofs == 1]
order = [given["joints"].index(name) for name in names]
forward = []
for state in given["states"]:
    q, qd, tau = (np.array([state[key][k] for k in order]) for key in ("q", "qd", "tau"))
    robot.set_dofs_position(q)
    robot.set_dofs_velocity(qd)
    robot.control_dofs_force(tau)
    scene.step()
    forward.append(((np.array(robot.get_dofs_velocity()) - qd) / STEP).tolist())
found = {"version": f"Genesis {gs.__version__}", "joints": names, "forward": forward}
with open(out, "w") as file:
    json.dump(found, file)
