"""Motion of least effort with CasADi

symgen writes inverse dynamics as a CasADi function, which an optimizer can differentiate. This
example finds the motion of 1 s that needs the least torque.
"""

# ## The function
# The package has a module in Python. It can also be imported from a folder.

import casadi as ca
import numpy as np

import symgen

model = symgen.derive("planar2r", ("inverse_dynamics",))
files = symgen.generate(model, target="casadi").files
names = {"__name__": "planar2r_casadi"}
exec(files["planar2r_casadi.py"], names)
torque = names["inverse_dynamics"]()
X = [3.5, 0.06, 0.124, 0.006]

# ## The problem
# Each joint turns from 0 to its goal, and rests at both ends. The variables are the accelerations
# of 40 steps. The effort is the integral of the squared torque.

STEPS, GOAL = 40, np.array([1.0, 2.0])
h = 1.0 / STEPS
qdd = ca.SX.sym("qdd", 2, STEPS)
q, qd, effort = ca.SX(np.zeros(2)), ca.SX(np.zeros(2)), 0
for k in range(STEPS):
    q = q + h * qd + h**2 / 2 * qdd[:, k]
    qd = qd + h * qdd[:, k]
    effort += h * ca.sumsqr(torque(q, qd, qdd[:, k], X))
problem = {"x": ca.vec(qdd), "f": effort, "g": ca.vertcat(q - GOAL, qd)}
quiet = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes"}
solver = ca.nlpsol("solver", "ipopt", problem, quiet)

# ## Compared with a cubic
# A cubic polynomial is the usual motion from rest to rest.

s = (np.arange(STEPS) + 0.5) * h
cubic = np.outer(GOAL, 6 - 12 * s)
cost = ca.Function("cost", [problem["x"]], [effort])
before = float(cost(cubic.T.reshape(-1)))
found = solver(x0=cubic.T.reshape(-1), lbg=0, ubg=0)
after = float(found["f"])
print(f"effort of the cubic {before:.1f}, of the best motion {after:.1f} N2 m2 s")
saved = 100 * (1 - after / before)
print(f"saved {saved:.2f} %")
assert solver.stats()["success"]
assert after < 0.95 * before
