"""From a table to parameters

The robot of Gautier and Khalil's paper (1988): two revolute joints, gravity along the first axis.
Its model is derived in closed form, its minimal parameters are proved, a noisy log is simulated,
and the parameters are found again from that log.
"""

# ## The model
# A robot is a table of modified Denavit-Hartenberg parameters; this one is in the library.

import numpy as np

import symgen

robot = symgen.read_robot("planar2r")
model = symgen.derive(robot, "all")

# Of 20 standard parameters four remain that the motion can tell, each a formula in the others and
# in the length L1. Their number is the exact rank of the energy columns, taken modulo two primes.

for p in model.base.parameters:
    print(f"{p.name:5} = {p.expression:16} {p.unit}")
print("rank", model.base.proof.rank, "of", len(model.base.standard), "standard parameters")

# ## A log
# X holds the values of these parameters. A computed-torque controller follows a seeded Fourier
# series; encoders have steps of 0.1 mrad, tachometers and torques have noise. Joint speeds are
# measured, as on the paper's robot.

X = np.array([3.5, 0.06, 0.124, 0.006])
seen = symgen.Instruments(encoder_step=1e-4, velocity_noise=2e-3, torque_noise=0.02)
made = symgen.Recording(seen, rate=500.0)
done = symgen.simulate(robot, X, duration=20.0, runs=2, seed=1, recording=made)
train, test = done.log(0), done.log(1)

# ## The estimate
# Energy, momentum and torque equations are made from the same filtered log; the model with the
# smallest torque error on folds that its fit did not see is the estimate. It is judged on the
# second log, which no fit saw.

estimate = symgen.identify(robot, [train], validation=[test])
print("verdict:", estimate.verdict)
for p, true in zip(estimate.parameters, X, strict=True):
    print(f"{p.name:5} {p.value:8.4f} +- {2 * p.std:.4f}   true {true}")

# Every true value lies within three standard deviations.

off = np.abs(estimate.X - X) / np.array([p.std for p in estimate.parameters])
assert estimate.verdict == "trusted"
assert off.max() < 3

# ## The model at work
# The compiled kernels evaluate one sample, or many at once: here what the identified model says of
# the second run, beside the torque that moved it.

dynamics = symgen.load(model)
acceleration = np.gradient(done.qd[1], done.t, axis=0)
tau = dynamics["inverse_dynamics"](done.q[1], done.qd[1], acceleration, estimate.X)
error = np.linalg.norm((tau - done.tau[1])[5:-5]) / np.linalg.norm(done.tau[1][5:-5])
print(f"torque error on the second run: {100 * error:.2f} %")
assert error < 0.01
