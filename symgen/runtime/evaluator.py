"""Evaluate a model: in compiled C, or in CasADi's virtual machine without a compiler.

Inputs and outputs are NumPy arrays: one sample, a batch, or fixed buffers for fast loops.
"""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from functools import cache, cached_property, lru_cache, partial
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from symgen.cache import digest
from symgen.codegen.backends import c
from symgen.codegen.backends.casadi import casadi_functions
from symgen.codegen.derivations import Derivations
from symgen.codegen.kernel import Kernel
from symgen.codegen.model import Model, derive
from symgen.codegen.panels import panelled
from symgen.errors import BuildError, ParameterError, SymgenWarning
from symgen.robot.toml_io import parse_robot
from symgen.robot.types import Robot
from symgen.runtime.build import (
    Compiler,
    build_module,
    find_compiler,
    missing_compiler,
)
from symgen.runtime.calls import (
    NOT_FINITE,
    NOT_POSITIVE_DEFINITE,
    Bound,
    FloatArray,
    buffers,
    checked,
    result,
)
from symgen.runtime.flags import kernel_flags
from symgen.runtime.kernel_methods import KernelMethods
from symgen.views import Viewable

if TYPE_CHECKING:
    from symgen.runtime.panels import Panels

_BLOCK = 512  # samples that CasADi evaluates in one call
#: A batch with at least this many samples uses panels, which are compiled on first use.
MANY = 2**17


class KernelFunction(ABC):
    """One kernel, callable on NumPy arrays.

    Attributes:
        kernel: the kernel.
        robot: robot of the kernel.
        backend: "c" or "casadi".
    """

    kernel: Kernel
    robot: Robot
    backend: str

    def __reduce__(self) -> tuple[Callable[..., KernelFunction], tuple[Robot, str, str]]:
        """Pickle the robot and the name; unpickling compiles or finds the compiled module."""
        return _loaded_kernel, (self.robot, self.kernel.name, _elsewhere(self.backend))

    def __call__(self, *inputs: ArrayLike, **named: ArrayLike) -> Any:
        """Evaluate one sample, inputs (n,), or a batch, inputs (N, n); all samples share X.

        The last inputs can be passed by name.

        Returns:
            The output array, or a tuple of arrays if the kernel has several outputs.

        Raises:
            ParameterError: a shape is wrong. Or a kernel with a status, such as forward_dynamics,
                finds that M is not positive definite, or that a number is not finite.
        """
        last = (named[a.name] for a in self.kernel.inputs if a.name in named)
        arrays, count = checked(self.kernel, (*inputs, *last))
        if count is not None and count >= MANY:
            panels = self.panels()
            if panels is not None:
                return panels(*arrays)
        lead = () if count is None else (count,)
        outputs = [np.empty((*lead, *o.shape)) for o in self.kernel.outputs]
        status = self._bound(arrays, outputs, count)() or 0
        return result(self.kernel, outputs, status)

    def bind(self, count: int | None = None) -> Bound:
        """Return the kernel on fixed buffers, for one sample or for a batch of `count`."""
        inputs, outputs = buffers(self.kernel, count)
        return Bound(inputs, outputs, self._bound(inputs, outputs, count))

    def panels(self) -> Panels | None:
        """Compile the kernel for panels of samples; return None if that is not possible."""
        return None

    @abstractmethod
    def _bound(
        self, inputs: Sequence[FloatArray], outputs: Sequence[FloatArray], count: int | None
    ) -> Callable[[], int | None]:
        """Return a call that evaluates the kernel from arrays into arrays, and returns a status."""


class Evaluator(Viewable, KernelMethods):
    """A loaded model: every kernel is a method, `evaluator.mass_matrix(q, X)`.

    Every method takes one sample, arrays (n,), or N samples, (N, n), and X (p,), which all samples
    share. If gravity is an input, g (3,) is the last argument. The result for N samples has a first
    axis N. Indexing by name gives a function that can be bound to fixed buffers or compiled for
    panels: `evaluator["mass_matrix"].bind()`. If the model lacks the kernel, a ParameterError lists
    the available ones.

    Attributes:
        model: the derived model.
        backend: "c" or "casadi".
    """

    def __init__(self, model: Model, functions: Sequence[KernelFunction], backend: str) -> None:
        self.model = model
        self.backend = backend
        self._functions = {f.kernel.name: f for f in functions}

    def __repr__(self) -> str:
        """Return robot, kernels and backend."""
        count, by = len(self._functions), "compiled C" if self.backend == "c" else "CasADi"
        return f"<Evaluator of {self.model.robot.name}: {count} kernels by {by}>"

    def __reduce__(self) -> tuple[Callable[[Model], Evaluator], tuple[Model]]:
        """Pickle the model; the process that unpickles it compiles or finds the compiled module."""
        return partial(load, backend=_elsewhere(self.backend)), (self.model,)

    def has(self, name: str) -> bool:
        """Return whether the model was derived with this kernel."""
        return name in self._functions

    def __getitem__(self, name: str) -> KernelFunction:
        """Return a kernel by its name.

        Raises:
            ParameterError: the model has no such kernel.
        """
        try:
            return self._functions[name]
        except KeyError:
            raise ParameterError(
                f"kernel {name!r} is not in this model; accepted: {', '.join(self._functions)}"
            ) from None

    def friction_power(self, q: ArrayLike, qd: ArrayLike) -> FloatArray:
        """Return the columns (p - p_inertial,) of friction power, W; empty without friction."""
        if not self.has("friction_power"):
            return np.zeros((*np.shape(q)[:-1], 0))
        return np.asarray(self["friction_power"](q, qd))


def load(robot: Robot | Model | str | Path, *, backend: str = "auto") -> Evaluator:
    """Derive, compile and load a robot's model.

    Args:
        robot: a robot, its model, a path, or a library name.
        backend: "c" (needs a C compiler), "casadi", or "auto". "auto" uses C if possible, and
            otherwise CasADi, with a warning.

    Raises:
        BuildError: backend "c" was requested and is not available.
        RobotError: there is no such robot.
    """
    model = robot if isinstance(robot, Model) else derive(robot)
    if backend not in ("auto", "c", "casadi"):
        raise ParameterError(f"backend {backend!r}; accepted: auto, c, casadi")
    if backend != "casadi":
        compiler = find_compiler()
        try:
            if compiler is None:
                raise BuildError(missing_compiler())
            return _compiled(model, compiler)
        except BuildError as error:
            if backend == "c":
                raise
            _say_once(f"{error}; CasADi evaluates the model instead, which is slower")
    built = casadi_functions(model.robot.name, model.robot, model.kernels)
    functions = [_CasadiKernel(k, model.robot, built[k.name]()) for k in model.kernels]
    return Evaluator(model, functions, "casadi")


@lru_cache(maxsize=8)
def load_model(robot: str, kernels: tuple[str, ...]) -> Evaluator:
    """Compile and load a model once in each process.

    Args:
        robot: text of the robot.toml.
        kernels: names of the kernels.
    """
    return load(derive(parse_robot(robot, "robot.toml"), kernels))


def _elsewhere(backend: str) -> str:
    """Return the backend for another process, whose machine may have no C compiler."""
    return "auto" if backend == "c" else backend


def _loaded_kernel(robot: Robot, name: str, backend: str) -> KernelFunction:
    return load(derive(robot, (name,)), backend=backend)[name]


@cache
def _say_once(message: str) -> None:
    warnings.warn(message, SymgenWarning, stacklevel=3)


def _compiled(model: Model, compiler: Compiler) -> Evaluator:
    kernels = digest(*(kernel.name for kernel in model.kernels))
    kept = Derivations.of(model.robot)
    sources = kept.have(f"sources-{kernels[:16]}", lambda: c.functions(model))
    name = model.robot.name
    declarations = "\n".join(line for k in model.kernels for line in k.prototypes(name, "double"))
    module = build_module(sources, declarations, compiler, kernel_flags(compiler))
    functions = [_CKernel(k, model, module, compiler) for k in model.kernels]
    return Evaluator(model, functions, "c")


class _CKernel(KernelFunction):
    backend = "c"

    def __init__(
        self, kernel: Kernel, model: Model, module: ModuleType, compiler: Compiler
    ) -> None:
        name = model.robot.name
        self.kernel = kernel
        self.robot = model.robot
        self._origin = (model, compiler)
        self._ffi = module.ffi
        self._one: Any = getattr(module.lib, f"{name}_{kernel.name}")
        self._batch: Any = getattr(module.lib, f"{name}_{kernel.name}_batch", None)

    def _bound(
        self, inputs: Sequence[FloatArray], outputs: Sequence[FloatArray], count: int | None
    ) -> Callable[[], int | None]:
        written = {o.name: array for o, array in zip(self.kernel.outputs, outputs, strict=True)}
        given: list[Any] = []
        for a, array in zip(self.kernel.inputs, inputs, strict=True):
            if a.plain:
                given.append((int if a.link else float)(array[0]))
                continue
            if a.written:  # an argument that C changes in place is written into the output
                written[a.name][...] = array
            given.append(self._ffi.from_buffer("double *", written.pop(a.name, array)))
        given += [self._ffi.from_buffer("double *", array) for array in written.values()]
        if count is None:
            return partial(self._one, *given)
        return partial(self._batch, count, *given)

    @cached_property
    def _panels(self) -> Panels | None:
        from symgen.runtime.panels import Panels

        if not panelled(self.kernel):
            return None
        try:
            return Panels(*self._origin, self.kernel)
        except BuildError:  # a compiler without vectors: build a plain loop
            return None

    def panels(self) -> Panels | None:
        return self._panels


class _CasadiKernel(KernelFunction):
    backend = "casadi"

    def __init__(self, kernel: Kernel, robot: Robot, function: Any) -> None:
        self.kernel = kernel
        self.robot = robot
        self._map = cache(function.map)  # at most _BLOCK of them, which are small

    def _bound(
        self, inputs: Sequence[FloatArray], outputs: Sequence[FloatArray], count: int | None
    ) -> Callable[[], int | None]:
        N = 1 if count is None else count
        rows = []
        for a, array in zip(self.kernel.inputs, inputs, strict=True):
            rows.append(array.reshape(1 if a.shared else N, array.shape[-1]))
        shapes = [(N, *o.shape) for o in self.kernel.outputs]
        filled = [out.reshape(shape) for out, shape in zip(outputs, shapes, strict=True)]

        def call() -> int:
            for at in range(0, N, _BLOCK):
                size = min(_BLOCK, N - at)
                part = []
                for a, row in zip(self.kernel.inputs, rows, strict=True):
                    block = np.repeat(row, size, axis=0) if a.shared else row[at : at + size]
                    part.append(block.T)
                for out, matrices in zip(filled, self._map(size).call(part), strict=True):
                    out[at : at + size] = _samples(np.array(matrices), (size, *out.shape[1:]))
            if not self.kernel.guards or all(np.isfinite(o).all() for o in outputs):
                return 0
            known = all(np.isfinite(a).all() for a in inputs)
            return NOT_POSITIVE_DEFINITE if known else NOT_FINITE

        return call


def _samples(block: FloatArray, shape: tuple[int, ...]) -> FloatArray:
    """Return the matrices of samples, which are side by side in a block, as (N, ...)."""
    rows, columns = block.shape
    matrices = block.reshape(rows, shape[0], columns // shape[0])
    return matrices.swapaxes(0, 1).reshape(shape)
