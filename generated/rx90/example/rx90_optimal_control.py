"""rx90: an optimal motion by direct collocation, over rx90_inverse_dynamics.casadi.

    minimise the integral of |tau|^2,    tau = M(q) qdd + h(q, qd),    |tau| <= LIMIT,

from rest to rest in a given time. Torques are held over intervals; in each, q and qd are polynomials
of degree 3 that satisfy the equations of motion at Radau's points: no mass matrix is inverted. Then
another goal is reached from the first solution, a warm start. Needs casadi and numpy. Writes the
torques of the second motion, a row for each interval, where a file is named.
"""

import sys
from pathlib import Path

import casadi as ca
import numpy as np

INTERVALS, DEGREE, TIME = 20, 3, 1.0
LIMIT = 150.0  # N m, or N
# Parameters of a robot that could exist, not of yours, without dry friction: no smooth method sees
# its jump. With coulomb_width in robot.toml it can stay.
X = [
    3.321055, -1.851154, -0.038493, 0.152242, 0.061386, 2.530813, 4.018274, -0.406421, 1.496333,
    0.032295, 0.029714, -0.036533, 1.629708, 0.23575, 2.891305, 0.20033, 0.13433, -0.003239,
    -0.0034, -0.004692, 0.227384, -0.067896, -0.345131, 0.694691, 0.2685, 0.046643, 0.037706,
    -0.032138, 0.429452, -0.364939, 0.856201, 0.809581, -0.079898, 0.011925, 0.091622, -0.013382,
    0.182386, -0.485761, 0.070951, 0.833029, 0.0, 0.363829, 0.0, 0.656796, 0.0, 0.248433, 0.0,
    0.52913, 0.0, 0.661164, 0.0, 0.262668,
]

package = Path(__file__).resolve().parents[1]
inverse_dynamics = ca.Function.load(str(package / "rx90_inverse_dynamics.casadi"))
n, points, h = inverse_dynamics.size1_in(0), DEGREE * INTERVALS, TIME / INTERVALS
columns = 2 * (points + 1) + INTERVALS  # of [q, qd, tau]

motion = ca.MX.sym("motion", n, columns)
q, qd, tau = ca.horzsplit(motion, [0, points + 1, 2 * (points + 1), columns])
slopes = ca.collocation_coeff(ca.collocation_points(DEGREE, "radau"))[0]
pieces = [slice(DEGREE * k, DEGREE * (k + 1) + 1) for k in range(INTERVALS)]
speed, qdd = (ca.horzcat(*(x[:, k] @ slopes for k in pieces)) / h for x in (q, qd))
shared = [ca.repmat(ca.DM(values), 1, points) for values in (X,)]
torque = inverse_dynamics.map(points)(q[:, 1:], qd[:, 1:], qdd, *shared)
held = ca.kron(tau, ca.DM.ones(1, DEGREE))
equations = ca.veccat(speed - qd[:, 1:], torque - held)
problem = {"x": ca.vec(motion), "f": h * ca.sumsqr(tau), "g": equations}


def solve(goal, **known):
    """Move from rest at 0 to rest at a goal (n,); return the solution and its iterations."""
    low, high = np.full((2, n, columns), [[[-np.inf]], [[np.inf]]])
    low[:, -INTERVALS:], high[:, -INTERVALS:] = -LIMIT, LIMIT
    for column, value in ((0, 0), (points, goal), (points + 1, 0), (2 * points + 1, 0)):
        low[:, column] = high[:, column] = value
    s = np.linspace(0, 1, points + 1)
    guess = np.zeros((n, columns))
    guess[:, : points + 1] = np.outer(goal, s**3 * (10 - 15 * s + 6 * s**2))
    options = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes"}
    if known:
        options |= {"ipopt.warm_start_init_point": "yes", "ipopt.mu_init": 1e-6}
    solver = ca.nlpsol("solver", "ipopt", problem, options)
    bounds = {"lbx": low.ravel("F"), "ubx": high.ravel("F"), "lbg": 0, "ubg": 0}
    done = solver(**{"x0": guess.ravel("F"), **bounds, **known})
    if not solver.stats()["success"]:
        sys.exit(f"failed: {solver.stats()['return_status']}")
    return done, solver.stats()["iter_count"]


goal = 0.6 * (-1.0) ** np.arange(n)
cold, iterations = solve(goal)
print(f"cold start: {iterations} iterations, effort {float(cold['f']):.6g}")
warm, iterations = solve(goal + 0.05, x0=cold["x"], lam_x0=cold["lam_x"], lam_g0=cold["lam_g"])
print(f"warm start: {iterations} iterations, effort {float(warm['f']):.6g}")
if sys.argv[1:]:
    torques = ca.reshape(warm["x"], n, columns)[:, -INTERVALS:].full().T
    np.savetxt(sys.argv[1], torques, delimiter=",")
