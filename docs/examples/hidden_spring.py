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
known = symgen.parse_robot(KNOWN)
true = symgen.parse_robot(KNOWN + SPRING)
names = symgen.derive(true).base.names
print("parameters of the true arm:", ", ".join(names))

# ## Logs of the true arm
# The stiffness of the spring is 3 N m/rad. The logs have encoder steps and torque noise.
# Their motions differ: a repeated motion confirms no effect.

values = {"ZZ1R": 1.7, "MX1R": 2.6, "MY1": 0.05, "FS1": 1.5, "FV1": 0.9, "ZZ2": 0.3, "MX2": 0.7,
          "MY2": 0.02, "FS2": 0.8, "FV2": 0.5, "IA2": 0.2, "K2": 3.0}  # fmt: skip
X = [values.get(name, 0.0) for name in names]
seen = symgen.Instruments(encoder_step=2e-5, torque_noise=0.3)
made = symgen.Recording(seen, rate=200.0)
train, test = (
    symgen.simulate(true, X, duration=16.0, seed=seed, recording=made).log(0) for seed in (4, 5)
)

# ## The symptom
# The model without the spring has a large torque error.

before = symgen.identify(known, [train], validation=[test])
print(f"without the spring: {before.verdict}, torque error "
      f"{100 * before.torque_validation.relative:.2g} %")  # fmt: skip

# ## The diagnosis
# symgen tries every effect of the library on every joint. It names an effect only if the effect
# lowers the error on data that the search did not use.

why = symgen.diagnose(known, [train], validation=[test])
print("diagnosis:", why.verdict)
for effect in why.effects:
    found = ", ".join(f"{p.name} = {p.value:.2f} {p.unit}".strip() for p in effect.parameters)
    print(f"  {effect.name} on joint {effect.joints[0]}: {found}")
print(f"gap {100 * why.before.total:.2g} % before, {100 * why.after.total:.2g} % after, "
      f"noise floor {100 * why.floor.total:.2g} %")  # fmt: skip

# ## The corrected model
# `why.extended` is the robot with the found effect.

after = symgen.identify(why.extended, [train], validation=[test])
print(f"with the spring: {after.verdict}, torque error "
      f"{100 * after.torque_validation.relative:.2g} %")  # fmt: skip
assert why.effects[0].name == "gravity_spring"
assert after.torque_validation.relative < before.torque_validation.relative / 3
