"""Hidden spring in Python

An arm has a spring on joint 2 that its robot file does not declare. The diagnosis names the spring
and its stiffness. With the spring, the torque error falls to the level of the noise.
"""

# ## Two robots
# KNOWN is the robot file. The true arm also has a spring.

import symgen

KNOWN = """
[robot]
name = "arm"
gravity = [0.0, -9.81, 0.0]

[[joint]]

[[joint]]
d = 0.5

[limits]
position = [[-2.5, 2.5], [-2.0, 2.0]]
velocity = [3.0, 4.0]
"""
SPRING = """
[[effect]]
name = "gravity_spring"
joints = [2]
"""
known, true = symgen.parse_robot(KNOWN), symgen.parse_robot(KNOWN + SPRING)

# ## Logs of the true arm
# The stiffness of the spring is 3 N m/rad. The logs have encoder steps and torque noise.
# Their motions differ: a repeated motion confirms no effect.

X = {"ZZ1R": 1.7, "MX1R": 2.6, "MY1": 0.05, "FS1": 1.5, "FV1": 0.9, "ZZ2": 0.3, "MX2": 0.7,
     "MY2": 0.02, "FS2": 0.8, "FV2": 0.5, "IA2": 0.2, "K2": 3.0}  # fmt: skip
sensors = symgen.Recording(symgen.Instruments(encoder_step=2e-5, torque_noise=0.3), rate=200.0)
train, test = (symgen.simulate(true, X, seed=k, recording=sensors).log(0) for k in (4, 5))

# ## The diagnosis
# symgen tries every effect of the library on every joint. It names an effect only if the effect
# lowers the error on data that the search did not use. `why.extended` is the robot with the effect.

why = symgen.diagnose(known, [train], validation=[test])
effect = why.effects[0]
stiffness = effect.parameters[0]
print(f"{why.verdict}: {effect.name} on joint {effect.joints[0]}, "
      f"{stiffness.name} = {stiffness.value:.2f} {stiffness.unit}")  # fmt: skip

# ## Both models

before, after = (symgen.identify(r, [train], validation=[test]) for r in (known, why.extended))
for name, estimate in (("without the spring", before), ("with the spring", after)):
    error = 100 * estimate.torque_validation.relative
    print(f"{name}: {estimate.verdict}, torque error {error:.2g} %")
assert abs(stiffness.value - 3.0) < 3 * stiffness.std
