"""Energy balance of a Panda

Inverse dynamics gives the torque of a motion. The work of this torque must be the change of energy
of the arm, which a second function of symgen computes.
"""

# ## The arm
# Its links are solid spheres of 2 kg, and the joints have no friction. The kernel base_parameters
# turns these standard parameters into X.

import numpy as np

import symgen

KERNELS = ("inverse_dynamics", "energy", "base_parameters")
model = symgen.derive("panda", KERNELS)
arm = symgen.load(model)
sphere = {"XX": 0.02, "YY": 0.02, "ZZ": 0.02, "M": 2.0}
X = arm.base_parameters([sphere.get(p.prefix, 0.0) for p in model.base.standard])
print(f"{len(X)} base parameters of {len(model.base.standard)} standard parameters")

# ## A motion
# Each joint follows a sine of its own frequency for 2 s.

t = np.linspace(0.0, 2.0, 2001)[:, None]
w = np.arange(1.0, 8.0)
q, qd, qdd = np.sin(w * t), w * np.cos(w * t), -(w**2) * np.sin(w * t)

# ## Work and energy
# The kernel energy returns the kinetic and the potential energy.

tau = arm.inverse_dynamics(q, qd, qdd, X)
work = np.trapezoid(np.sum(qd * tau, axis=1), t[:, 0])
kinetic, potential = arm.energy(q, qd, X)
energy = np.ravel(kinetic + potential)
change = energy[-1] - energy[0]
print(f"work {work:.3f} J, change of energy {change:.3f} J")
assert abs(work - change) < 1e-3 * abs(change)
