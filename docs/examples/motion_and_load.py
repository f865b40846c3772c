"""Motion and payload in Python

This example plans a motion for identification and compares it with a poor one. Then it identifies a
load that the arm carries, from one more log.
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

# ## A good and a poor motion
# The arm follows the planned motion, and two slow sines. Sensors and parameters are the same.

names = symgen.derive(arm).base.names
values = {"ZZ1R": 1.9, "MX1R": 2.9, "MY1": 0.04, "FS1": 1.5, "FV1": 0.9, "ZZ2": 0.3, "MX2": 0.75,
          "MY2": 0.02, "IA2": 0.2, "FS2": 0.8, "FV2": 0.5}  # fmt: skip
X = np.array([values[name] for name in names])
seen = symgen.Recording(symgen.Instruments(encoder_step=2e-5, torque_noise=0.3))


def recorded(motion, parameters, seed=1):
    """Return a log of the arm along a motion."""
    done = symgen.simulate(arm, parameters, trajectory=motion, recording=seen, seed=seed)
    return done.log(0)


run = plan.runs[0]
t = run.times(1 / plan.rate)
good = symgen.make_reference("found", t, *(run.at(t, order) for order in range(3)))
w, turned = np.array([0.6, 0.8]), np.array([0.5, 0.5])
slow = symgen.make_reference(
    "slow", t, turned * (1 - np.cos(np.outer(t, w))), turned * w * np.sin(np.outer(t, w)),
    turned * w**2 * np.cos(np.outer(t, w)),
)  # fmt: skip
for motion in (good, slow):
    estimate = symgen.identify(arm, [recorded(motion, X)], model="momentum")
    known = sum(p.relative_std_percent < 30 for p in estimate.parameters)
    print(f"{motion.name}: {known} of {len(X)} parameters known to 30 %")

# ## A load
# A load of 2 kg at 0.3 m on the second link changes four values of X. Two logs of the same motion,
# with and without the load, give its mass and centre of mass, because common errors cancel.

mass, place = 2.0, 0.3
carried = dict(zip(names, X, strict=True))
carried["ZZ2"] += mass * place**2
carried["MX2"] += mass * place
carried["ZZ1R"] += mass * 0.45**2
carried["MX1R"] += mass * 0.45
loaded = np.array([carried[name] for name in names])
load = symgen.payload(arm, [recorded(good, loaded, 2)], without=[recorded(good, X, 3)])
for name, value, unit in load.rows():
    if value.value is not None:
        print(f"{name} {value.value:.2f} +- {2 * value.std:.2f} {unit}")
assert abs(load.mass.value - mass) < 0.1
