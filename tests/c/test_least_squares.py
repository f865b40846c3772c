"""The C runtime (least squares and identifier) against NumPy and closed forms.

The runtime is compiled into hand-written packages, with `gcc -shared`, and called by ctypes:

    arm     planar 2R arm of the original paper, no friction: n = 2, p = p_inertial = 4
    rub     the same with FS and FV on both joints: p = 8, p_inertial = 4
    probe   DL = q, so that what is integrated can be read off: n = p = p_inertial = 1
    wide    n = 1, p = p_inertial = 12, for the least squares alone
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from oracles.on_line import DELAY, equations, folded, share

from symgen.codegen.backends.c import runtime_source

FILES = ("least_squares.h", "least_squares.c", "identifier.h", "identifier.c")
MOMENTUM_FILES = ("identifier_momentum.h", "identifier_momentum.c")
GCC = shutil.which("gcc")
pytestmark = pytest.mark.skipif(GCC is None, reason="no C compiler (gcc) on this machine")

STRICT = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Wdouble-promotion"]
STRICT += ["-Werror"]
MODES = {"start": 0, "sliding": 1, "consecutive": 2}
LENGTH = 0.5

ARM = """
    const NAME_real w = qd[0] + qd[1];
    const NAME_real c = (NAME_real)(0.5 * cos((double)q[1]));
    const NAME_real s = (NAME_real)(0.5 * sin((double)q[1]));
    out[0] = qd[0] * qd[0] / 2;
    out[1] = w * w / 2;
    out[2] = w * qd[0] * c;
    out[3] = -w * qd[0] * s;
"""
RUB = """
    (void)q;
    for (int j = 0; j < 2; j++) {
        out[2 * j] = qd[j] < 0 ? -qd[j] : qd[j];
        out[2 * j + 1] = qd[j] * qd[j];
    }
"""
# The same for momentum: P = dT/dqd and dL/dq (L = T here), and the columns of friction torque.
ARM_MOMENTUM = """
    const NAME_real w = qd[0] + qd[1];
    const NAME_real c = (NAME_real)(0.5 * cos((double)q[1]));
    const NAME_real s = (NAME_real)(0.5 * sin((double)q[1]));
    const NAME_real p[8] = {qd[0], w, (w + qd[0]) * c, -(w + qd[0]) * s,
                            0, w, qd[0] * c, -qd[0] * s};
    const NAME_real dl[8] = {0, 0, 0, 0, 0, 0, -w * qd[0] * s, -w * qd[0] * c};
    for (int i = 0; i < 8; i++) {
        p_out[i] = p[i];
        dl_out[i] = dl[i];
    }
"""
RUB_TORQUE = """
    (void)q;
    for (int i = 0; i < 8; i++) {
        out[i] = 0;
    }
    for (int j = 0; j < 2; j++) {
        out[6 * j] = qd[j] > 0 ? 1 : -1;
        out[6 * j + 1] = qd[j];
    }
"""
PROBE = """
    (void)qd;
    out[0] = q[0];
"""
WIDE = """
    for (int i = 0; i < 12; i++) {
        out[i] = q[0] * qd[0];
    }
"""
PACKAGES = {
    "arm": (2, 4, 4, {"energy_regressor": ARM, "momentum_regressor": ARM_MOMENTUM}),
    "rub": (
        2,
        8,
        4,
        {
            "energy_regressor": ARM,
            "friction_power": RUB,
            "momentum_regressor": ARM_MOMENTUM,
            "friction_torque": RUB_TORQUE,
        },
    ),
    "probe": (1, 1, 1, {"energy_regressor": PROBE}),
    "wide": (1, 12, 12, {"energy_regressor": WIDE}),
}


def arm_energy(q, qd):
    """DL of the planar 2R arm, J per unit of X."""
    first, w = qd[..., 0], qd[..., 0] + qd[..., 1]
    c, s = LENGTH * np.cos(q[..., 1]), LENGTH * np.sin(q[..., 1])
    return np.stack([first**2 / 2, w**2 / 2, w * first * c, -w * first * s], axis=-1)


def arm_friction(_q, qd):
    """DF of FS1 FV1 FS2 FV2, W per unit of X."""
    first, second = qd[..., 0], qd[..., 1]
    return np.stack([abs(first), first**2, abs(second), second**2], axis=-1)


def arm_momentum(q, qd):
    """P = dT/dqd and dL/dq of the planar 2R arm, (..., 2, 4) each."""
    first, w = qd[..., 0], qd[..., 0] + qd[..., 1]
    c, s, o = LENGTH * np.cos(q[..., 1]), LENGTH * np.sin(q[..., 1]), np.zeros_like(w)
    P = [first, w, (w + first) * c, -(w + first) * s, o, w, first * c, -first * s]
    slope = [o, o, o, o, o, o, -w * first * s, -w * first * c]
    return tuple(np.stack(x, axis=-1).reshape(*w.shape, 2, 4) for x in (P, slope))


def arm_torque(_q, qd):
    """Columns of friction torque of FS1 FV1 FS2 FV2, (..., 2, 4)."""
    first, second = qd[..., 0], qd[..., 1]
    o = np.zeros_like(first)
    columns = [np.sign(first), first, o, o, o, o, np.sign(second), second]
    return np.stack(columns, axis=-1).reshape(*first.shape, 2, 4)


KERNELS = {
    "arm": (arm_energy, None),
    "rub": (arm_energy, arm_friction),
    "probe": (lambda q, _qd: q, None),
}
MODELS = ("energy", "momentum")


def columns(name, model, q, qd, tau):
    """Value and rate of every sample, (N, equations, p + 1) each, the right-hand side last."""
    energy, friction = KERNELS[name]
    if model == "energy":
        moving, slope, right = energy(q, qd)[:, None], 0.0, (qd * tau).sum(axis=1)[:, None, None]
        rubbing = friction and friction(q, qd)[:, None]
    else:
        (moving, slope), right = arm_momentum(q, qd), tau[..., None]
        rubbing = friction and arm_torque(q, qd)
    blocks = [np.zeros_like(moving) - slope, *([] if friction is None else [rubbing]), right]
    rate = np.concatenate(blocks, axis=-1)
    value = np.zeros_like(rate)
    value[..., : moving.shape[-1]] = moving
    return value, rate


def write_package(folder: Path, name: str, real: str = "double") -> list[Path]:
    """Write a package as the generator does: NAME replaced, nothing else; return its .c files."""
    joints, parameters, inertial, bodies = PACKAGES[name]
    kernels = declarations = ""
    for kernel, body in bodies.items():
        outputs = ("p_out", "dl_out") if kernel == "momentum_regressor" else ("out",)
        arguments = ", ".join(
            ["const NAME_real *q, const NAME_real *qd"] + [f"NAME_real *{o}" for o in outputs]
        )
        kernels += f"void NAME_{kernel}({arguments})\n{{{body}}}\n"
        declarations += f"void NAME_{kernel}({arguments});\n"
    header = (
        "#ifndef NAME_H\n#define NAME_H\n"
        f"#define NAME_JOINTS {joints}\n#define NAME_PARAMETERS {parameters}\n"
        f"#define NAME_INERTIAL {inertial}\ntypedef {real} NAME_real;\n"
        "enum { NAME_OK = 0, NAME_NOT_FINITE = 2, NAME_OUTLIER = 4, NAME_NOT_EXCITED = 8,"
        " NAME_CHANGING = 16384 };\n"
        '#ifdef __cplusplus\nextern "C" {\n#endif\n'
        f"{declarations}#ifdef __cplusplus\n}}\n#endif\n#endif\n"
    )
    files = FILES + (MOMENTUM_FILES if "momentum_regressor" in bodies else ())
    texts = {file: runtime_source(file, gravity_input=False, dtype=real) for file in files}
    texts = {f"NAME_{file}": text for file, text in texts.items()}
    texts["NAME.h"] = header
    texts["NAME_kernel.c"] = f'#include "NAME.h"\n#include <math.h>\n{kernels}'
    folder.mkdir(parents=True, exist_ok=True)
    for file, text in texts.items():
        path = folder / file.replace("NAME", name)
        path.write_text(text.replace("NAME", name), encoding="utf-8")
    return [folder / file.replace("NAME", name) for file in texts if file.endswith(".c")]


def compile_c(compiler: str | None, flags: list[str], sources: list[Path], output: Path) -> None:
    assert compiler is not None
    command = [compiler, *flags, *map(str, sources), "-o", str(output)]
    command += [] if "-c" in flags else ["-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""


class Package:
    """A compiled package, called by ctypes."""

    def __init__(self, folder: Path, name: str, real: str = "double") -> None:
        sources = write_package(folder, name, real)
        library = folder / f"{name}.so"
        compile_c(GCC, ["-std=c99", "-O2", "-shared", "-fPIC", *STRICT], sources, library)
        self.library = ctypes.CDLL(str(library))
        self.joints, self.p, self.inertial = PACKAGES[name][:3]
        self.dtype = np.dtype(np.float64 if real == "double" else np.float32)
        self.real = ctypes.c_double if real == "double" else ctypes.c_float
        triangle = self.p * (self.p + 1) // 2
        self.State = type(
            "State",
            (ctypes.Structure,),
            {
                "_fields_": [
                    ("R", self.real * triangle),
                    ("z", self.real * self.p),
                    ("rss", self.real),
                    ("count", self.real),
                    ("carries", self.real * ((triangle + self.p + 2) * (real == "float"))),
                    ("gathered", self.real * triangle),
                    ("forgetting", self.real),
                    ("kept", self.real),
                    ("cycle", ctypes.c_long),
                    ("rows", ctypes.c_long),
                    ("determined", ctypes.c_int),
                ]
            },
        )
        self.Solution = type(
            "Solution",
            (ctypes.Structure,),
            {
                "_fields_": [
                    ("X", self.real * self.p),
                    ("std", self.real * self.p),
                    ("missing", ctypes.c_int),
                    ("left", ctypes.c_int),
                    ("work", self.real * (1 + 2 * self.p + triangle)),
                ]
            },
        )
        pointer, size = ctypes.c_void_p, ctypes.c_size_t
        signatures = {
            "least_squares_init": (ctypes.c_int, [pointer, self.real]),
            "least_squares_update": (ctypes.c_int, [pointer, pointer, self.real]),
            "least_squares_merge": (None, [pointer, pointer]),
            "least_squares_solve": (ctypes.c_int, [pointer] * 4),
            "least_squares_begin": (None, [pointer, pointer]),
            "least_squares_proceed": (ctypes.c_int, [pointer, ctypes.c_int]),
            "identifier_size": (size, [size]),
            "identifier_init": (ctypes.c_int, [pointer, size, size, ctypes.c_int, self.real]),
            "identifier_step": (ctypes.c_int, [pointer] * 4 + [self.real]),
            "identifier_status": (ctypes.c_int, [pointer]),
            "identifier_restart": (None, [pointer]),
            "identifier_run": (ctypes.c_int, [pointer, size, *[pointer] * 4]),
            "identifier_read": (ctypes.c_int, [pointer] * 3),
            "identifier_excited": (ctypes.c_int, [pointer] * 2),
            "identifier_rest": (ctypes.c_int, [pointer] * 2),
            "identifier_state": (ctypes.POINTER(self.State), [pointer]),
        }
        if "momentum_regressor" in PACKAGES[name][3]:
            for function in ("size", "init"):
                same = signatures[f"identifier_{function}"]
                signatures[f"identifier_momentum_{function}"] = same
        for function, (result, arguments) in signatures.items():
            foreign = getattr(self.library, f"{name}_{function}")
            foreign.restype, foreign.argtypes = result, arguments
            setattr(self, function, foreign)

    def array(self, x) -> np.ndarray:
        return np.ascontiguousarray(x, dtype=self.dtype)

    def view(self, state) -> SimpleNamespace:
        """R, z, rss and count of a C state, R as a full triangle."""
        R = np.zeros((self.p, self.p))
        R[np.triu_indices(self.p)] = state.R[:]
        return SimpleNamespace(R=R, z=np.array(state.z[:]), rss=state.rss, count=state.count)

    def fit(self, W, y, forgetting=1.0):
        state = self.State()
        assert self.least_squares_init(ctypes.byref(state), forgetting) == 0
        W, y = self.array(W), self.array(y)
        for row, right in zip(W, y, strict=True):
            assert self.least_squares_update(ctypes.byref(state), row.ctypes.data, right) == 0
        return state

    def solve(self, state):
        X, std, rss = np.full(self.p, 7, self.dtype), np.full(self.p, 7, self.dtype), self.real(7)
        status = self.least_squares_solve(
            ctypes.byref(state), X.ctypes.data, std.ctypes.data, ctypes.addressof(rss)
        )
        return status, X, std, rss.value

    def identifier(self, mode="sliding", window=0, forgetting=1.0, model="energy") -> np.ndarray:
        prefix = "identifier_momentum" if model == "momentum" else "identifier"
        size = getattr(self, f"{prefix}_size")(window if mode == "sliding" else 0)
        memory = np.full(size // 8 + 1, np.nan)
        init = getattr(self, f"{prefix}_init")
        assert init(memory.ctypes.data, size, window, MODES[mode], forgetting) == 0
        return memory

    def run(self, memory, t, q, qd, tau) -> int:
        t, q, qd, tau = (self.array(x) for x in (t, q, qd, tau))
        return self.identifier_run(
            memory.ctypes.data, t.size, *(x.ctypes.data for x in (t, q, qd, tau))
        )

    def step(self, memory, q, qd, tau, dt) -> int:
        q, qd, tau = (self.array(x) for x in (q, qd, tau))
        return self.identifier_step(memory.ctypes.data, *(x.ctypes.data for x in (q, qd, tau)), dt)

    def read(self, memory):
        X, std = np.full(self.p, 7, self.dtype), np.full(self.p, 7, self.dtype)
        return self.identifier_read(memory.ctypes.data, X.ctypes.data, std.ctypes.data), X, std

    def excited(self, memory) -> np.ndarray:
        out = np.full(self.p, 7, self.dtype)
        assert self.identifier_excited(memory.ctypes.data, out.ctypes.data) == 0
        return out

    def least_squares(self, memory) -> SimpleNamespace:
        return self.view(self.identifier_state(memory.ctypes.data).contents)


@pytest.fixture(scope="module")
def package(tmp_path_factory) -> Callable[..., Package]:
    built: dict[tuple[str, str], Package] = {}

    def get(name: str, real: str = "double") -> Package:
        if (name, real) not in built:
            built[name, real] = Package(tmp_path_factory.mktemp(f"{name}_{real}"), name, real)
        return built[name, real]

    return get


def system(rows=300, p=12, seed=0):
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
X_RUB = np.array([1.7, 0.3, 0.4, 0.15, 0.6, 0.2, 0.3, 0.1])


def motion(t, X, noise=0.0, seed=1):
    """A smooth motion of the planar 2R arm and the torques of Lagrange's equations for it."""
    t = np.asarray(t)[:, None]
    w, phase = np.array([[3.1, 4.7], [7.3, 5.9]]), np.array([[0.1, 0.7], [1.3, 2.1]])
    a = np.array([[0.8, 0.9], [0.3, 0.4]])
    q = sum(a[i] * np.sin(w[i] * t + phase[i]) for i in range(2))
    qd = sum(a[i] * w[i] * np.cos(w[i] * t + phase[i]) for i in range(2))
    qdd = sum(-a[i] * w[i] ** 2 * np.sin(w[i] * t + phase[i]) for i in range(2))
    c, s = np.cos(q[:, 1]), np.sin(q[:, 1])
    A, dA = LENGTH * (X[2] * c - X[3] * s), LENGTH * (-X[2] * s - X[3] * c)
    sum_d, sum_dd = qd.sum(axis=1), qdd.sum(axis=1)
    tau = np.empty_like(q)
    tau[:, 0] = X[0] * qdd[:, 0] + X[1] * sum_dd + A * (sum_dd + qdd[:, 0])
    tau[:, 0] += dA * qd[:, 1] * (sum_d + qd[:, 0])
    tau[:, 1] = X[1] * sum_dd + A * qdd[:, 0] + dA * qd[:, 0] * (qd[:, 1] - sum_d)
    if len(X) == 8:
        tau += np.sign(qd) * X[[4, 6]] + qd * X[[5, 7]]
    tau += noise * np.random.default_rng(seed).normal(size=tau.shape)
    return q, qd, tau


def stamps(samples, uneven, dt=1e-3, seed=2, jitter=0.5):
    draw = np.random.default_rng(seed)
    steps = draw.uniform(1 - jitter, 1 + jitter, samples - 1) if uneven else 1.0
    return np.concatenate(([0.0], np.cumsum(dt * steps * np.ones(samples - 1))))


class TestLeastSquares:
    @pytest.mark.parametrize("seed", range(3))
    def test_equals_lstsq(self, package, seed):
        wide, (W, y) = package("wide"), system(seed=seed)
        X, rss, *_ = np.linalg.lstsq(W, y)
        sigma2 = rss[0] / (len(y) - wide.p)
        deviation = np.sqrt(sigma2 * np.diag(np.linalg.inv(W.T @ W)))
        state = wide.fit(W, y)
        status, X_c, std_c, rss_c = wide.solve(state)
        assert status == 0
        np.testing.assert_allclose(X_c, X, rtol=1e-10)
        np.testing.assert_allclose(std_c, deviation, rtol=1e-8)
        np.testing.assert_allclose(rss_c, rss[0], rtol=1e-10)
        assert state.count == len(y)
        R = wide.view(state).R
        assert np.all(np.diag(R) >= 0)
        np.testing.assert_allclose(R.T @ R, W.T @ W, atol=1e-9 * np.linalg.norm(W) ** 2)

    @pytest.mark.parametrize("pieces", [1, 4, 100])
    def test_a_solution_in_pieces_is_the_whole_one(self, package, pieces):
        """Of the rows there were when it began; in so many calls; the last good one stays."""
        wide, (W, y) = package("wide"), system()
        state, found = wide.fit(W, y), wide.Solution()
        whole = wide.solve(state)
        wide.least_squares_begin(ctypes.byref(found), ctypes.byref(state))
        calls = 1
        while wide.least_squares_proceed(ctypes.byref(found), pieces) > 0:
            wide.least_squares_update(ctypes.byref(state), wide.array(W[calls]).ctypes.data, 9.0)
            calls += 1
        assert calls == -(-(wide.p + 1) // pieces)
        assert found.missing == 0
        np.testing.assert_array_equal(found.X, whole[1])
        np.testing.assert_allclose(found.std, whole[2], rtol=1e-14)
        open_ = wide.fit(np.c_[W[:, :6], W[:, 1:7]], y)
        wide.least_squares_begin(ctypes.byref(found), ctypes.byref(open_))
        while wide.least_squares_proceed(ctypes.byref(found), pieces) > 0:
            pass
        assert found.missing == wide.solve(open_)[0] == 7
        np.testing.assert_array_equal(found.X, whole[1])

    def test_std_is_nan_without_a_degree_of_freedom(self, package):
        wide, (W, y) = package("wide"), system(rows=12)
        status, X, std, rss = wide.solve(wide.fit(W, y))
        assert status == 0
        np.testing.assert_allclose(W @ X, y, rtol=1e-6)
        assert np.isnan(std).all()
        assert abs(rss) < 1e-20
        noisy = wide.fit(W, y)
        noisy.rss = 1.0  # as merged states may leave it
        assert np.isnan(wide.solve(noisy)[2]).all()

    @pytest.mark.parametrize("forgetting", [1.0, 0.97])
    def test_merge_equals_one_pass(self, package, forgetting):
        """An empty state on either side changes nothing."""
        wide, (W, y) = package("wide"), system()
        head, tail = wide.fit(W[:90], y[:90], forgetting), wide.fit(W[90:], y[90:], forgetting)
        total = wide.fit(W[:0], y[:0])
        wide.least_squares_merge(ctypes.byref(total), ctypes.byref(head))
        wide.least_squares_merge(ctypes.byref(total), ctypes.byref(tail))
        wide.least_squares_merge(ctypes.byref(total), ctypes.byref(wide.fit(W[:0], y[:0])))
        one, two = folded(W[:90], y[:90], forgetting), folded(W[90:], y[90:], forgetting)
        whole = folded(np.r_[one.R, two.R], np.r_[one.z, two.z])
        whole.rss += one.rss + two.rss
        whole.count = one.count + two.count
        assert_same(wide.view(total), whole)

    def test_a_state_merged_with_itself_counts_twice(self, package):
        wide, (W, y) = package("wide"), system(rows=40)
        state = wide.fit(W, y)
        wide.least_squares_merge(ctypes.byref(state), ctypes.byref(state))
        assert_same(wide.view(state), folded(np.r_[W, W], np.r_[y, y]))

    def test_forgetting_is_that_of_the_information_matrix(self, package):
        """And where rows excite all parameters, a memory of 100 rows."""
        wide, (W, y) = package("wide"), system(rows=1000)
        state = wide.fit(W, y, 0.99)
        assert_same(wide.view(state), folded(W, y, 0.99))
        norm = np.linalg.norm(W, axis=0) / np.sqrt(len(W))
        remembered = np.mean(np.diag(wide.view(state).R.T @ wide.view(state).R) / norm**2)
        assert 70 < remembered < 130

    @pytest.mark.parametrize(("real", "most"), [("double", 1e-9), ("float", 1e-3)])
    def test_what_new_rows_do_not_excite_is_not_forgotten(self, package, real, most):
        """A hundred memories of rows in half of the parameters leave the others as they were.

        The first memory of them is left out: a cycle that begins with the rows before them forgets
        what these excite, too.
        """
        wide, (W, y) = package("wide", real), system(rows=500)
        W = W / np.linalg.norm(W, axis=0) * np.sqrt(len(W))
        Q = np.linalg.qr(np.random.default_rng(4).normal(size=(12, 12)))[0]
        new = np.random.default_rng(5).normal(size=(10_000, 6)) @ Q[:6]
        right = new @ np.full(12, 3.0) + 0.1 * np.random.default_rng(6).normal(size=len(new))
        both = np.r_[W, new[:100]], np.r_[y, right[:100]]
        before, after = wide.fit(*both, 0.99), wide.fit(*both, 0.99)
        for row, value in zip(wide.array(new[100:]), wide.array(right[100:]), strict=True):
            assert wide.least_squares_update(ctypes.byref(after), row.ctypes.data, value) == 0
        seen = [wide.view(state) for state in (before, after)]
        X = [np.linalg.solve(s.R, s.z) for s in seen]
        assert np.abs(Q[:6] @ (X[1] - 3.0)).max() < 0.1
        # What is known of the combinations that the rows do not contain, given those that they do.
        known = [(Q @ s.R.T @ s.R @ Q.T)[6:, 6:] for s in seen]
        np.testing.assert_allclose(known[1], known[0], rtol=0, atol=most * np.abs(known[0]).max())

    @pytest.mark.parametrize("real", ["double", "float"])
    @pytest.mark.parametrize("kind", ["zero", "copy", "sum", "few rows"])
    def test_rank_deficiency_names_the_parameter(self, package, real, kind):
        wide, (W, y) = package("wide", real), system(rows=20_000 if real == "float" else 2000)
        W = W / np.linalg.norm(W, axis=0) * np.sqrt(len(y))
        culprit = {"zero": 4, "copy": 7, "sum": 12, "few rows": 6}[kind]
        if kind == "zero":
            W[:, 3] = 0.0
        elif kind == "copy":
            W[:, 6] = 1e3 * W[:, 1]
        elif kind == "sum":
            W[:, 11] = W[:, :11].sum(axis=1)
        else:
            W, y = W[:5], y[:5]
        status, X, std, rss = wide.solve(wide.fit(W, y))
        assert status == culprit
        assert np.all(X == 7)
        assert np.all(std == 7)
        assert rss == 7

    def test_large_and_small_numbers(self, package):
        """Squares of the entries overflow or underflow; the solution does not."""
        wide, (W, y) = package("wide"), system()
        X = wide.solve(wide.fit(W, y))[1]
        for factor in (1e200, 1e-200):
            status, scaled, *_ = wide.solve(wide.fit(factor * W, y))
            assert status == 0
            np.testing.assert_allclose(scaled * factor, X, rtol=1e-10)

    def test_what_is_not_finite_is_refused(self, package):
        wide, (W, y) = package("wide"), system(rows=30)
        state = wide.fit(W, y)
        before = bytes(state)
        for bad in (np.nan, np.inf, -np.inf):
            row = W[0].copy()
            assert wide.least_squares_update(ctypes.byref(state), row.ctypes.data, bad) != 0
            row[5] = bad
            assert wide.least_squares_update(ctypes.byref(state), row.ctypes.data, 1.0) != 0
        assert bytes(state) == before
        for bad in (0.0, -0.5, 1.1, np.nan):
            assert wide.least_squares_init(ctypes.byref(state), bad) != 0
        assert bytes(state) == before


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
            assert c.identifier_status(memory.ctypes.data) == 0
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

    def test_run_is_restart_then_steps(self, package):
        c, t = package("rub"), stamps(300, True)
        q, qd, tau = motion(t, X_RUB)
        one, two = c.identifier("sliding", 50), c.identifier("sliding", 50)
        for memory in (one, two):
            assert c.run(memory, t[:70], q[:70], qd[:70], tau[:70]) == 0
        assert c.run(one, t[70:], q[70:], qd[70:], tau[70:]) == 0
        c.identifier_restart(two.ctypes.data)
        for k in range(70, 300):
            assert c.step(two, q[k], qd[k], tau[k], t[k] - t[k - 1] if k > 70 else np.nan) == 0
        assert one.tobytes() == two.tobytes()

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
        assert c.least_squares_init(c.identifier_state(memory.ctypes.data), 1.0) == 0
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
        address = memory.ctypes.data
        assert c.identifier_size(2**64 - 1) == c.identifier_size(9) < c.identifier_size(8)
        bad = [
            (None, size, 10, 1, 1.0), (address, size - 1, 10, 1, 1.0), (address, 0, 10, 1, 1.0),
            (address + 4, size, 10, 1, 1.0), (address, size, 0, 1, 1.0), (address, size, 0, 2, 1.0),
            (address, size, 10, 3, 1.0), (address, size, 10, -1, 1.0), (address, size, 10, 1, 0.0),
            (address, size, 10, 1, 1.5), (address, size, 10, 1, np.nan),
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
        before = memory.tobytes()
        bad = [(np.array([x, 0.1]), qd[0], tau[0], 1e-3) for x in (np.nan, np.inf)]
        bad += [(q[0], np.array([0.1, x]), tau[0], 1e-3) for x in (np.nan, -np.inf)]
        bad += [(q[0], qd[0], np.array([x, 0.1]), 1e-3) for x in (np.nan, np.inf)]
        if samples:
            bad += [(q[0], qd[0], tau[0], x) for x in (0.0, -1e-3, np.nan, np.inf)]
        bad += [(q[0], np.full(2, 1e300), tau[0], 1e-3)]
        for sample in bad:
            assert c.step(memory, *sample) != 0, sample
            # Where the energy overflows, the place of the next sample has been written to.
            assert memory.tobytes() == before or sample[1][0] == 1e300
        for sample in good[samples:]:
            assert c.step(memory, *sample) == 0
        for sample in good:
            assert c.step(clean, *sample) == 0
        assert memory.tobytes() == clean.tobytes()

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
            assert c.identifier_status(memory.ctypes.data) == 0
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
        seen = [c.identifier_status(memory.ctypes.data)]
        for sample in good:
            assert c.step(memory, *sample) == 0
            seen.append(c.identifier_status(memory.ctypes.data))
        assert (self.OUTLIER in seen) == (size < 1e9)
        assert self.OUTLIER not in seen[70:]  # it has left the windows
        status, X = c.read(memory)[:2]
        assert status == 0
        np.testing.assert_allclose(X, before, rtol=0.02)
        np.testing.assert_allclose(X, X_RUB, rtol=0.02)

    @pytest.mark.parametrize("noise", [0.0, 1e-4])
    def test_standstill_under_forgetting_teaches_the_energy_model_nothing(self, package, noise):
        c, window = package("rub"), 20
        memory = c.identifier("sliding", window, 0.999)
        self.learned(c, memory)
        before = c.read(memory)[1]
        draw = np.random.default_rng(5)
        N = 400_000
        q, qd, tau = (noise * draw.standard_normal((N, 2)) for _ in range(3))
        q, tau = q + [0.3, -0.4], tau + [2.0, -1.0]
        for part in np.split(np.arange(N), 4):
            assert c.run(memory, 1e-3 * part, q[part], qd[part], tau[part]) == 0
            assert c.identifier_status(memory.ctypes.data) == self.NOT_EXCITED
        status, X, std = c.read(memory)
        assert status == 0
        np.testing.assert_allclose(X, before, rtol=1e-6)
        assert np.isfinite(std).all()

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
            assert c.identifier_status(memory.ctypes.data) == self.NOT_EXCITED
        assert c.run(memory, dt * np.arange(100_000), *self.resting(100_000, noise, 7)) == 0
        _, after, deviation = c.read(memory)
        assert np.abs(after / X - 1).max() <= most
        assert np.abs(deviation / std - 1).max() <= most
        assert c.excited(memory).max() < 1e-3
        assert c.run(memory, t, q, qd, tau) == 0
        assert c.identifier_status(memory.ctypes.data) == 0
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
        slope = np.gradient(qd[:, 0], t)
        inertia = (
            X_RUB[0] + X_RUB[1] + 2 * LENGTH * (X_RUB[2] * np.cos(0.4) - X_RUB[3] * np.sin(0.4))
        )
        tau = np.zeros_like(qd)
        tau[:, 0] = inertia * slope + X_RUB[4] * np.sign(qd[:, 0]) + X_RUB[5] * qd[:, 0]
        draw = np.random.default_rng(3)
        tau += 1e-2 * draw.standard_normal(tau.shape)
        tau[:, 1] += 0.2  # static friction, anything
        q += 1e-5 * draw.standard_normal(q.shape)
        qd += 1e-4 * draw.standard_normal(qd.shape)
        for _ in range(2):
            assert c.run(memory, t, q, qd, tau) == 0
        _, X, std = c.read(memory)
        excited = c.excited(memory)
        print(excited, (X - X_RUB) / std)
        assert np.all(np.abs(X - X_RUB) < 4 * std)
        assert excited[[6, 7]].max() < (0.5 if model == "energy" else 0.01) * excited[[4, 5]].min()
        if model == "momentum":  # the energy model knows the sum of what friction takes better now
            np.testing.assert_allclose(std[6:], before[1][6:], rtol=0.5)

    def test_the_noise_of_speeds_may_be_stated(self, package):
        """Where it is stated too small the joints seem to move; a negative one is refused."""
        c, t = package("rub"), stamps(3000, True)
        noise = np.full(2, 1e-12)
        memory = c.identifier("sliding", 20, 0.9999)
        assert c.identifier_rest(memory.ctypes.data, noise.ctypes.data) == 0
        assert c.run(memory, t, *motion(t, X_RUB, 1e-3)) == 0
        for sample in zip(*self.resting(300, 1e-4), strict=True):
            assert c.step(memory, *sample, 1e-3) == 0
        rows = c.least_squares(memory).count
        assert c.identifier_rest(memory.ctypes.data, np.full(2, 1e-4).ctypes.data) == 0
        for sample in zip(*self.resting(3000, 1e-4), strict=True):
            assert c.step(memory, *sample, 1e-3) == 0
        assert c.least_squares(memory).count < rows + 3
        for bad in (-1.0, np.nan, np.inf):
            assert c.identifier_rest(memory.ctypes.data, np.array([1e-3, bad]).ctypes.data) != 0
        assert c.identifier_rest(memory.ctypes.data, None) == 0

    def test_a_robot_that_has_changed_is_learned_anew(self, package):
        """After some memories of 5 s, which is longer than the period of the motion."""
        c, t, other = package("rub"), stamps(60_000, True), 30 * X_RUB
        memory = c.identifier("sliding", 100, 0.9998)
        assert c.run(memory, t, *motion(t, X_RUB, 1e-3)) == 0
        assert c.run(memory, t, *motion(t, other, 1e-3)) == 0
        np.testing.assert_allclose(c.read(memory)[1], other, rtol=0.05)

    @staticmethod
    def wild(tau, share, seed=9):
        """Torques of which a share are a thousand times too large."""
        hit = np.random.default_rng(seed).random(len(tau)) < share
        return np.where(hit[:, None], 1000.0 * tau, tau)

    @pytest.mark.parametrize("forgetting", [0.9998, 1.0])
    @pytest.mark.parametrize("real", ["double", "float"])
    @pytest.mark.parametrize("model", MODELS)
    def test_a_changed_load_is_followed(self, package, model, real, forgetting):
        """A mass at the end of link 2, gripped while the arm moves; friction stays as it was."""
        c, t = package("rub", real), stamps(60_000, True)
        mass, x, y = 0.3, 0.2, 0.1
        load = [mass * LENGTH**2, mass * (x**2 + y**2), mass * x, mass * y, 0, 0, 0, 0]
        loaded = X_RUB + load
        memory = c.identifier("sliding", 20, forgetting, model=model)
        assert c.run(memory, t, *motion(t, X_RUB, 1e-2)) == 0
        assert c.run(memory, t, *motion(t, loaded, 1e-2, 2)) == 0
        _, X, std = c.read(memory)
        assert np.all(np.abs(X - loaded) < 4 * std)
        assert np.all(c.excited(memory) > 0.3)

    @pytest.mark.parametrize("real", ["double", "float"])
    @pytest.mark.parametrize("model", MODELS)
    def test_outliers_at_the_start_are_forgotten(self, package, model, real):
        c, t = package("rub", real), stamps(30_000, True)
        q, qd, tau = motion(t, X_RUB, 1e-2)
        tau[:1000] = 1000.0 * np.random.default_rng(8).standard_normal((1000, 2))
        memory = c.identifier("sliding", 20, 0.9998, model=model)
        assert c.run(memory, t, q, qd, tau) == 0
        _, X, std = c.read(memory)
        assert np.all(np.abs(X - X_RUB) < 4 * std)
        np.testing.assert_allclose(X, X_RUB, rtol=0.1)

    @pytest.mark.parametrize("real", ["double", "float"])
    @pytest.mark.parametrize("model", MODELS)
    def test_wild_samples_throughout_do_not_move_it(self, package, model, real):
        """One torque in twenty is a thousand times too large, and one speed 1000 rad/s."""
        c, t = package("rub", real), stamps(30_000, False)
        q, qd, tau = motion(t, X_RUB, 0.1)
        memory, clean = (c.identifier("sliding", 100, 0.9998, model=model) for _ in range(2))
        assert c.run(clean, t, q, qd, tau) == 0
        qd[np.random.default_rng(7).random(len(t)) < 0.05] = 1000.0
        assert c.run(memory, t, q, qd, self.wild(tau, 0.05)) == 0
        (_, X, std), expected = c.read(memory), c.read(clean)[2]
        assert np.all(np.abs(X - X_RUB) < 4 * std)
        assert np.all(std < 2 * expected)

    def test_a_glitch_of_an_encoder_does_no_harm(self, package):
        c = package("rub")
        memory = c.identifier("sliding", 20)
        (q, qd, tau, dt), *good = self.learned(c, memory, 100)
        assert c.step(memory, q, qd + [1e6, 0], tau, dt) == 0
        for sample in good:
            assert c.step(memory, *sample) == 0
        np.testing.assert_allclose(c.read(memory)[1], X_RUB, rtol=0.02)


# A program beside a float package. Rows: the columns differ by up to 10^4 in size, have a mean
# other than 0 and are correlated, from a congruential generator; what they are as floats is summed
# up as W'W and W'y in double and printed in hexadecimal with the state's own solution.
ROWS = """
#include "wide_least_squares.h"
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#define P wide_PARAMETERS
static uint64_t seed = 1;
static double uniform(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(seed >> 11) / 9007199254740992.0 - 0.5;
}
int main(int argc, char **argv)
{
    static wide_least_squares s;
    static double G[P + 1][P + 1], M[P][P], scale[P], truth[P];
    const long rows = argc > 2 ? atol(argv[1]) : 0;
    const double forgetting = argc > 2 ? (double)(wide_real)atof(argv[2]) : 0;
    wide_real X[P], std[P];
    if (wide_least_squares_init(&s, (wide_real)forgetting)) return 1;
    for (int i = 0; i < P; i++) {
        truth[i] = 1 + uniform();
        scale[i] = pow(10, 4 * uniform());
        for (int j = 0; j < P; j++) M[i][j] = uniform() + (i == j);
    }
    for (long k = 0; k < rows; k++) {
        double u[P], r[P + 1];
        wide_real row[P];
        r[P] = 0.3 * uniform();
        for (int i = 0; i < P; i++) u[i] = uniform() + 0.25;
        for (int i = 0; i < P; i++) {
            double a = 0;
            for (int j = 0; j < P; j++) a += M[i][j] * u[j];
            row[i] = (wide_real)(a * scale[i]);
            r[i] = (double)row[i];
            r[P] += a * truth[i];
        }
        r[P] = (double)(wide_real)r[P];
        if (wide_least_squares_update(&s, row, (wide_real)r[P])) return 2;
        for (int i = 0; i <= P; i++)
            for (int j = 0; j <= P; j++) G[i][j] = forgetting * G[i][j] + r[i] * r[j];
    }
    if (wide_least_squares_solve(&s, X, std, NULL)) return 3;
    for (int i = 0; i < P; i++) printf("%a ", (double)X[i]);
    for (int i = 0; i < P; i++) printf("%a ", (double)std[i]);
    for (int i = 0; i <= P; i++)
        for (int j = 0; j <= P; j++) printf("%a ", G[i][j]);
    return 0;
}
"""

# Lagrange's equations of the arm with friction, at 1024 Hz for so many steps; prints X.
STEPS = """
#include "rub_identifier_momentum.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
int main(int argc, char **argv)
{
    static union {
        rub_identifier head;
        unsigned char bytes[rub_IDENTIFIER_MOMENTUM_BYTES(200)];
    } memory;
    static const double x[8] = {1.7, 0.3, 0.4, 0.15, 0.6, 0.2, 0.3, 0.1};
    const long steps = argc > 4 ? atol(argv[1]) : 0;
    const rub_real forgetting = argc > 4 ? (rub_real)atof(argv[2]) : 0;
    rub_real X[8];
    if (argc < 5 || (argv[3][0] == 'm' ? rub_identifier_momentum_init : rub_identifier_init)(
                        &memory, sizeof memory, 200, atoi(argv[4]), forgetting)) return 1;
    for (long k = 0; k < steps; k++) {
        const double t = (double)k / 1024;
        const double w[2][2] = {{3.1, 4.7}, {7.3, 5.9}}, a[2][2] = {{0.8, 0.9}, {0.3, 0.4}};
        double q[2] = {0}, v[2] = {0}, z[2] = {0};
        for (int i = 0; i < 2; i++)
            for (int j = 0; j < 2; j++) {
                const double c = cos(w[i][j] * t + j), s = sin(w[i][j] * t + j);
                q[j] += a[i][j] * s;
                v[j] += a[i][j] * w[i][j] * c;
                z[j] -= a[i][j] * w[i][j] * w[i][j] * s;
            }
        const double A = 0.5 * (x[2] * cos(q[1]) - x[3] * sin(q[1]));
        const double B = -0.5 * (x[2] * sin(q[1]) + x[3] * cos(q[1]));
        double u[2];
        u[0] = x[0] * z[0] + x[1] * (z[0] + z[1]) + A * (2 * z[0] + z[1])
             + B * v[1] * (2 * v[0] + v[1]);
        u[1] = x[1] * (z[0] + z[1]) + A * z[0] - B * v[0] * v[0];
        rub_real qf[2], vf[2], uf[2];
        for (int j = 0; j < 2; j++) {
            u[j] += (v[j] > 0 ? 1 : -1) * x[4 + 2 * j] + v[j] * x[5 + 2 * j];
            qf[j] = (rub_real)q[j];
            vf[j] = (rub_real)v[j];
            uf[j] = (rub_real)u[j];
        }
        if (rub_identifier_step(&memory, qf, vf, uf, (rub_real)(1.0 / 1024))) return 2;
    }
    if (rub_identifier_read(&memory, X, NULL)) return 3;
    for (int i = 0; i < 8; i++) printf("%a ", (double)X[i]);
    return 0;
}
"""


class TestFloat:
    """Rounding errors in a float package do not grow with the number of rows."""

    @staticmethod
    def program(folder: Path, name: str, text: str) -> Path:
        (folder / "main.c").write_text(text, encoding="utf-8")
        sources = [folder / "main.c", *write_package(folder, name, "float")]
        compile_c(GCC, ["-std=c99", "-O2"], sources, folder / "main")
        return folder / "main"

    @staticmethod
    def output(program: Path, *arguments) -> np.ndarray:
        command = [str(program), *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0
        return np.array([float.fromhex(x) for x in done.stdout.split()])

    @pytest.mark.parametrize(
        ("rows", "forgetting"),
        [
            (300_000, 1.0),
            pytest.param(10_000_000, 1.0, marks=pytest.mark.slow),
            pytest.param(10_000_000, 0.999999, marks=pytest.mark.slow),
        ],
    )
    def test_least_squares_over_many_rows(self, tmp_path, rows, forgetting):
        """The solution is that of the normal equations in double of the same rows."""
        p = PACKAGES["wide"][1]
        out = self.output(self.program(tmp_path, "wide", ROWS), rows, forgetting)
        X, std, gram = out[:p], out[p : 2 * p], out[2 * p :].reshape(p + 1, p + 1)
        norm = np.sqrt(np.diag(gram))[:p]
        scaled = gram[:p, :p] / np.outer(norm, norm)
        expected = np.linalg.solve(scaled, gram[:p, p] / norm) / norm
        rss = gram[p, p] - gram[:p, p] @ expected
        weight = (1 - forgetting**rows) / (1 - forgetting) if forgetting < 1 else rows
        deviation = np.sqrt(rss / (weight - p) * np.diag(np.linalg.inv(scaled))) / norm
        error = np.abs(X / expected - 1).max()
        condition = np.sqrt(np.linalg.cond(scaled))
        print(f"{rows} rows, forgetting {forgetting}, condition {condition:.0f}: {error:.1e}")
        assert error < 1e-5
        np.testing.assert_allclose(std, deviation, rtol=2e-2)  # forgetting itself is a float

    @pytest.mark.slow
    @pytest.mark.parametrize("steps", [10_000_000])
    @pytest.mark.parametrize(
        ("model", "mode", "forgetting"),
        [("energy", 1, 1.0), ("energy", 2, 0.9999), ("momentum", 1, 0.99999)],
    )
    def test_identifier_over_many_steps(self, tmp_path, steps, model, mode, forgetting):
        """Noise-free motion, with reversals, returns X."""
        program = self.program(tmp_path, "rub", STEPS)
        error = np.abs(self.output(program, steps, forgetting, model, mode) / X_RUB - 1).max()
        print(f"{steps} steps, {model}, mode {mode}, forgetting {forgetting}: {error:.1e}")
        assert error < 1e-5

    def test_a_dependent_column_is_named_after_many_rows(self, tmp_path):
        """Rounding does not make up a direction that the data lack."""
        text = ROWS.replace(
            "if (wide_least_squares_update", "row[7] = 3 * row[2]; if (wide_least_squares_update"
        )
        program = self.program(tmp_path, "wide", text)
        for forgetting in ("1", "0.9999"):
            command = [str(program), "300000", forgetting]
            assert subprocess.run(command, capture_output=True, check=False).returncode == 3


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
        flags = ["-std=c99", "-fsyntax-only", f"-I{package}", "-c"]
        compile_c(GCC, flags, [tmp_path / "size.c"], tmp_path / "size.o")
