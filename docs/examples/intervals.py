"""Standard deviations and intervals

About 95 % of the intervals of two standard deviations should contain the true value. This example
counts them over twenty logs.
"""

# ## Twenty logs
# The logs have the same motion and different noise.

import numpy as np

import symgen

RUNS = 20
robot = symgen.load("planar2r")
X = np.array([3.5, 0.06, 0.124, 0.006])
seen = symgen.Instruments(encoder_step=1e-4, velocity_noise=2e-3, torque_noise=0.05)
made = symgen.Recording(seen, rate=200.0)
done = symgen.simulate(robot, X, duration=6.0, runs=RUNS, seed=1, recording=made)

# ## Intervals
# The errors are counted in standard deviations. The four errors of a log depend on each other, so
# twenty logs show a wrong interval only if it is far too short.

errors = np.empty((RUNS, len(X)))
for run in range(RUNS):
    estimate = symgen.identify(robot, [done.log(run)], model="energy", method="wls")
    std = np.array([p.std for p in estimate.parameters])
    errors[run] = (estimate.X - X) / std
for p, column in zip(estimate.parameters, errors.T, strict=True):
    print(f"{p.name:5} {np.sum(np.abs(column) < 2):.0f} of {RUNS} intervals contain the true value")
share = 100 * np.mean(np.abs(errors) < 2)
print(f"all parameters: {share:.1f} %")
assert share > 85
