"""Payload in Python

A load of 2 kg on the second link changes four base parameters. Two logs of the same motion, with
and without the load, give its mass and centre of mass, because common errors cancel.
"""

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
empty = {"ZZ1R": 1.9, "MX1R": 2.9, "MY1": 0.04, "FS1": 1.5, "FV1": 0.9, "ZZ2": 0.3, "MX2": 0.75,
         "MY2": 0.02, "IA2": 0.2, "FS2": 0.8, "FV2": 0.5}  # fmt: skip

# ## The arm with the load
# The load is a point mass at 0.3 m on the second link. It adds to the inertia of link 2 and, at the
# length d of link 1, to that of link 1.

mass, place, d = 2.0, 0.3, 0.45
loaded = empty | {
    "ZZ2": empty["ZZ2"] + mass * place**2,
    "MX2": empty["MX2"] + mass * place,
    "ZZ1R": empty["ZZ1R"] + mass * d**2,
    "MX1R": empty["MX1R"] + mass * d,
}

# ## Two logs of one motion
# Runs of one seed follow the same motion with other noise: run 0 without the load, run 1 with it.

sensors = symgen.Recording(symgen.Instruments(encoder_step=2e-5, torque_noise=0.3), rate=200.0)
without, carrying = (
    symgen.simulate(arm, parameters, runs=range(k, k + 1), seed=2, recording=sensors).log(0)
    for k, parameters in enumerate((empty, loaded))
)
load = symgen.payload(arm, [carrying], without=[without])
for name, value, unit in load.rows():
    if value.value is not None:
        print(f"{name} {value.value:.3f} +- {2 * value.std:.3f} {unit}")
assert abs(load.mass.value - mass) < 0.05
