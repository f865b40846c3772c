"""Forward dynamics and back

Inverse dynamics turns an acceleration into a torque, and forward dynamics turns the torque back.
The largest difference over 1,000 random states shows the rounding error of both.
"""

# ## The arm
# The SCARA has three revolute joints and a sliding one. Masses, rotor inertias and friction are
# made up.

import numpy as np

import symgen

KERNELS = ("inverse_dynamics", "forward_dynamics", "base_parameters")
model = symgen.derive("scara", KERNELS)
arm = symgen.load(model)
link = {"XX": 0.05, "YY": 0.05, "ZZ": 0.05, "M": 3.0, "IA": 0.1, "FS": 1.0, "FV": 0.5}
X = arm.base_parameters([link.get(p.prefix, 0.0) for p in model.base.standard])

# ## Random states
# A call takes one sample or many. The rows here are 1,000 samples.

draw = np.random.default_rng(1)
q, qd, qdd = draw.uniform(-2.0, 2.0, (3, 1000, 4))
tau = arm.inverse_dynamics(q, qd, qdd, X)
back = arm.forward_dynamics(q, qd, tau, X)

# ## The difference

largest = np.abs(back - qdd).max()
print(f"largest torque {np.abs(tau).max():.1f} N m")
print("accelerations return to 1e-12:", largest < 1e-12)
assert largest < 1e-12
