"""The identifier on line: samples in, one at a time; the least-squares core that runs in C.

The same C files that a generated package carries; without a C compiler their NumPy twin.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from symgen.errors import IdentificationError, LogError
from symgen.identification.online.twin import (
    NOT_EXCITED,
    OUTLIER,
    WindowIdentifier,
    energy_columns,
    momentum_columns,
)
from symgen.robot.types import require_gravity
from symgen.runtime.evaluator import Evaluator

FloatArray = NDArray[np.float64]
_KERNELS = {
    "energy": ("energy_regressor", "friction_power"),
    "momentum": ("momentum_regressor", "friction_torque"),
}
_MODES = {"start": 0, "sliding": 1, "consecutive": 2}


class Identifier:
    """Recursive least squares on the energy theorem, or on momentum, sample by sample.

    Integrals by the polynomial through the six samples around each step (sixth order; a window
    closes seven samples after its last, and its equations are taken one a step); QR by Givens
    rotations, so that no covariance is inverted and none can lose its sign.

    Args:
        evaluator: the loaded model.
        window: length of a window in samples; without meaning for mode "start".
        mode: "start", "sliding" or "consecutive".
        forgetting: weight of the past for each new sample, in (0, 1].
        model: "energy", one equation a window, or "momentum", n equations a window, all with the
            same weight.

    Raises:
        IdentificationError: an argument is out of its range, or the evaluator lacks a kernel that
            the model needs.
    """

    def __init__(
        self,
        evaluator: Evaluator,
        window: int = 1,
        mode: str = "sliding",
        forgetting: float = 1.0,
        model: str = "energy",
    ) -> None:
        if model not in _KERNELS:
            raise IdentificationError(f"model {model!r}; accepted: {', '.join(_KERNELS)}")
        if mode not in _MODES:
            raise IdentificationError(f"mode {mode!r}; accepted: {', '.join(_MODES)}")
        if not 0 < forgetting <= 1 or (mode != "start" and window < 1):
            raise IdentificationError(
                f"window {window}, forgetting {forgetting}; accepted: window of at least 1 sample, "
                "forgetting above 0 and at most 1"
            )
        derived = evaluator.model
        require_gravity(derived.robot, "identification on line in Python")
        rubs = len(derived.base.parameters) > derived.inertial
        for kernel in _KERNELS[model][: 2 if rubs else 1]:
            if not evaluator.has(kernel):
                raise IdentificationError(
                    f"model {model} needs the kernel {kernel}; accepted: a model derived with it"
                )
        self._names = derived.base.names
        self._n = derived.robot.n
        self._time: float | None = None
        self._core: _CCore | _NumpyCore
        if evaluator.library is not None:
            self._core = _CCore(evaluator, window, mode, forgetting, model)
        else:
            self._core = _NumpyCore(evaluator, window, mode, forgetting, model)

    def step(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, t: float) -> None:
        """Take one sample.

        With forgetting below 1, do not call it while the robot stands: noise in qd then changes the
        estimate. Call `restart` when the robot moves again.

        Args:
            q: joint variables (n,), rad or m.
            qd: speeds (n,).
            tau: torques (n,), N m or N.
            t: time of the sample, s; later than that of the sample before.

        Raises:
            LogError: a number is not finite or larger than 1e9, or time does not advance; the state
                is unchanged.
        """
        dt = 0.0 if self._time is None else t - self._time
        arrays = [np.ascontiguousarray(a, dtype=np.float64) for a in (q, qd, tau)]
        if any(a.shape != (self._n,) for a in arrays) or self._core.step(arrays, dt):
            raise LogError(
                f"the sample at t = {t:g} s is refused; accepted: {self._n} finite values each of "
                "q, qd and tau, at a later time than the last"
            )
        self._time = t

    def run(self, t: ArrayLike, q: ArrayLike, qd: ArrayLike, tau: ArrayLike) -> None:
        """Take a whole log, t (N,), q, qd, tau (N, n), in one compiled loop; windows begin anew.

        Raises:
            LogError: a sample is refused; those before it have been taken.
        """
        time, *rest = (np.ascontiguousarray(a, dtype=np.float64) for a in (t, q, qd, tau))
        if any(a.shape != (len(time), self._n) for a in rest):
            raise LogError(f"t (N,) and q, qd, tau (N, {self._n}) are needed")
        refused = self._core.run(time, rest)
        taken = refused - 1 if refused else len(time)
        self._time = float(time[taken - 1]) if taken else None
        if refused:
            raise LogError(f"sample {refused} of the log is refused: not finite, or not later")

    def restart(self) -> None:
        """Forget the open windows, not what was learned: the next sample begins a new log."""
        self._core.restart()
        self._time = None

    def read(self) -> tuple[FloatArray, FloatArray]:
        """Return the estimate X and its standard deviations, (p,) each, in the order of X.

        Raises:
            IdentificationError: the samples so far do not determine every parameter.
        """
        return self._core.read(self._names)

    @property
    def status(self) -> str:
        """What came of the equations that the latest sample closed.

        "taken"; "outlier", where one contradicts the estimate so far and was left out; "not
        excited", where it would teach less than is forgotten. It is no test of standstill: see
        `step`.
        """
        status = self._core.status()
        return "outlier" if status & OUTLIER else "not excited" if status & NOT_EXCITED else "taken"

    @property
    def R(self) -> FloatArray:
        """Square root of the information matrix, (p, p) upper triangle: R'R = W'W."""
        return self._core.triangle()


def _undetermined(name: str) -> IdentificationError:
    return IdentificationError(
        f"the samples so far do not determine {name}: its column depends on those before it"
    )


class _CCore:
    def __init__(
        self, evaluator: Evaluator, window: int, mode: str, forgetting: float, model: str
    ) -> None:
        module: Any = evaluator.library
        self._ffi, lib, name = module.ffi, module.lib, evaluator.model.robot.name
        self._lib = {
            f: getattr(lib, f"{name}_identifier_{f}")
            for f in ("step", "status", "restart", "run", "read", "state")
        }
        prefix = f"{name}_identifier" + ("" if model == "energy" else f"_{model}")
        size_of, init = (getattr(lib, f"{prefix}_{f}") for f in ("size", "init"))
        self._p = len(evaluator.model.base.parameters)
        window = window if mode == "sliding" else max(1, window)
        size = size_of(window if mode == "sliding" else 0)
        self._memory = np.zeros(size // 8 + 2)
        self._state = self._ffi.from_buffer(self._memory)
        bytes_ = self._memory.nbytes
        if size == 0 or init(self._state, bytes_, window, _MODES[mode], forgetting):
            raise IdentificationError("the identifier refused its settings")

    def step(self, arrays: Sequence[FloatArray], dt: float) -> int:
        pointers = [self._ffi.from_buffer("double *", a) for a in arrays]
        return int(self._lib["step"](self._state, *pointers, dt))

    def status(self) -> int:
        return int(self._lib["status"](self._state))

    def restart(self) -> None:
        self._lib["restart"](self._state)

    def run(self, t: FloatArray, arrays: Sequence[FloatArray]) -> int:
        pointers = [self._ffi.from_buffer("double *", a) for a in (t, *arrays)]
        return int(self._lib["run"](self._state, len(t), *pointers))

    def read(self, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        X, std = np.empty(self._p), np.empty(self._p)
        pointers = [self._ffi.from_buffer("double *", a) for a in (X, std)]
        lost = self._lib["read"](self._state, *pointers)
        if lost:
            raise _undetermined(names[lost - 1])
        return X, std

    def triangle(self) -> FloatArray:
        state = self._lib["state"](self._state)
        out = np.zeros((self._p, self._p))
        out[np.triu_indices(self._p)] = list(state.R)
        return out


class _NumpyCore:
    def __init__(
        self, evaluator: Evaluator, window: int, mode: Any, forgetting: float, model: str
    ) -> None:
        p = len(evaluator.model.base.parameters)
        regressor, friction = _KERNELS[model]
        columns = energy_columns if model == "energy" else momentum_columns
        rubs = p > evaluator.model.inertial
        self._twin = WindowIdentifier(
            columns(evaluator[regressor], evaluator[friction] if rubs else None),
            p,
            1 if model == "energy" else evaluator.model.robot.n,
            mode=mode,
            window=0 if mode == "start" else window,
            forgetting=forgetting,
        )

    def step(self, arrays: Sequence[FloatArray], dt: float) -> int:
        q, qd, tau = arrays
        return self._twin.step(q, qd, tau, dt)

    def status(self) -> int:
        return self._twin.status

    def restart(self) -> None:
        self._twin.restart()

    def run(self, t: FloatArray, arrays: Sequence[FloatArray]) -> int:
        q, qd, tau = arrays
        return self._twin.run(t, q, qd, tau)

    def read(self, names: Sequence[str]) -> tuple[FloatArray, FloatArray]:
        lost = self._twin.least_squares.undetermined()
        if lost:
            raise _undetermined(names[lost - 1])
        return self._twin.read()

    def triangle(self) -> FloatArray:
        return self._twin.least_squares.R.copy()
