"""puma560: an optimal motion by direct collocation, over the functions of puma560_casadi.py.

    minimise the integral of |tau|^2,    tau = M(q) qdd + h(q, qd),    |tau| <= LIMIT,

from rest to rest in a given time. Torques are held over intervals; in each, q and qd are polynomials
of degree 3 that satisfy the equations of motion at Radau's points: no mass matrix is inverted. Then
another goal is reached from the first solution, a warm start. Needs casadi and numpy. Writes the
torques of the second motion, a row for each interval, where a file is named.

The Jacobian of the torques is the package's: d tau/dq and d tau/dqd of its derivatives, and M. The
Hessian is CasADi's AD of tau, cheaper than AD of derivatives. With --derivatives ad both are AD, with
the same iterations. The seconds printed are the processor's, without what builds the Jacobian once:
for one motion that outweighs what is saved.
"""

import argparse
import sys
import time
from pathlib import Path

import casadi as ca
import numpy as np

INTERVALS, DEGREE, TIME = 20, 3, 1.0
LIMIT = 150.0  # N m, or N
# Parameters of a robot that could exist, not of yours, without dry friction: no smooth method sees
# its jump. With coulomb_width in robot.toml it can stay.
X = [
    3.604273, -1.700236, -0.038493, 0.526642, 0.061386, 2.379895, 3.847127, -0.406421, 1.387888,
    -0.029783, 0.029714, -0.036533, 1.52727, 0.087807, -3.347846, 0.20033, 0.13433, -0.003239,
    -0.0034, -0.004692, 0.227384, -0.067896, 0.157771, 0.694691, 0.2685, 0.046643, 0.037706,
    -0.032138, 0.429452, -0.364939, -0.234105, 0.809581, -0.079898, 0.011925, 0.091622, -0.013382,
    0.182386, -0.485761, 0.070951, 0.833029, 0.0, 0.363829, 0.0, 0.656796, 0.0, 0.248433, 0.0,
    0.52913, 0.0, 0.661164, 0.0, 0.262668,
]


sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import puma560_casadi  # noqa: E402


def kernel(name):
    """Return a function of the package."""
    return puma560_casadi.FUNCTIONS[name]()


inverse_dynamics = kernel("inverse_dynamics")
n, points, h = inverse_dynamics.size1_in(0), DEGREE * INTERVALS, TIME / INTERVALS
columns = 2 * (points + 1) + INTERVALS  # of [q, qd, tau]

parser = argparse.ArgumentParser()
parser.add_argument("--derivatives", choices=["package", "ad"], default="package")
parser.add_argument("torques", nargs="?", help="a file to write")
asked = parser.parse_args()

state = [ca.SX.sym(name, n) for name in ("q", "qd", "qdd")]
values = [ca.DM(X)]
tau = inverse_dynamics(*state, *values)
torque = ca.Function("torque", state, [tau])

x = ca.MX.sym("x", n * columns)
motion = ca.reshape(x, n, columns)
q, qd, _ = ca.horzsplit(motion, [0, points + 1, 2 * (points + 1), columns])
slopes = ca.collocation_coeff(ca.collocation_points(DEGREE, "radau"))[0]
pieces = [slice(DEGREE * k, DEGREE * (k + 1) + 1) for k in range(INTERVALS)]
speed, qdd = (ca.horzcat(*(y[:, k] @ slopes for k in pieces)) / h for y in (q, qd))
held = ca.kron(motion[:, -INTERVALS:], ca.DM.ones(1, DEGREE))


def equations(torque):
    """Collocation and the equations of motion: zero at a solution."""
    missing = torque.map(points)(q[:, 1:], qd[:, 1:], qdd) - held
    return ca.veccat(speed - qd[:, 1:], missing)


problem = {"x": x, "f": h * ca.sumsqr(motion[:, -INTERVALS:]), "g": equations(torque)}
jac_g = {}
if asked.derivatives == "package":
    mass_matrix = kernel("mass_matrix")
    M = mass_matrix(state[0], values[0][: mass_matrix.numel_in(1)])
    blocks = [*kernel("inverse_dynamics_derivatives")(*state, *values), M]
    own = ca.Function("jac_torque", [*state, ca.SX.sym("tau", n)], blocks)
    own = {"custom_jacobian": own, "enable_forward": False, "enable_reverse": False}
    g = equations(ca.Function("torque", state, [tau], own))
    inputs, outputs = [x, ca.MX.sym("p", 0)], [g, ca.jacobian(g, x)]
    jac_g = {"jac_g": ca.Function("nlp_jac_g", inputs, outputs, ["x", "p"], ["g", "jac_g_x"])}


def solve(goal, **known):
    """Move from rest at 0 to rest at a goal (n,); return the solution and a line about it."""
    begun = time.process_time()
    low, high = np.full((2, n, columns), [[[-np.inf]], [[np.inf]]])
    low[:, -INTERVALS:], high[:, -INTERVALS:] = -LIMIT, LIMIT
    for column, value in ((0, 0), (points, goal), (points + 1, 0), (2 * points + 1, 0)):
        low[:, column] = high[:, column] = value
    s = np.linspace(0, 1, points + 1)
    guess = np.zeros((n, columns))
    guess[:, : points + 1] = np.outer(goal, s**3 * (10 - 15 * s + 6 * s**2))
    options = {"print_time": False, "ipopt.print_level": 0, "ipopt.sb": "yes", **jac_g}
    if known:
        options |= {"ipopt.warm_start_init_point": "yes", "ipopt.mu_init": 1e-6}
    solver = ca.nlpsol("solver", "ipopt", problem, options)
    bounds = {"lbx": low.ravel("F"), "ubx": high.ravel("F"), "lbg": 0, "ubg": 0}
    done = solver(**{"x0": guess.ravel("F"), **bounds, **known})
    if not solver.stats()["success"]:
        sys.exit(f"failed: {solver.stats()['return_status']}")
    count, seconds = solver.stats()["iter_count"], time.process_time() - begun
    return done, f"{count} iterations, effort {float(done['f']):.6g}, {seconds:.2f} s"


goal = 0.6 * (-1.0) ** np.arange(n)
cold, line = solve(goal)
print(f"cold start: {line}")
warm, line = solve(goal + 0.05, x0=cold["x"], lam_x0=cold["lam_x"], lam_g0=cold["lam_g"])
print(f"warm start: {line}")
if asked.torques:
    torques = ca.reshape(warm["x"], n, columns)[:, -INTERVALS:].full().T
    np.savetxt(asked.torques, torques, delimiter=",")
