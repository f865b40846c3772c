"""The on-line identifier, which passes samples to the C code of a generated package."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from symgen.data.raw import FloatArray
from symgen.errors import BuildError, IdentificationError, LogError
from symgen.estimation.equation_model import NEEDED
from symgen.robot.types import require_gravity
from symgen.runtime.evaluator import Evaluator
from symgen.runtime.identifier import identifier_module

_MODELS = ("energy", "momentum")
_MODES = ("start", "sliding", "consecutive")  # as identifier.h numbers them
_OUTLIER, _NOT_EXCITED, _CHANGING = 4, 8, 16384  # as NAME.h numbers them


class Identifier:
    """Recursive least squares on the energy or momentum equations, sample by sample.

    Integrals use the polynomial through the six samples around each step (sixth order). A window
    closes ten samples after its last one. Each step then takes one of its equations. Givens
    rotations update the QR factors, so no covariance matrix is inverted.

    A joint rests if its speed is below the noise. While all joints rest, the identifier learns
    and forgets nothing. Otherwise it forgets only in the directions that the motion excites.

    The median of its neighbours replaces a single absurd sample. If the robot changes, for example
    by a load, the status is "changing" and X stays, until a second estimate from newer equations
    predicts new equations better, and those of the motion before the change well enough.

    Args:
        evaluator: the loaded model, compiled (`symgen.load(model, backend="c")`).
        window: length of a window in samples; not used in mode "start".
        mode: "start", "sliding" or "consecutive".
        forgetting: weight of the past for each new sample, in (0, 1]. The memory of
            1 / (1 - forgetting) samples should be longer than the period of the motion. It contains
            at least 4 p equations.
        model: "energy", with one equation for each window, or "momentum", with n equations of equal
            weight for each window.
        speed_noise: (n,) standard deviations of the noise of qd, rad/s or m/s. None, or 0 for a
            joint, estimates them.

    Raises:
        IdentificationError: an argument is out of its range, or the evaluator lacks a kernel that
            the model needs.
        BuildError: the evaluator is not compiled.
    """

    def __init__(
        self,
        evaluator: Evaluator,
        window: int = 1,
        mode: str = "sliding",
        forgetting: float = 1.0,
        model: str = "energy",
        speed_noise: ArrayLike | None = None,
    ) -> None:
        if model not in _MODELS:
            raise IdentificationError(f"model {model!r}; accepted: {', '.join(_MODELS)}")
        if mode not in _MODES:
            raise IdentificationError(f"mode {mode!r}; accepted: {', '.join(_MODES)}")
        derived = evaluator.model
        require_gravity(derived.robot, "identification on line in Python")
        self._names = derived.base.names
        self._n, self._p = derived.robot.n, len(self._names)
        for kernel in NEEDED[model][: 2 if self._p > derived.inertial else 1]:
            if not evaluator.has(kernel):
                raise IdentificationError(
                    f"model {model} needs the kernel {kernel}; accepted: a model derived with it"
                )
        if evaluator.backend != "c":
            raise BuildError(
                "identification on line needs a compiled model; install a C compiler "
                "(pip install 'symgen[cc]' brings one) and load the model with backend 'c'"
            )
        module = identifier_module(derived)
        self._ffi, self._lib = module.ffi, module.lib
        self._prefix = f"{derived.robot.name}_identifier"
        begin = "" if model == "energy" else f"_{model}"
        size = self._call(f"{begin}_size", window if mode == "sliding" and window > 0 else 0)
        self._memory = np.zeros(size // 8 + 2)
        self._state = self._ffi.from_buffer(self._memory)
        settings = max(window, 0), _MODES.index(mode), forgetting
        if self._call(f"{begin}_init", self._state, self._memory.nbytes, *settings):
            raise IdentificationError(
                f"window {window}, forgetting {forgetting}; accepted: window of at least 1 sample, "
                "forgetting above 0 and at most 1"
            )
        self._time: float | None = None
        if speed_noise is not None:
            noise = np.ascontiguousarray(speed_noise, dtype=np.float64)
            if noise.shape != (self._n,) or self._call("_rest", self._state, noise):
                raise IdentificationError(
                    f"speed_noise {speed_noise}; accepted: {self._n} finite numbers of at least 0"
                )

    def _call(self, function: str, *arguments: Any) -> Any:
        """Call a C function of the identifier, with arrays as pointers."""
        pointers = (
            self._ffi.from_buffer("double *", a) if isinstance(a, np.ndarray) else a
            for a in arguments
        )
        return getattr(self._lib, self._prefix + function)(*pointers)

    def step(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, t: float) -> None:
        """Take one sample.

        Args:
            q: joint variables (n,), rad or m.
            qd: speeds (n,), rad/s or m/s.
            tau: torques (n,), N m or N.
            t: time of the sample, s; later than that of the previous sample.

        Raises:
            LogError: a number is not finite or larger than 1e9, or time does not advance. The state
                is then unchanged.
        """
        dt = 0.0 if self._time is None else t - self._time
        arrays = [np.ascontiguousarray(a, dtype=np.float64) for a in (q, qd, tau)]
        if any(a.shape != (self._n,) for a in arrays) or self._call(
            "_step", self._state, *arrays, dt
        ):
            raise LogError(
                f"the sample at t = {t:g} s is refused; accepted: {self._n} finite values each of "
                "q, qd and tau, at a later time than the last"
            )
        self._time = t

    def run(self, t: ArrayLike, q: ArrayLike, qd: ArrayLike, tau: ArrayLike) -> None:
        """Take all samples of a log in one compiled loop, with new windows.

        Args:
            t: times (N,), s.
            q: joint variables (N, n), rad or m.
            qd: speeds (N, n), rad/s or m/s.
            tau: torques (N, n), N m or N.

        Raises:
            LogError: the identifier refuses a sample. The estimate contains the samples before it.
        """
        time, *rest = (np.ascontiguousarray(a, dtype=np.float64) for a in (t, q, qd, tau))
        if any(a.shape != (len(time), self._n) for a in rest):
            raise LogError(f"t (N,) and q, qd, tau (N, {self._n}) are needed")
        refused = self._call("_run", self._state, len(time), time, *rest)
        taken = refused - 1 if refused else len(time)
        self._time = float(time[taken - 1]) if taken else None
        if refused:
            raise LogError(f"sample {refused} of the log is refused: not finite, or not later")

    def read(self) -> tuple[FloatArray, FloatArray]:
        """Return the estimate X and its standard deviations, (p,) each, in the order of X.

        While the status is "changing", they are those of before the change.

        Raises:
            IdentificationError: the samples so far do not determine every parameter.
        """
        X, std = np.empty(self._p), np.empty(self._p)
        found = self._call("_read", self._state, X, std)
        self._require(0 if found == _CHANGING else found)
        return X, std

    def excited(self) -> FloatArray:
        """Return how far recent samples determine each parameter, (p,) from 0 to 1.

        The number is the relative reduction of the parameter's variance by the samples of the last
        one to two memories. It is 0 if the value relies on older samples.

        Raises:
            IdentificationError: the samples so far do not determine every parameter.
        """
        out = np.empty(self._p)
        self._require(self._call("_excited", self._state, out))
        return out

    def _require(self, missing: int) -> None:
        if missing:
            raise IdentificationError(
                f"the samples so far do not determine {self._names[missing - 1]}: its column "
                "depends on those before it"
            )

    @property
    def status(self) -> str:
        """Result for the equations that the latest sample closed.

        - "changing": recent equations contradict X, which is that of before a change of the robot,
          such as a load.
        - "taken": the identifier used them.
        - "outlier": an equation contradicts the estimate and is not used, or a sample was absurd
          and is replaced.
        - "not excited": an equation has less information than the identifier would forget, or
          joints rest.
        """
        status = self._call("_status", self._state)
        if status & _CHANGING:
            return "changing"
        if status & _OUTLIER:
            return "outlier"
        return "not excited" if status & _NOT_EXCITED else "taken"
