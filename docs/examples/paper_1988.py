"""Example of Gautier and Khalil (1988) in Python

The paper identifies a robot with two joints from 100 samples of a simulated motion (section 8).
This script repeats the experiment 1,000 times, and compares the errors with those of the paper.
"""

# ## The model
# Gravity is parallel to both axes, so that the energy H = h X has four parameters and no weight.
# The paper calls the columns of h DL1 to DL4. symgen derives them in closed form.

import numpy as np
from scipy.interpolate import CubicSpline

import symgen

model = symgen.derive("planar2r", ("energy_regressor", "inverse_dynamics"))
robot, names = symgen.load(model), model.base.names
for k, column in enumerate(model.closed_form("energy_regressor"), 1):
    print(f"DL{k} = {column}")

# ## Motion and noise
# Joint 1 moves from stop to stop, and joint 2 there and back. The encoders have 14,400 steps in a
# turn. The noise of a tachometer is 0.5 % of the largest speed of its joint. The torque is exact.

X = np.array([1.702, 0.05644, 0.15, 0.075])  # ZZ1R, ZZ2, MX2, MY2
END, RUNS, FIRST = 6.22, 1000, 16  # the samples before FIRST determine little
t = np.linspace(0.0, END, 101)
s = t / END
q = np.column_stack([END / 1.5 * (3 * s**2 - 2 * s**3), 1 - np.cos(2 * t)])
qd = np.column_stack([4 * (s - s**2), 2 * np.sin(2 * t)])
qdd = np.column_stack([4 / END * (1 - 2 * s), 4 * np.cos(2 * t)])
tau = robot.inverse_dynamics(q, qd, qdd, X)
draw, step = np.random.default_rng(1988), 2 * np.pi / 14_400
q_runs = q + draw.uniform(-step / 2, step / 2, (RUNS, *q.shape))
qd_runs = qd + np.array([0.005, 0.01]) * draw.standard_normal((RUNS, *qd.shape))

# ## The equations
# Each sample adds the equation h(t) X - h(0) X = work of the torques from 0 to t. The estimates
# after each sample show how the result converges, as figures 5 to 9 of the paper do.


def convergence(q, qd):
    """Return the least-squares estimates after each sample from FIRST on, (85, 4)."""
    h = robot.energy_regressor(q, qd)
    work = CubicSpline(t, np.sum(qd * tau, axis=1)).antiderivative()(t)
    rows = np.column_stack([h - h[0], work])
    sums = np.cumsum(rows[:, :, None] * rows[:, None, :], axis=0)[FIRST:]
    return np.linalg.solve(sums[:, :-1, :-1], sums[:, :-1, -1:])[:, :, 0]


# ## Errors of 1,000 runs
# The paper prints the errors of one run. Each lies in the interval of 95 % of the runs here.

estimates = np.array([convergence(*run) for run in zip(q_runs, qd_runs, strict=True)])
low, middle, high = np.quantile(np.abs(estimates[:, -1] / X - 1), [0.025, 0.5, 0.975], axis=0)
paper = np.array([5.6e-4, 0.016, 0.011, 0.019])
print("parameter  paper    median   95 % of the runs")
for k, name in enumerate(names):
    print(f"{name:9}  {paper[k]:.2e}  {middle[k]:.2e}  {low[k]:.1e} to {high[k]:.1e}")
assert np.all((low < paper) & (paper < high))
