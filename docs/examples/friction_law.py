"""Friction in the robot file

The friction of each joint stands in the robot file. This example declares it and identifies it
from a log.
"""

# ## The robot file
# The library robot planar2r has no friction. Its text gets a law for each joint.

import numpy as np

import symgen

text = symgen.robot_toml(symgen.read_robot("planar2r"))
first, second, third = text.split("friction = []")
text = f'{first}friction = ["viscous"]{second}friction = ["coulomb", "viscous"]{third}'
robot = symgen.parse_robot(text)
names = symgen.derive(robot).base.names
print("parameters:", ", ".join(names))

# ## A log
# FV are viscous and FS Coulomb coefficients. The speeds and torques have noise.

true = {"ZZ1R": 3.5, "ZZ2": 0.06, "MX2": 0.124, "MY2": 0.006, "FV1": 0.8, "FS2": 0.3, "FV2": 0.1}
X = np.array([true[name] for name in names])
seen = symgen.Instruments(encoder_step=1e-4, velocity_noise=2e-3, torque_noise=0.02)
made = symgen.Recording(seen, rate=200.0)
log = symgen.simulate(robot, X, duration=10.0, seed=1, recording=made).log(0)

# ## The estimate

estimate = symgen.identify(robot, [log], model="momentum")
for p in estimate.parameters:
    if p.name in ("FV1", "FS2", "FV2"):
        print(f"{p.name} = {p.value:.3f} +- {2 * p.std:.3f}   true {true[p.name]}")
worst = np.abs(estimate.X - X)[-3:].max()
print(f"largest error of friction {worst:.3f}")
assert worst < 0.02
