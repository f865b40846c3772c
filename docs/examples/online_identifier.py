"""A load on line

The on-line identifier follows the parameters while the robot runs. Here the robot grips a load of
0.5 kg after 10 s, and the identifier finds its mass.
"""

# ## Two motions
# The load is a point mass at 0.4 m on link 2 of planar2r. It adds to three parameters.

import numpy as np

import symgen

model = symgen.derive("planar2r", ("energy_regressor", "momentum_regressor"))
evaluator = symgen.load(model)
empty = np.array([3.5, 0.06, 0.124, 0.006])  # ZZ1R, ZZ2, MX2, MY2
mass, place, length = 0.5, 0.4, 0.5
full = empty + mass * np.array([length**2, place**2, place, 0.0])
seen = symgen.Recording(symgen.Instruments(torque_noise=0.01), rate=500.0)

# ## The identifier at work
# The second log continues the time of the first, one sample later.
#
# With forgetting = 0.998, the identifier remembers about 500 samples, or 1 s.

identifier = symgen.Identifier(evaluator, window=100, model="momentum", forgetting=0.998)
for label, X, start in (("empty", empty, 0), ("loaded", full, 1)):
    log = symgen.simulate(evaluator, X, duration=10.0, seed=start + 1, recording=seen).log(0)
    for q, qd, tau, t in zip(log.q, log.qd, log.tau, log.t, strict=True):
        identifier.step(q, qd, tau, 10.002 * start + t)
    found, std = identifier.read()
    print(f"{label:6}: MX2 = {found[2]:.3f} kg m, true {X[2]:.3f}")

# ## The load
# Its mass is the change of ZZ1R over the square of the length of link 1.

gripped = (found[0] - empty[0]) / length**2
print(f"mass {gripped:.3f} kg")
assert abs(gripped - mass) < 0.05
