"""Planned motion in Python

This example plans a motion for identification, and compares it with two slow sines. Sensors and
parameters are the same, but the planned motion determines all parameters.
"""

# ## A motion within limits
# The search minimizes the standard deviations that the noise of the torques causes.

import numpy as np

import symgen

TABLE = """
[robot]
name = "arm"
gravity = [0.0, -9.81, 0.0]

[[joint]]

[[joint]]
d = 0.45

[limits]
position = [[-1.5, 1.5], [-2.0, 2.0]]
velocity = [2.0, 3.0]
acceleration = [8.0, 12.0]
"""
arm = symgen.parse_robot(TABLE)
short = symgen.Search(searches=1, iterations=500, seed=1)
plan = symgen.excite(arm, motion=symgen.Motion(duration=10.0), search=short)
speeds = [100 * use.share for use in plan.uses if use.limit == "velocity"]
print(f"speeds reach {speeds[0]:.0f} and {speeds[1]:.0f} % of their limits")

# ## Two logs
# The arm follows the planned motion, and then the slow one.

X = {"ZZ1R": 1.9, "MX1R": 2.9, "MY1": 0.04, "FS1": 1.5, "FV1": 0.9, "ZZ2": 0.3, "MX2": 0.75,
     "MY2": 0.02, "IA2": 0.2, "FS2": 0.8, "FV2": 0.5}  # fmt: skip
sensors = symgen.Recording(symgen.Instruments(encoder_step=2e-5, torque_noise=0.3))
run = plan.runs[0]
t = run.times(1 / plan.rate)
good = symgen.make_reference("planned", t, *(run.at(t, order) for order in range(3)))
w = np.array([0.6, 0.8])
phase = np.outer(t, w)
sines = (1 - np.cos(phase), w * np.sin(phase), w**2 * np.cos(phase))
slow = symgen.make_reference("slow", t, *(0.5 * x for x in sines))
known = {}
for motion in (good, slow):
    log = symgen.simulate(arm, X, trajectory=motion, recording=sensors, seed=1).log(0)
    estimate = symgen.identify(arm, [log], model="momentum")
    known[motion.name] = sum(p.relative_std_percent < 30 for p in estimate.parameters)
    print(f"{motion.name}: {known[motion.name]} of {len(X)} parameters known to 30 %")
assert known["planned"] == len(X)
