"""A model that computes: compiled C where there is a compiler, CasADi's virtual machine elsewhere.

NumPy in, NumPy out: one sample, a batch, or bound buffers for loops that count nanoseconds.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from symgen.codegen.casadi_model import casadi_function
from symgen.codegen.kernels import LINK, SCALARS, SHARED, Kernel
from symgen.codegen.model import Model, derive
from symgen.codegen.package import library
from symgen.codegen.panels import panelled
from symgen.codegen.prototypes import declarations as prototypes
from symgen.errors import BuildError, ParameterError, SymgenWarning
from symgen.robot.toml_io import read_robot
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
from symgen.runtime.flags import chosen_flags
from symgen.runtime.kernel_methods import KernelMethods

if TYPE_CHECKING:
    from symgen.runtime.panels import Panels

_BLOCK = 512  # samples that CasADi maps over in one call
#: A batch of as many samples or more is evaluated on panels, which are compiled when first needed.
MANY = 2**17


class KernelFunction(Protocol):
    """One kernel, callable on NumPy arrays."""

    kernel: Kernel

    def __call__(self, *inputs: ArrayLike) -> Any:
        """Evaluate one sample, inputs (n,), or a batch, inputs (N, n); X is shared.

        Returns:
            The output array, or a tuple of them where the kernel has several.

        Raises:
            ParameterError: a shape is wrong; or a kernel with a status, such as forward_dynamics,
                finds M not positive definite, or numbers that are not finite.
        """

    def bind(self, count: int | None = None) -> Bound:
        """Return the kernel on fixed buffers: of one sample, or of a batch of `count`."""

    def panels(self) -> Panels | None:
        """Return the kernel on panels of samples, compiled now; None where that cannot be had."""


class Evaluator(KernelMethods):
    """A loaded model: every kernel is a method, `evaluator.mass_matrix(q, X)`.

    By its name a kernel is had as a function that can be bound to fixed buffers, or put on panels:
    `evaluator["mass_matrix"].bind()`.

    Attributes:
        model: what was derived.
        backend: "c" or "casadi".
        library: the cffi module, None for CasADi.
    """

    def __init__(
        self, model: Model, functions: Sequence[KernelFunction], library: ModuleType | None
    ) -> None:
        self.model = model
        self.library = library
        self.backend = "casadi" if library is None else "c"
        self._functions = {f.kernel.name: f for f in functions}

    def has(self, name: str) -> bool:
        """Whether the model was derived with this kernel."""
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


def load(robot: Robot | Model | str | Path, *, backend: str = "auto") -> Evaluator:
    """Derive, compile and load a robot's model.

    Args:
        robot: a robot, its model, a path, or a library name.
        backend: "c" (needs a C compiler), "casadi", or "auto": C where possible; otherwise CasADi,
            which is said once in a warning.

    Raises:
        BuildError: backend "c" was asked for and cannot be had.
        RobotError: there is no such robot.
    """
    if isinstance(robot, (str, Path)):
        robot = read_robot(robot)
    model = derive(robot) if isinstance(robot, Robot) else robot
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
    return Evaluator(model, [_CasadiKernel(k, model) for k in model.kernels], None)


_said: set[str] = set()


def _say_once(message: str) -> None:
    if message not in _said:
        _said.add(message)
        warnings.warn(message, SymgenWarning, stacklevel=3)


def _compiled(model: Model, compiler: Compiler) -> Evaluator:
    sources = library(model)
    name = model.robot.name
    declarations = "\n".join(line for k in model.kernels for line in prototypes(name, k, "double"))
    apart = model.robot.gravity_input  # its identifier takes g: for C alone
    if f"{name}_identifier.h" in sources and not apart:
        declarations += _IDENTIFIER.replace("NAME", name)
    if f"{name}_identifier_momentum.h" in sources and not apart:
        declarations += _IDENTIFIER_MOMENTUM.replace("NAME", name)
    flags = chosen_flags(compiler).flags.flags
    module = build_module(sources, declarations, compiler, flags)
    functions = [_CKernel(k, model, module, compiler) for k in model.kernels]
    return Evaluator(model, functions, module)


_IDENTIFIER = """
size_t NAME_identifier_size(size_t window);
int NAME_identifier_init(void *state, size_t bytes, size_t window, int mode, double forgetting);
int NAME_identifier_step(void *state, const double *q, const double *qd, const double *tau,
                         double dt);
int NAME_identifier_status(const void *state);
void NAME_identifier_restart(void *state);
int NAME_identifier_run(void *state, size_t N, const double *t, const double *q, const double *qd,
                        const double *tau);
int NAME_identifier_read(const void *state, double *X, double *std);
typedef struct NAME_least_squares {
    double R[...]; double z[...]; double forgetting; double rss; double count; ...;
} NAME_least_squares;
const NAME_least_squares *NAME_identifier_state(const void *state);
int NAME_least_squares_init(NAME_least_squares *s, double forgetting);
int NAME_least_squares_update(NAME_least_squares *s, const double *row, double y);
void NAME_least_squares_merge(NAME_least_squares *s, const NAME_least_squares *other);
int NAME_least_squares_solve(const NAME_least_squares *s, double *X, double *std, double *rss);
"""
_IDENTIFIER_MOMENTUM = """
size_t NAME_identifier_momentum_size(size_t window);
int NAME_identifier_momentum_init(void *state, size_t bytes, size_t window, int mode,
                                  double forgetting);
"""


class _CKernel:
    def __init__(
        self, kernel: Kernel, model: Model, module: ModuleType, compiler: Compiler
    ) -> None:
        name = model.robot.name
        self.kernel = kernel
        self._origin = (model, compiler)
        self._ffi = module.ffi
        self._one: Any = getattr(module.lib, f"{name}_{kernel.name}")
        self._batch: Any = getattr(module.lib, f"{name}_{kernel.name}_batch", None)

    def _pointers(self, inputs: Sequence[FloatArray], outputs: Sequence[FloatArray]) -> list[Any]:
        """Return what C is given; what it changes in place is written into the output."""
        place = {o.name: i for i, o in enumerate(self.kernel.outputs)}
        given: list[Any] = []
        for (name, _), array in zip(self.kernel.tape.inputs, inputs, strict=True):
            if name == LINK:
                given.append(int(array[0]))
            elif name in SCALARS:
                given.append(float(array[0]))
            elif name in place:
                outputs[place[name]][...] = array
            if name not in (LINK, *SCALARS):
                changed = outputs[place[name]] if name in place else array
                given.append(self._ffi.from_buffer("double *", changed))
        names = {name for name, _ in self.kernel.tape.inputs}
        free = (o for o, k in zip(outputs, self.kernel.outputs, strict=True) if k.name not in names)
        return [*given, *(self._ffi.from_buffer("double *", o) for o in free)]

    def __call__(self, *inputs: ArrayLike) -> Any:
        arrays, count = checked(self.kernel, inputs)
        if count is not None and count >= MANY:
            panels = self.panels()
            if panels is not None:
                return panels(*arrays)
        lead = () if count is None else (count,)
        outputs = [np.empty((*lead, *o.shape)) for o in self.kernel.outputs]
        pointers = self._pointers(arrays, outputs)
        status = self._one(*pointers) if count is None else self._batch(count, *pointers)
        return result(self.kernel, outputs, status or 0)

    @cached_property
    def _panels(self) -> Panels | None:
        from symgen.runtime.panels import Panels

        if not panelled(self.kernel):
            return None
        try:
            return Panels(*self._origin, self.kernel)
        except BuildError:  # a compiler without vectors: its plain loop is built
            return None

    def panels(self) -> Panels | None:
        return self._panels

    def bind(self, count: int | None = None) -> Bound:
        inputs, outputs = buffers(self.kernel, count)
        pointers = self._pointers(inputs, outputs)
        if count is not None:
            batch = self._batch
            return Bound(inputs, outputs, lambda: batch(count, *pointers))
        function = self._one
        if len(pointers) == 3:  # the usual case, without the cost of unpacking
            a, b, c = pointers
            return Bound(inputs, outputs, lambda: function(a, b, c))
        return Bound(inputs, outputs, lambda: function(*pointers))


class _CasadiKernel:
    def __init__(self, kernel: Kernel, model: Model) -> None:
        self.kernel = kernel
        self._function = casadi_function(model, kernel, flat=True)
        self._maps: dict[int, Any] = {}

    def __call__(self, *inputs: ArrayLike) -> Any:
        arrays, count = checked(self.kernel, inputs)
        if count is None:
            outputs = self._one(arrays)
        else:
            outputs = [np.empty((count, *o.shape)) for o in self.kernel.outputs]
            names = [name for name, _ in self.kernel.tape.inputs]
            for at in range(0, count, _BLOCK):
                size = min(_BLOCK, count - at)
                if size not in self._maps:  # at most _BLOCK of them, small ones
                    self._maps[size] = self._function.map(size)
                part = [
                    np.repeat(a[:, None], size, axis=1)
                    if name in (*SHARED, LINK)
                    else a[at : at + size].T
                    for name, a in zip(names, arrays, strict=True)
                ]
                blocks = self._maps[size](*part)
                for out, block in zip(outputs, _as_tuple(blocks), strict=True):
                    out[at : at + size] = np.array(block).T.reshape(size, *out.shape[1:])
        bad = self.kernel.guards > 0 and not all(np.isfinite(o).all() for o in outputs)
        given = all(np.isfinite(a).all() for a in arrays)
        status = NOT_POSITIVE_DEFINITE if given else NOT_FINITE
        return result(self.kernel, outputs, status if bad else 0)

    def _one(self, arrays: Sequence[FloatArray]) -> list[FloatArray]:
        results = _as_tuple(self._function(*arrays))
        pairs = zip(results, self.kernel.outputs, strict=True)
        return [np.array(r).reshape(o.shape) for r, o in pairs]

    def bind(self, count: int | None = None) -> Bound:
        inputs, outputs = buffers(self.kernel, count)

        def call() -> None:
            values = self._one(inputs) if count is None else _as_tuple(self(*inputs))
            for out, value in zip(outputs, values, strict=True):
                out[...] = value

        return Bound(inputs, outputs, call)

    def panels(self) -> None:
        """CasADi's virtual machine has none."""


def _as_tuple(result: Any) -> tuple[Any, ...]:
    return result if isinstance(result, tuple) else (result,)
