"""Table to parameters in Python

This example derives the model of a robot, simulates a noisy log, and identifies the parameters
from it. The robot is that of Gautier and Khalil (1988): two revolute joints, gravity along the
first axis.
"""

# ## The model
# A robot is a table of modified Denavit-Hartenberg parameters. This one is in the library.

import numpy as np

import symgen

robot = symgen.read_robot("planar2r")
model = symgen.derive(robot, "all")

# The links have 20 standard parameters. Only four combinations of them act on the motion: the base
# parameters. The proof is the exact rank of the energy columns, modulo two primes.

for p in model.base.parameters:
    print(f"{p.name:5} = {p.expression:16} {p.unit}")
print("rank", model.base.proof.rank, "of", len(model.base.standard), "standard parameters")

# ## A log
# X holds the values of these parameters. A controller follows a random Fourier series. The encoders
# have steps of 0.1 mrad; speeds and torques have noise. The second run repeats the motion with
# other noise.

X = np.array([3.5, 0.06, 0.124, 0.006])
seen = symgen.Instruments(encoder_step=1e-4, velocity_noise=2e-3, torque_noise=0.02)
made = symgen.Recording(seen, rate=500.0)
done = symgen.simulate(robot, X, duration=20.0, runs=2, seed=1, recording=made)
train, test = done.log(0), done.log(1)

# ## The estimate
# symgen fits an energy, a momentum and a torque model to the first log. It keeps the one with the
# smallest error on held-out parts, and tests it on the second log.

estimate = symgen.identify(robot, [train], validation=[test])
print("verdict:", estimate.verdict)
for p, true in zip(estimate.parameters, X, strict=True):
    print(f"{p.name:5} {p.value:8.4f} +- {2 * p.std:.4f}   true {true}")

# Every true value lies within three standard deviations.

off = np.abs(estimate.X - X) / np.array([p.std for p in estimate.parameters])
assert estimate.verdict == "trusted"
assert off.max() < 3

# ## The model at work
# The compiled functions evaluate one sample or many at once. Here the identified model predicts the
# torque of the second run.

dynamics = symgen.load(model)
acceleration = np.gradient(done.qd[1], done.t, axis=0)
tau = dynamics["inverse_dynamics"](done.q[1], done.qd[1], acceleration, estimate.X)
error = np.linalg.norm((tau - done.tau[1])[5:-5]) / np.linalg.norm(done.tau[1][5:-5])
print(f"torque error on the second run: {100 * error:.2f} %")
assert error < 0.01
