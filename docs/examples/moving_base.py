"""A moving base

An arm on a vehicle has an inertial sensor in place of gravity. An upward acceleration of 1 g must
double the torque that holds the arm.
"""

# ## The robot file
# One line turns a robot of the library into one on a moving base.

import numpy as np

import symgen

text = symgen.robot_toml(symgen.read_robot("puma560"))
moving = symgen.parse_robot(text.replace("[robot]\n", '[robot]\nbase = "imu"\n'))
KERNELS = ("inverse_dynamics", "base_parameters")
fixed, model = symgen.derive("puma560", KERNELS), symgen.derive(moving, KERNELS)
print(f"fixed base: {len(fixed.base.names)} parameters, moving base: {len(model.base.names)}")

# ## The torque
# f is the specific force, w the angular velocity and wd the angular acceleration of the base.

arm = symgen.load(model)
link = {"XX": 0.05, "YY": 0.05, "ZZ": 0.05, "M": 3.0, "MX": 0.3}
X = arm.base_parameters([link.get(p.prefix, 0.0) for p in model.base.standard])
q, still = np.array([0.0, 0.4, -0.7, 0.2, 0.5, 0.0]), np.zeros(6)
up, none = np.array([0.0, 0.0, 9.81]), np.zeros(3)


def held(f, w, wd):
    """Return the torques that hold the arm."""
    return arm.inverse_dynamics(q, still, still, X, f, w, wd)


print("base at rest:", np.round(held(up, none, none), 3) + 0.0)
print("1 g upwards: ", np.round(held(2 * up, none, none), 3) + 0.0)
print("in a turn:   ", np.round(held(up, np.array([0.0, 0.0, 1.0]), none), 3) + 0.0)
ratio = held(2 * up, none, none)[1] / held(up, none, none)[1]
print(f"ratio at joint 2: {ratio:.3f}")
assert abs(ratio - 2.0) < 1e-9
