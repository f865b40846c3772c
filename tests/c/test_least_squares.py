"""The C runtime (least squares and identifier) against NumPy and closed forms.

The runtime is that of generated packages, compiled for Python:

    arm     planar 2R arm of the original paper, no friction: n = 2, p = p_inertial = 4
    rub     the same with FS and FV on both joints: p = 8, p_inertial = 4
    probe   a mass on a slide under gravity of 1 m/s2: DL = q + qd^2/2, so that at a constant speed
            what is integrated can be read off; n = p = 1
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from oracles import planar2r
from oracles.arm import Arm, sines
from oracles.on_line import DELAY, equations, folded, share
from packages import run

import symgen
from symgen.codegen.backends import Package as CPackage
from symgen.codegen.backends.c import library_files
from symgen.runtime.build import build_module, find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler on this machine")

MODES = {"start": 0, "sliding": 1, "consecutive": 2}
MODELS = ("energy", "momentum")
KERNELS = ("energy_regressor", "friction_power", "momentum_regressor", "friction_torque")
LENGTH = 0.5
DECLARATIONS = """
typedef struct arm_least_squares {
    REAL R[...]; REAL z[...]; REAL rss; REAL count; ...;
} arm_least_squares;
typedef struct arm_least_squares_solution {
    REAL X[...]; REAL std[...]; int missing; ...;
} arm_least_squares_solution;
int arm_least_squares_init(arm_least_squares *s, REAL forgetting);
int arm_least_squares_update(arm_least_squares *s, const REAL *row, REAL y);
void arm_least_squares_merge(arm_least_squares *s, const arm_least_squares *other);
int arm_least_squares_solve(const arm_least_squares *s, REAL *X, REAL *std, REAL *rss);
void arm_least_squares_begin(arm_least_squares_solution *found, const arm_least_squares *s);
int arm_least_squares_proceed(arm_least_squares_solution *found, int pieces);
size_t arm_identifier_size(size_t window);
int arm_identifier_init(void *state, size_t bytes, size_t window, int mode, REAL forgetting);
size_t arm_identifier_momentum_size(size_t window);
int arm_identifier_momentum_init(void *state, size_t bytes, size_t window, int mode,
                                 REAL forgetting);
int arm_identifier_step(void *state, const REAL *q, const REAL *qd, const REAL *tau, REAL dt);
int arm_identifier_status(const void *state);
void arm_identifier_restart(void *state);
int arm_identifier_run(void *state, size_t N, const REAL *t, const REAL *q, const REAL *qd,
                       const REAL *tau);
int arm_identifier_read(const void *state, REAL *X, REAL *std);
int arm_identifier_excited(const void *state, REAL *out);
int arm_identifier_rest(void *state, const REAL *noise);
const arm_least_squares *arm_identifier_state(const void *state);
"""


def robot(name: str) -> symgen.Robot:
    if name == "probe":
        return symgen.parse_robot(
            '[robot]\nname = "probe"\ngravity = [0, 0, -1]\n'
            "[[joint]]\nsigma = 1\nfriction = []\nrotor_inertia = false\n"
        )
    arm = symgen.read_robot("planar2r")
    friction = ("coulomb", "viscous") if name == "rub" else ()
    return replace(arm, joints=tuple(replace(joint, friction=friction) for joint in arm.joints))


def columns(name, model, q, qd, tau):
    """Value and rate of every sample, (N, equations, p + 1) each, the right-hand side last."""
    if model == "energy":
        moving, slope = planar2r.energy_regressor(q, qd, LENGTH)[:, None], 0.0
        right = (qd * tau).sum(axis=1)[:, None, None]
    else:
        (moving, slope), right = planar2r.momentum_regressor(q, qd, LENGTH), tau[..., None]
    blocks = [np.zeros_like(moving) - slope]
    if name == "rub":  # FS1 FV1 FS2 FV2, N m per unit of X
        torque = np.zeros((len(q), 2, 4))
        for j in range(2):
            torque[:, j, 2 * j : 2 * j + 2] = np.stack([np.sign(qd[:, j]), qd[:, j]], axis=1)
        power = np.einsum("kj,kjp->kp", qd, torque)[:, None]
        blocks.append(power if model == "energy" else torque)
    rate = np.concatenate([*blocks, right], axis=-1)
    value = np.zeros_like(rate)
    value[..., : moving.shape[-1]] = moving
    return value, rate


class Package:
    """A generated package, compiled for Python."""

    def __init__(self, name: str, real: str = "double") -> None:
        model = symgen.derive(robot(name), KERNELS)
        package = CPackage("arm", model, real, model.kernels)
        sources = {k: v.encode() for k, v in library_files(package, panels=False).items()}
        compiler = find_compiler()
        assert compiler is not None
        module = build_module(sources, DECLARATIONS.replace("REAL", real), compiler)
        self.ffi, self.lib = module.ffi, module.lib
        self.p = len(model.base.parameters)
        self.dtype = np.dtype(np.float64 if real == "double" else np.float32)
        self.real = real

    def __getattr__(self, function: str):
        return getattr(self.lib, f"arm_{function}")

    def pointer(self, x):
        """The numbers of an array as C has them."""
        return self.ffi.from_buffer(f"{self.real}[]", np.ascontiguousarray(x, dtype=self.dtype))

    def state(self, forgetting=1.0):
        state = self.ffi.new("arm_least_squares *")
        assert self.least_squares_init(state, forgetting) == 0
        return state

    def add(self, state, W, y):
        rows, right = self.pointer(W), self.pointer(y)
        for k in range(len(right)):
            assert self.least_squares_update(state, rows + self.p * k, right[k]) == 0

    def fit(self, W, y, forgetting=1.0):
        state = self.state(forgetting)
        self.add(state, W, y)
        return state

    def bytes(self, state) -> bytes:
        return bytes(self.ffi.buffer(state))

    def view(self, state) -> SimpleNamespace:
        """R, z, rss and count of a C state, R as a full triangle."""
        R = np.zeros((self.p, self.p))
        R[np.triu_indices(self.p)] = list(state.R)
        return SimpleNamespace(R=R, z=np.array(list(state.z)), rss=state.rss, count=state.count)

    def solve(self, state):
        X, std, rss = (np.full(size, 7, self.dtype) for size in (self.p, self.p, 1))
        status = self.least_squares_solve(state, *map(self.pointer, (X, std, rss)))
        return status, X, std, rss[0]

    def solved_in_pieces(self, found, pieces: int, state) -> int:
        """Number of calls that it takes; an equation comes between two of them."""
        calls = 1
        while self.least_squares_proceed(found, pieces) > 0:
            assert self.least_squares_update(state, self.pointer(np.ones(self.p)), 9.0) == 0
            calls += 1
        return calls

    def identifier(self, mode="sliding", window=0, forgetting=1.0, model="energy"):
        prefix = "identifier_momentum" if model == "momentum" else "identifier"
        size = getattr(self, f"{prefix}_size")(window if mode == "sliding" else 0)
        memory = self.ffi.new("double[]", size // 8 + 1)
        self.ffi.memmove(memory, b"\xff" * self.ffi.sizeof(memory), self.ffi.sizeof(memory))
        init = getattr(self, f"{prefix}_init")
        assert init(memory, size, window, MODES[mode], forgetting) == 0
        return memory

    def run(self, memory, t, q, qd, tau) -> int:
        return self.identifier_run(memory, len(t), *map(self.pointer, (t, q, qd, tau)))

    def step(self, memory, q, qd, tau, dt) -> int:
        return self.identifier_step(memory, *map(self.pointer, (q, qd, tau)), dt)

    def read(self, memory):
        X, std = np.full(self.p, 7, self.dtype), np.full(self.p, 7, self.dtype)
        return self.identifier_read(memory, self.pointer(X), self.pointer(std)), X, std

    def excited(self, memory) -> np.ndarray:
        out = np.full(self.p, 7, self.dtype)
        assert self.identifier_excited(memory, self.pointer(out)) == 0
        return out

    def least_squares(self, memory) -> SimpleNamespace:
        return self.view(self.identifier_state(memory))


@pytest.fixture(scope="module")
def package() -> Callable[..., Package]:
    return cache(Package)


def system(rows=300, p=8, seed=0):
    random = np.random.default_rng(seed)
    W = random.normal(size=(rows, p)) * 10.0 ** random.uniform(-3, 3, p)
    X = random.normal(size=p)
    return W, W @ X + 0.1 * random.normal(size=rows)


def assert_same(a, b, tolerance=1e-12):
    """Equal states, each entry of R against the norm of its column of W."""
    scale = np.linalg.norm(b.R, axis=0)
    assert np.all(np.abs(a.R - b.R) <= tolerance * scale)
    np.testing.assert_allclose(a.z, b.z, rtol=0, atol=tolerance * np.linalg.norm(b.z))
    power = b.rss + np.linalg.norm(b.z) ** 2
    np.testing.assert_allclose(a.rss, b.rss, rtol=1e-10, atol=tolerance * power)
    np.testing.assert_allclose(a.count, b.count, rtol=1e-12)


X_ARM = np.array([1.7, 0.3, 0.4, 0.15])
X_RUB = np.array([*X_ARM, 0.6, 0.2, 0.3, 0.1])
LOSING = Arm(X_ARM, FS=X_RUB[4::2], FV=X_RUB[5::2])


def motion(t, X, noise=0.0, seed=1):
    """A smooth motion of the planar 2R arm and the torques of Lagrange's equations for it."""
    w, phase = [[3.1, 4.7], [7.3, 5.9]], [[0.1, 0.7], [1.3, 2.1]]
    q, qd, qdd = sines(np.asarray(t), [[0.8, 0.9], [0.3, 0.4]], w, phase)
    FS, FV = (X[4::2], X[5::2]) if len(X) == 8 else (0.0, 0.0)
    tau = Arm(X[:4], FS=FS, FV=FV).torque(q, qd, qdd)
    return q, qd, tau + noise * np.random.default_rng(seed).normal(size=tau.shape)


def stamps(samples, uneven, dt=1e-3, seed=2, jitter=0.5):
    draw = np.random.default_rng(seed)
    steps = draw.uniform(1 - jitter, 1 + jitter, samples - 1) if uneven else 1.0
    return np.concatenate(([0.0], np.cumsum(dt * steps * np.ones(samples - 1))))


class TestLeastSquares:
    @pytest.mark.parametrize("seed", [2, 3, 8])  # others are ill-conditioned
    def test_equals_lstsq(self, package, seed):
        c, (W, y) = package("rub"), system(seed=seed)
        X, rss, *_ = np.linalg.lstsq(W, y)
        sigma2 = rss[0] / (len(y) - c.p)
        deviation = np.sqrt(sigma2 * np.diag(np.linalg.inv(W.T @ W)))
        state = c.fit(W, y)
        status, X_c, std_c, rss_c = c.solve(state)
        assert status == 0
        np.testing.assert_allclose(X_c, X, rtol=1e-10)
        np.testing.assert_allclose(std_c, deviation, rtol=1e-8)
        np.testing.assert_allclose(rss_c, rss[0], rtol=1e-10)
        assert state.count == len(y)
        R = c.view(state).R
        assert np.all(np.diag(R) >= 0)
        np.testing.assert_allclose(R.T @ R, W.T @ W, atol=1e-9 * np.linalg.norm(W) ** 2)

    @pytest.mark.parametrize("pieces", [1, 4, 100])
    def test_a_solution_in_pieces_is_the_whole_one(self, package, pieces):
        """Of the rows there were when it began; in so many calls; the last good one stays."""
        c, (W, y) = package("rub"), system()
        state, found = c.fit(W, y), c.ffi.new("arm_least_squares_solution *")
        whole = c.solve(state)
        c.least_squares_begin(found, state)
        assert c.solved_in_pieces(found, pieces, state) == -(-(c.p + 1) // pieces)
        assert found.missing == 0
        np.testing.assert_array_equal(list(found.X), whole[1])
        np.testing.assert_allclose(list(found.std), whole[2], rtol=1e-14)
        open_ = c.fit(np.c_[W[:, :4], W[:, 1:5]], y)
        c.least_squares_begin(found, open_)
        c.solved_in_pieces(found, pieces, state)
        assert found.missing == c.solve(open_)[0] == 5
        np.testing.assert_array_equal(list(found.X), whole[1])

    def test_std_is_nan_without_a_degree_of_freedom(self, package):
        c, (W, y) = package("rub"), system(rows=8)
        status, X, std, rss = c.solve(c.fit(W, y))
        assert status == 0
        np.testing.assert_allclose(W @ X, y, rtol=1e-6)
        assert np.isnan(std).all()
        assert abs(rss) < 1e-20
        noisy = c.fit(W, y)
        noisy.rss = 1.0  # as merged states may leave it
        assert np.isnan(c.solve(noisy)[2]).all()

    @pytest.mark.parametrize("forgetting", [1.0, 0.97])
    def test_merge_equals_one_pass(self, package, forgetting):
        """An empty state on either side changes nothing."""
        c, (W, y) = package("rub"), system()
        head, tail = c.fit(W[:90], y[:90], forgetting), c.fit(W[90:], y[90:], forgetting)
        total = c.fit(W[:0], y[:0])
        c.least_squares_merge(total, head)
        c.least_squares_merge(total, tail)
        c.least_squares_merge(total, c.fit(W[:0], y[:0]))
        one, two = folded(W[:90], y[:90], forgetting), folded(W[90:], y[90:], forgetting)
        whole = folded(np.r_[one.R, two.R], np.r_[one.z, two.z])
        whole.rss += one.rss + two.rss
        whole.count = one.count + two.count
        assert_same(c.view(total), whole)

    def test_a_state_merged_with_itself_counts_twice(self, package):
        c, (W, y) = package("rub"), system(rows=40)
        state = c.fit(W, y)
        c.least_squares_merge(state, state)
        assert_same(c.view(state), folded(np.r_[W, W], np.r_[y, y]))

    def test_forgetting_is_that_of_the_information_matrix(self, package):
        """And where rows excite all parameters, a memory of 100 rows."""
        c, (W, y) = package("rub"), system(rows=1000)
        state = c.fit(W, y, 0.99)
        assert_same(c.view(state), folded(W, y, 0.99))
        norm = np.linalg.norm(W, axis=0) / np.sqrt(len(W))
        remembered = np.mean(np.diag(c.view(state).R.T @ c.view(state).R) / norm**2)
        assert 70 < remembered < 130

    @pytest.mark.parametrize(("real", "most"), [("double", 1e-9), ("float", 1e-3)])
    def test_what_new_rows_do_not_excite_is_not_forgotten(self, package, real, most):
        """A hundred memories of rows in half of the parameters leave the others as they were.

        The first memory of them is left out: a cycle that begins with the rows before them forgets
        what these excite, too.
        """
        c, (W, y) = package("rub", real), system(rows=500)
        W = W / np.linalg.norm(W, axis=0) * np.sqrt(len(W))
        Q = np.linalg.qr(np.random.default_rng(4).normal(size=(8, 8)))[0]
        new = np.random.default_rng(5).normal(size=(10_000, 4)) @ Q[:4]
        right = new @ np.full(8, 3.0) + 0.1 * np.random.default_rng(6).normal(size=len(new))
        both = np.r_[W, new[:100]], np.r_[y, right[:100]]
        before, after = c.fit(*both, 0.99), c.fit(*both, 0.99)
        c.add(after, new[100:], right[100:])
        seen = [c.view(state) for state in (before, after)]
        X = [np.linalg.solve(s.R, s.z) for s in seen]
        assert np.abs(Q[:4] @ (X[1] - 3.0)).max() < 0.1
        # What is known of the combinations that the rows do not contain, given those that they do.
        known = [(Q @ s.R.T @ s.R @ Q.T)[4:, 4:] for s in seen]
        np.testing.assert_allclose(known[1], known[0], rtol=0, atol=most * np.abs(known[0]).max())

    @pytest.mark.parametrize("real", ["double", "float"])
    @pytest.mark.parametrize("kind", ["zero", "copy", "sum", "few rows"])
    def test_rank_deficiency_names_the_parameter(self, package, real, kind):
        c, (W, y) = package("rub", real), system(rows=20_000 if real == "float" else 2000)
        W = W / np.linalg.norm(W, axis=0) * np.sqrt(len(y))
        culprit = {"zero": 4, "copy": 7, "sum": 8, "few rows": 6}[kind]
        if kind == "zero":
            W[:, 3] = 0.0
        elif kind == "copy":
            W[:, 6] = 1e3 * W[:, 1]
        elif kind == "sum":
            W[:, 7] = W[:, :7].sum(axis=1)
        else:
            W, y = W[:5], y[:5]
        status, X, std, rss = c.solve(c.fit(W, y))
        assert status == culprit
        assert np.all(X == 7)
        assert np.all(std == 7)
        assert rss == 7

    def test_large_and_small_numbers(self, package):
        """Squares of the entries overflow or underflow; the solution does not."""
        c, (W, y) = package("rub"), system()
        X = c.solve(c.fit(W, y))[1]
        for factor in (1e200, 1e-200):
            status, scaled, *_ = c.solve(c.fit(factor * W, y))
            assert status == 0
            np.testing.assert_allclose(scaled * factor, X, rtol=1e-10)

    def test_what_is_not_finite_is_refused(self, package):
        c, (W, y) = package("rub"), system(rows=30)
        state = c.fit(W, y)
        before = c.bytes(state)
        for bad in (np.nan, np.inf, -np.inf):
            row = W[0].copy()
            assert c.least_squares_update(state, c.pointer(row), bad) != 0
            row[5] = bad
            assert c.least_squares_update(state, c.pointer(row), 1.0) != 0
        assert c.bytes(state) == before
        for bad in (0.0, -0.5, 1.1, np.nan):
            assert c.least_squares_init(state, bad) != 0
        assert c.bytes(state) == before


class TestIdentifier:
    @pytest.mark.parametrize("uneven", [False, True])
    @pytest.mark.parametrize("model", MODELS)
    @pytest.mark.parametrize("name", ["arm", "rub"])
    @pytest.mark.parametrize(
        ("mode", "window", "forgetting"),
        [
            ("start", 0, 1.0),
            ("sliding", 60, 1.0),
            ("sliding", 60, 0.995),
            ("sliding", 1, 1.0),
            ("sliding", 2, 1.0),
            ("consecutive", 25, 1.0),
            ("consecutive", 1, 1.0),
            ("consecutive", 2, 1.0),
        ],
    )
    def test_the_state_is_that_of_all_equations_at_once(
        self, package, name, mode, window, forgetting, uneven, model
    ):
        c = package(name)
        t = stamps(500, uneven, dt=4e-3)
        q, qd, tau = motion(t, X_ARM if name == "arm" else X_RUB, noise=0.05)
        memory, rows = c.identifier(mode, window, forgetting, model), []
        # Two logs: the windows of the first do not reach into the second.
        for part in (slice(0, 200), slice(200, 500)):
            assert c.run(memory, t[part], q[part], qd[part], tau[part]) == 0
            assert c.identifier_status(memory) == 0
            both = columns(name, model, q[part], qd[part], tau[part])
            rows.append(equations(t[part], *both, mode, window))
        rows = np.concatenate(rows)
        past = share(mode, window, 1 if model == "energy" else 2, forgetting, rows.shape[1] - 1)
        expected = folded(rows[:, :-1], rows[:, -1], past)
        assert_same(c.least_squares(memory), expected)
        status, X_c, std_c = c.read(memory)
        X = np.linalg.solve(expected.R, expected.z)
        freedom = expected.count - c.p
        sigma = np.sqrt(expected.rss / freedom) if freedom > 0 else np.nan
        std = sigma * np.linalg.norm(np.linalg.inv(expected.R), axis=1)
        assert status == 0
        condition = np.linalg.cond(expected.R / np.linalg.norm(expected.R, axis=0))
        np.testing.assert_allclose(X_c, X, rtol=0, atol=1e-12 * condition * np.abs(X).max())
        np.testing.assert_allclose(std_c, std, rtol=1e-9)

    @pytest.mark.parametrize(
        ("mode", "window", "most"), [("sliding", 60, 1), ("sliding", 1, 2), ("consecutive", 9, 1)]
    )
    def test_equations_are_spread_over_steps(self, package, mode, window, most):
        """No step takes more than it must to be ready for the next window; none is lost."""
        c, t = package("rub"), stamps(400, True)
        q, qd, tau = motion(t, X_RUB)
        memory, counts = c.identifier(mode, window, model="momentum"), [0.0]
        for k in range(400):
            assert c.step(memory, q[k], qd[k], tau[k], t[k] - t[k - 1] if k else 0.0) == 0
            counts.append(c.least_squares(memory).count)
        assert np.diff(counts).max() == most
        apart = (window + 1) // 2 if mode == "sliding" else window
        windows = (399 - DELAY) // apart - (mode == "sliding")
        assert abs(counts[-1] - 2 * windows) <= 1  # the last equation may still be to come

    def test_undetermined_parameter_is_named(self, package):
        """Joint 1 held still: ZZ1R is never excited."""
        c, t = package("arm"), stamps(200, False)
        q, qd, tau = motion(t, X_ARM)
        qd[:, 0] = 0.0
        memory = c.identifier("sliding", 20)
        assert c.run(memory, t, q, qd, tau) == 0
        status, X, std = c.read(memory)
        assert status == 1
        assert np.all(X == 7)
        assert np.all(std == 7)


class TestIntegrator:
    """One window, DL going from 0 to 1: X is the integral itself.

    The window ends some samples before the last: those are what its end waits for.
    """

    @staticmethod
    def integral(c: Package, t: np.ndarray, power: np.ndarray) -> float:
        window = t.size - 1 - DELAY
        q = (np.arange(t.size) / window)[:, None]
        one, values = np.ones_like(q), power[:, None]
        memory = c.identifier("consecutive", window)
        assert c.run(memory, t, q, one, values) == 0
        assert c.least_squares(memory).count == 1
        assert c.read(memory)[0] == 0
        return float(c.read(memory)[1][0])

    @pytest.mark.parametrize("samples", [2 + DELAY, 3 + DELAY, 50])
    @pytest.mark.parametrize("uneven", [False, True])
    def test_exact_on_cubics_from_the_first_sample_on(self, package, samples, uneven):
        t = stamps(samples, uneven, dt=0.1, jitter=0.2)
        exact = np.polyval([2, 1, -2, 5, 0], t[-1 - DELAY])
        value = self.integral(package("probe"), t, np.polyval([8, 3, -4, 5], t))
        np.testing.assert_allclose(value, exact, rtol=1e-13)

    @pytest.mark.parametrize("uneven", [False, True])
    def test_order(self, package, uneven):
        """The error falls by 32 when the step is halved; the first interval has four points."""
        steps, errors = np.array([40, 80, 160, 320]), []
        pattern = np.tile([0.7, 1.3, 1.1, 0.9], 160) if uneven else np.ones(640)
        for N in steps:
            t = np.concatenate(([0.0], np.cumsum(pattern[: N + DELAY])))
            t *= 2 / t[-1 - DELAY]
            power = np.exp(t) * (np.sin(3 * t) + 2)
            exact = np.exp(2) * ((np.sin(6) - 3 * np.cos(6)) / 10 + 2) + 0.3 - 2
            errors.append(np.abs(self.integral(package("probe"), t, power) - exact))
        orders = -np.diff(np.log2(errors))
        assert np.all(orders > 4.7)
        assert np.all(orders < 6.3)

    def test_a_gap_falls_back_to_the_trapezoid(self, package):
        t = np.r_[0.0, 0.001, 1.0 + 0.001 * np.arange(2 + DELAY)]
        power = np.r_[1.0, 2.0, 2.0, np.ones(1 + DELAY)]
        value = self.integral(package("probe"), t, power)
        assert abs(value - 2.001) < 5e-3  # a polynomial would say hundreds

    @pytest.mark.parametrize("real", ["double", "float"])
    def test_sliding_windows_do_not_drift(self, package, real):
        """Steady power for 10^5 steps: the last window is as good as the first.

        DL alternates between 0 and 1 from half to half of a window, and what was learned is thrown
        away before the last one, so that |X| is its integral, weighted by its triangle.
        """
        c, window, samples, dt = package("probe", real), 250, 100_000, 2.0**-10
        k, half = np.arange(samples), window // 2
        q = ((k // half) % 2).astype(float)[:, None]
        power = 1000.0 * (1 + 0.5 * np.sin(0.01 * k))
        memory = c.identifier("sliding", window)
        last = samples - half - 1
        assert (
            c.run(memory, k[:last] * dt, q[:last], np.ones_like(q)[:last], power[:last, None]) == 0
        )
        assert c.least_squares_init(c.identifier_state(memory), 1.0) == 0
        for j in range(last, samples):
            assert c.step(memory, q[j], [1.0], power[j : j + 1], dt) == 0
        assert c.least_squares(memory).count == 1
        rule = np.array([11, -93, 802, 802, -93, 11]) / 1440
        end = (samples - 1 - DELAY) // half * half
        each = dt * np.convolve(power, rule, "valid")[end - window - 2 : end - 2]
        triangle = np.r_[1 : half + 1, half - 1 : -1 : -1] / half
        found = abs(float(c.read(memory)[1][0]))
        rtol = 1e-11 if real == "double" else 1e-6
        np.testing.assert_allclose(found, triangle @ each, rtol=rtol)

    def test_a_long_window_in_float_keeps_its_digits(self, package):
        """10^5 equal increments: a plain float sum is off by 1e-4 or so."""
        c, window = package("probe", "float"), 100_000
        samples = window + 1 + DELAY
        q, one = (np.arange(samples) / window)[:, None], np.ones((samples, 1))
        memory = c.identifier("consecutive", window)
        assert c.run(memory, np.arange(samples) * 2.0**-10, q, one, 0.1 * one) == 0
        found = float(c.read(memory)[1][0])
        np.testing.assert_allclose(found, 0.1 * window * 2.0**-10, rtol=1e-6)


class TestRefusals:
    def test_arguments_of_init(self, package):
        c = package("arm")
        size = c.identifier_size(10)
        memory = np.zeros(c.identifier_size(0) // 8 + 2)
        address = c.ffi.from_buffer(memory)
        assert c.identifier_size(2**64 - 1) == c.identifier_size(9) < c.identifier_size(8)
        bad = [
            (c.ffi.NULL, size, 10, 1, 1.0), (address + 4, size, 10, 1, 1.0),
            *((address, n, 10, 1, 1.0) for n in (size - 1, 0)),
            *((address, size, 0, mode, 1.0) for mode in (1, 2)),
            *((address, size, 10, mode, 1.0) for mode in (3, -1)),
            *((address, size, 10, 1, forgetting) for forgetting in (0.0, 1.5, np.nan)),
        ]  # fmt: skip
        for arguments in bad:
            assert c.identifier_init(*arguments) != 0, arguments
        assert not memory.any()
        assert c.identifier_momentum_size(24) - c.identifier_size(24) == 7 * (c.p + 1) * 8
        assert c.identifier_momentum_init(address, size, 10, 1, 1.0) != 0
        assert not memory.any()
        assert c.identifier_init(address, size, 10, 1, 1.0) == 0
        assert c.identifier_init(address, c.identifier_size(0), 10**6, 2, 1.0) == 0
        assert c.identifier_init(address, c.identifier_size(0), 0, 0, 0.9) == 0

    @pytest.mark.parametrize("mode", MODES)
    @pytest.mark.parametrize("samples", [0, 1, 2, 3, 40])
    def test_bad_samples_leave_the_state_unchanged(self, package, mode, samples):
        """Whatever stage it is in, and the samples after them are taken as if nothing happened."""
        c, t = package("rub"), stamps(60, True)
        q, qd, tau = motion(t, X_RUB)
        memory, clean = c.identifier(mode, 7), c.identifier(mode, 7)
        good = [(q[k], qd[k], tau[k], t[k] - t[k - 1] if k else 0.0) for k in range(60)]
        for sample in good[:samples]:
            assert c.step(memory, *sample) == 0
        before = c.bytes(memory)
        bad = [(np.array([x, 0.1]), qd[0], tau[0], 1e-3) for x in (np.nan, np.inf)]
        bad += [(q[0], np.array([0.1, x]), tau[0], 1e-3) for x in (np.nan, -np.inf)]
        bad += [(q[0], qd[0], np.array([x, 0.1]), 1e-3) for x in (np.nan, np.inf)]
        if samples:
            bad += [(q[0], qd[0], tau[0], x) for x in (0.0, -1e-3, np.nan, np.inf)]
        bad += [(q[0], np.full(2, 1e300), tau[0], 1e-3)]
        for sample in bad:
            assert c.step(memory, *sample) != 0, sample
            # Where the energy overflows, the place of the next sample has been written to.
            assert c.bytes(memory) == before or sample[1][0] == 1e300
        for sample in good[samples:]:
            assert c.step(memory, *sample) == 0
        for sample in good:
            assert c.step(clean, *sample) == 0
        assert c.bytes(memory) == c.bytes(clean)

    def test_run_returns_the_refused_sample(self, package):
        c, t = package("arm"), stamps(60, False)
        q, qd, tau = motion(t, X_ARM)
        for k in (0, 1, 30):
            spoiled = np.where(np.arange(60) == k, np.nan, t)
            assert c.run(c.identifier("sliding", 5), spoiled, q, qd, tau) == k + 1
        back = t.copy()
        back[20] = back[19]
        assert c.run(c.identifier("sliding", 5), back, q, qd, tau) == 21
        assert c.run(c.identifier("sliding", 5), t[:0], q[:0], qd[:0], tau[:0]) == 0


class TestGuard:
    """What was learned stays: after absurd samples, and at standstill if no step is taken."""

    OUTLIER, NOT_EXCITED = 4, 8

    @staticmethod
    def learned(c, memory, rest=0):
        """Feed 3,000 samples of a good motion; return those that come after."""
        t = stamps(3000 + rest, True)
        good = [*zip(*motion(t, X_RUB, 1e-3), np.diff(t, prepend=t[0]), strict=True)]
        for sample in good[:3000]:
            assert c.step(memory, *sample) == 0
            assert c.identifier_status(memory) == 0
        return good[3000:]

    @pytest.mark.parametrize("mode", MODES)
    @pytest.mark.parametrize("forgetting", [1.0, 0.999])
    @pytest.mark.parametrize("size", [1e100, 1e7, 1e5])
    def test_an_absurd_torque_does_no_harm(self, package, mode, forgetting, size):
        c, settings = package("rub"), {"mode": mode, "window": 20, "forgetting": forgetting}
        memory = c.identifier(**settings)
        (q, qd, tau, dt), *good = self.learned(c, memory, 100)
        before = c.read(memory)[1]
        refused = c.step(memory, q, qd, tau * size, dt)
        assert (refused != 0) == (size > 1e9)
        if refused:  # steps are counted from the last sample that was taken
            good[0] = (*good[0][:3], good[0][3] + dt)
        seen = [c.identifier_status(memory)]
        for sample in good:
            assert c.step(memory, *sample) == 0
            seen.append(c.identifier_status(memory))
        assert (self.OUTLIER in seen) == (size < 1e9)
        assert self.OUTLIER not in seen[70:]  # it has left the windows
        status, X = c.read(memory)[:2]
        assert status == 0
        np.testing.assert_allclose(X, before, rtol=0.02)
        np.testing.assert_allclose(X, X_RUB, rtol=0.02)

    @staticmethod
    def resting(samples, noise, seed=5):
        """Both joints at rest, with static friction, noise of the encoders and of the torques."""
        draw = np.random.default_rng(seed)
        q = [0.3, -0.4] + 1e-5 * draw.standard_normal((samples, 2))
        tau = [0.4, -0.2] + 1e-3 * draw.standard_normal((samples, 2))
        return q, noise * draw.standard_normal((samples, 2)), tau

    @pytest.mark.parametrize(("real", "most"), [("double", 1e-6), ("float", 1e-3)])
    @pytest.mark.parametrize("noise", [0.0, 1e-4, 1e-3])
    @pytest.mark.parametrize("model", MODELS)
    def test_rest_teaches_and_forgets_nothing(self, package, model, noise, real, most):
        """Neither X nor std changes, and the status says so; the next motion goes on."""
        c, t = package("rub", real), stamps(30_000, True)
        memory = c.identifier("sliding", 20, 0.9999, model=model)
        q, qd, tau = motion(t, X_RUB, 1e-3)
        qd = qd + noise * np.random.default_rng(6).standard_normal(qd.shape)
        assert c.run(memory, t, q, qd, tau) == 0
        _, X, std = c.read(memory)
        np.testing.assert_allclose(X, X_RUB, rtol=0.03)
        assert np.all(c.excited(memory) > 0.3)
        dt = 1e-3
        for sample in zip(*self.resting(300, noise, 8), strict=True):  # the stop itself
            assert c.step(memory, *sample, dt) == 0
        _, X, std = c.read(memory)
        for sample in zip(*self.resting(20_000, noise), strict=True):
            assert c.step(memory, *sample, dt) == 0
            assert c.identifier_status(memory) == self.NOT_EXCITED
        assert c.run(memory, dt * np.arange(100_000), *self.resting(100_000, noise, 7)) == 0
        _, after, deviation = c.read(memory)
        assert np.abs(after / X - 1).max() <= most
        assert np.abs(deviation / std - 1).max() <= most
        assert c.excited(memory).max() < 1e-3
        assert c.run(memory, t, q, qd, tau) == 0
        assert c.identifier_status(memory) == 0
        np.testing.assert_allclose(c.read(memory)[1], X_RUB, rtol=0.03)
        assert np.all(c.excited(memory) > 0.3)

    @pytest.mark.parametrize("model", MODELS)
    def test_a_joint_that_moves_alone_teaches_its_own(self, package, model):
        """Joint 2 rests for ten memories: its friction stays, and X is right within its std."""
        c, t = package("rub"), stamps(30_000, True)
        memory = c.identifier("sliding", 100, 0.9998, model=model)
        assert c.run(memory, t, *motion(t, X_RUB, 1e-2)) == 0
        before = c.read(memory)[1:]
        q, qd, _ = motion(t, X_RUB)
        q[:, 1], qd[:, 1] = 0.4, 0.0
        tau = LOSING.torque(q, qd, np.gradient(qd, t, axis=0))
        draw = np.random.default_rng(3)
        tau += 1e-2 * draw.standard_normal(tau.shape)
        tau[:, 1] += 0.2  # static friction, anything
        q += 1e-5 * draw.standard_normal(q.shape)
        qd += 1e-4 * draw.standard_normal(qd.shape)
        for _ in range(2):
            assert c.run(memory, t, q, qd, tau) == 0
        _, X, std = c.read(memory)
        excited = c.excited(memory)
        assert np.all(np.abs(X - X_RUB) < 4 * std)
        assert excited[[6, 7]].max() < (0.5 if model == "energy" else 0.01) * excited[[4, 5]].min()
        if model == "momentum":  # the energy model knows the sum of what friction takes better now
            np.testing.assert_allclose(std[6:], before[1][6:], rtol=0.5)

    def test_the_noise_of_speeds_may_be_stated(self, package):
        """Where it is stated too small the joints seem to move; a negative one is refused."""
        c, t = package("rub"), stamps(3000, True)
        noise = np.full(2, 1e-12)
        memory = c.identifier("sliding", 20, 0.9999)
        assert c.identifier_rest(memory, c.pointer(noise)) == 0
        assert c.run(memory, t, *motion(t, X_RUB, 1e-3)) == 0
        for sample in zip(*self.resting(300, 1e-4), strict=True):
            assert c.step(memory, *sample, 1e-3) == 0
        rows = c.least_squares(memory).count
        assert c.identifier_rest(memory, c.pointer(np.full(2, 1e-4))) == 0
        for sample in zip(*self.resting(3000, 1e-4), strict=True):
            assert c.step(memory, *sample, 1e-3) == 0
        assert c.least_squares(memory).count < rows + 3
        for bad in (-1.0, np.nan, np.inf):
            assert c.identifier_rest(memory, c.pointer([1e-3, bad])) != 0
        assert c.identifier_rest(memory, c.ffi.NULL) == 0

    def test_a_robot_that_has_changed_is_learned_anew(self, package):
        """After some memories of 5 s, which is longer than the period of the motion."""
        c, t, other = package("rub"), stamps(60_000, True), 30 * X_RUB
        memory = c.identifier("sliding", 100, 0.9998)
        assert c.run(memory, t, *motion(t, X_RUB, 1e-3)) == 0
        assert c.run(memory, t, *motion(t, other, 1e-3)) == 0
        np.testing.assert_allclose(c.read(memory)[1], other, rtol=0.05)


class TestFloat:
    """Rounding errors in a float package do not grow with the number of rows."""

    @staticmethod
    def rows(count, seed=1):
        """Rows whose columns differ by up to 10^4, have a mean and are correlated, and y: floats.

        They come in parts, in double as the floats that they are.
        """
        draw = np.random.default_rng(seed)
        M, scale = draw.uniform(-0.5, 0.5, (8, 8)) + np.eye(8), 10 ** draw.uniform(-2, 2, 8)
        for part in [min(100_000, count - k) for k in range(0, count, 100_000)]:
            plain = (draw.uniform(-0.5, 0.5, (part, 8)) + 0.25) @ M.T
            y = plain @ np.linspace(0.5, 1.5, 8) + draw.uniform(-0.15, 0.15, part)
            yield tuple(x.astype(np.float32).astype(float) for x in (plain * scale, y))

    @pytest.mark.parametrize("rows", [300_000, pytest.param(10_000_000, marks=pytest.mark.slow)])
    def test_least_squares_over_many_rows(self, package, rows):
        """The solution is that of the normal equations in double of the same rows."""
        c = package("rub", "float")
        state, gram = c.state(), np.zeros((9, 9))
        for W, y in self.rows(rows):
            c.add(state, W, y)
            gram += np.c_[W, y].T @ np.c_[W, y]
        _, X, std, _ = c.solve(state)
        norm = np.sqrt(np.diag(gram))[:8]
        scaled = gram[:8, :8] / np.outer(norm, norm)
        expected = np.linalg.solve(scaled, gram[:8, 8] / norm) / norm
        rss = gram[8, 8] - gram[:8, 8] @ expected
        deviation = np.sqrt(rss / (rows - 8) * np.diag(np.linalg.inv(scaled))) / norm
        assert np.abs(X / expected - 1).max() < 1e-5
        np.testing.assert_allclose(std, deviation, rtol=2e-2)

    @pytest.mark.slow
    @pytest.mark.parametrize(
        ("model", "mode", "forgetting"),
        [("energy", "sliding", 1.0), ("energy", "consecutive", 0.9999),
         ("momentum", "sliding", 0.99999)],
    )  # fmt: skip
    def test_identifier_over_many_steps(self, package, model, mode, forgetting):
        """Ten million steps of noise-free motion, with reversals, return X."""
        c = package("rub", "float")
        memory = c.identifier(mode, 200, forgetting, model)
        for part in range(100):
            t = (100_000 * part + np.arange(100_000)) / 1024
            assert c.run(memory, t - t[0], *motion(t, X_RUB)) == 0
        assert np.abs(c.read(memory)[1] / X_RUB - 1).max() < 1e-5

    @pytest.mark.parametrize("forgetting", [1.0, 0.9999])
    def test_a_dependent_column_is_named_after_many_rows(self, package, forgetting):
        """Rounding does not make up a direction that the data lack."""
        c = package("rub", "float")
        state = c.state(forgetting)
        for W, y in self.rows(300_000):
            W[:, 7] = 3 * W[:, 2]
            c.add(state, W, y)
        assert c.solve(state)[0] == 8


class TestSources:
    def test_the_state_of_a_six_axis_arm_stays_below_80_kb(self, tmp_path):
        """The momentum model of the Puma 560, in double, however long the window."""
        package = Path(__file__).parents[2] / "generated" / "puma560"
        (tmp_path / "size.c").write_text(
            '#include "puma560_identifier_momentum.h"\n'
            "char enough[puma560_IDENTIFIER_MOMENTUM_BYTES(100) <= 80000 ? 1 : -1];\n"
            "char same[puma560_IDENTIFIER_MOMENTUM_BYTES(100000) == "
            "puma560_IDENTIFIER_MOMENTUM_BYTES(100) ? 1 : -1];\n"
        )
        run(["cc", "-std=c99", "-fsyntax-only", f"-I{package}", "size.c"], tmp_path)
