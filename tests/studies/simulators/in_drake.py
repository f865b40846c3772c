"""Torques of a URDF or MJCF in Drake: python in_drake.py FILE states.json torques.json"""

import json
import logging
import sys
from importlib.metadata import version

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import DiscreteContactApproximation, MultibodyPlant
from pydrake.multibody.tree import MultibodyForces

path, states, out = sys.argv[1:]
with open(states) as file:
    given = json.load(file)
logging.disable(logging.WARNING)
with open(path) as file:
    follows = "<mimic" in file.read()  # only a discrete plant has joints that follow others
plant = MultibodyPlant(1e-3 if follows else 0.0)
if follows:
    plant.set_discrete_contact_approximation(DiscreteContactApproximation.kSap)
(robot,) = Parser(plant).AddModels(path)
if given["base"] not in ("", "world"):
    base = plant.GetBodyByName(given["base"], robot)
    plant.WeldFrames(plant.world_frame(), base.body_frame())
plant.Finalize()
moving = [plant.get_joint(j) for j in plant.GetJointIndices(robot)]
moving = [joint for joint in moving if joint.num_velocities()]
names = [joint.name() for joint in moving]
order = [given["joints"].index(name) for name in names]
q_at = [joint.position_start() for joint in moving]
v_at = [joint.velocity_start() for joint in moving]
context = plant.CreateDefaultContext()
inverse, forward = [], []
for state in given["states"]:
    values = {key: np.array(state[key])[order] for key in ("q", "qd", "qdd", "tau")}
    q, qd, qdd, tau = np.zeros((4, len(names)))
    q[q_at] = values["q"]
    qd[v_at], qdd[v_at], tau[v_at] = values["qd"], values["qdd"], values["tau"]
    plant.SetPositions(context, q)
    plant.SetVelocities(context, qd)
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    inverse.append(plant.CalcInverseDynamics(context, qdd, forces)[v_at].tolist())
    if follows:
        continue
    motors = plant.MakeActuationMatrix()  # a torque goes through the motor of its joint, if any
    of_motors = np.linalg.pinv(motors) @ tau
    plant.get_actuation_input_port().FixValue(context, of_motors)
    plant.get_applied_generalized_force_input_port().FixValue(context, tau - motors @ of_motors)
    forward.append(plant.EvalTimeDerivatives(context).CopyToVector()[len(q) :][v_at].tolist())
found = {
    "version": f"Drake {version('drake')}",
    "joints": names,
    "inverse": inverse,
}
if forward:
    found["forward"] = forward
with open(out, "w") as file:
    json.dump(found, file)
