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

model = symgen.derive("planar2r", ("energy_regressor", "inverse_dynamics", "mass_matrix"))
names = model.base.names
for k, column in enumerate(model.closed_form("energy_regressor"), 1):
    print(f"DL{k} = {column}")

# ## The motion
# Joint 1 moves from stop to stop, and joint 2 there and back. The samples are 62.2 ms apart.

X = np.array([1.702, 0.05644, 0.15, 0.075])  # ZZ1R, ZZ2, MX2, MY2
robot = symgen.load(model)
STEP, END = 0.0622, 6.22
t = STEP * np.arange(101)
s = t / END
q = np.column_stack([END / 1.5 * (3 * s**2 - 2 * s**3), 1 - np.cos(2 * t)])
qd = np.column_stack([4 * (s - s**2), 2 * np.sin(2 * t)])
qdd = np.column_stack([4 / END * (1 - 2 * s), 4 * np.cos(2 * t)])
motion = symgen.make_reference("1988", t, q, qd, qdd)
sampled = symgen.Recording(rate=1 / STEP)
exact = symgen.simulate(robot, X, trajectory=motion, recording=sampled)
t, q, qd, tau = exact.t, exact.q[0], exact.qd[0], exact.tau[0]

# ## The noise
# An encoder has 14,400 steps in a turn. The noise of a tachometer is 0.5 % of the largest speed of
# its joint, 1 and 2 rad/s. The torque is exact.

RUNS, PAPER = 1000, {"ZZ1R": 5.6e-4, "ZZ2": 0.016, "MX2": 0.011, "MY2": 0.019}
draw = np.random.default_rng(1988)


def measured():
    """Return positions and speeds with the noise of a run, (101, 2) each."""
    step = 2 * np.pi / 14_400
    noise = np.array([0.005, 0.01]) * draw.standard_normal(qd.shape)
    return q + draw.uniform(-step / 2, step / 2, q.shape), qd + noise


# ## The equations
# Every window begins with the first sample: each new sample adds the equation
# h(t) X - h(0) X = work of the torques from 0 to t. Least squares are solved after each sample.

FIRST = 16  # the samples before determine little


def convergence(q, qd):
    """Return the estimates after each sample from FIRST on, (85, 4)."""
    h = robot.energy_regressor(q, qd)
    work = CubicSpline(t, np.sum(qd * tau, axis=1)).antiderivative()(t)
    rows = np.column_stack([h - h[0], work])
    gram = np.cumsum(rows[:, :, None] * rows[:, None, :], axis=0)[FIRST:]
    return np.linalg.solve(gram[:, :-1, :-1], gram[:, :-1, -1:])[:, :, 0]


assert np.abs(convergence(q, qd)[-1] / X - 1).max() < 1e-3  # without noise

# ## Errors of 1,000 runs
# The paper prints the errors of one run after 100 samples. Each must be an error that a run of this
# experiment usually has: 95 % of the runs lie in the interval.

estimates = np.array([convergence(*measured()) for _ in range(RUNS)])
errors = np.abs(estimates / X - 1)
print("relative errors after 100 samples")
print("parameter  paper    median   95 % of the runs")
for k, name in enumerate(names):
    low, middle, high = np.quantile(errors[:, -1, k], [0.025, 0.5, 0.975])
    paper = PAPER[name]
    print(f"{name:9}  {paper:.2e}  {middle:.2e}  {low:.1e} to {high:.1e}")
    assert low < paper < high, name

# ## Convergence
# Figures 5 to 9 of the paper show how the estimates of its run converge.

print("median error after 20, 40, 60, 80 and 100 samples")
for k, name in enumerate(names):
    after = np.median(errors[:, [n - FIRST for n in (20, 40, 60, 80, 100)], k], axis=0)
    print(f"{name:5}", ", ".join(f"{error:.2e}" for error in after))
