"""C99: sources and headers of the functions, the check program, and the build files.

Every .c file of the folder itself belongs to the library; programs with a main are in subfolders.
"""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from symgen.codegen import example
from symgen.codegen.backends import Package
from symgen.codegen.c_printer import Printer, literal
from symgen.codegen.kernel import Kernel
from symgen.codegen.model import Model
from symgen.codegen.panels import panel_data, panelled
from symgen.codegen.values import robot_digest, values_header_text
from symgen.codegen.verification import DIGITS, TOLERANCE, checked_kernel
from symgen.files import rendered
from symgen.robot.expressions import six_digits
from symgen.robot.identifiers import c_comment, c_identifiers
from symgen.robot.tables import Frame
from symgen.robot.types import Robot
from symgen.symbolic.tape import real_symbol

_LINE = 100  # line length of a header
_SINCOS, _LANES = "math.h", "lanes.h"  # no public headers
#: Limits from [limits] that become constants in C.
_LIMITS = ("position", "velocity", "acceleration", "jerk", "torque")

#: Properties of a floating type: bytes and bits, and the endings of vector instructions and of
#: libm.
_REALS: dict[str, dict[str, Any]] = {
    "double": {"bytes": 8, "bits": 64, "ps": "pd", "f": "", "sqrt": "sqrt"},
    "float": {"bytes": 4, "bits": 32, "ps": "ps", "f": "f", "sqrt": "sqrtf"},
}

_wrapped = partial(textwrap.wrap, break_long_words=False, break_on_hyphens=False)


def files(package: Package) -> dict[str, str]:
    """Return the library, its headers of constants, the check program, and the build files."""
    name = package.name
    out = library_files(package)
    out[f"{name}_warm.c"] = package.render("c/warm.c")
    sources = [path for path in out if path.endswith(".c")]
    out |= _constants(package)
    private = (f"{name}_{_SINCOS}", f"{name}_{_LANES}")
    headers = [path for path in out if path.endswith(".h") and path not in private]
    controller = example.controller(package)
    verified = package.verified
    checked = [checked_kernel(k, verified) for k in package.kernels]
    tolerance = repr(TOLERANCE[package.dtype])
    out[f"check/{name}_check.c"] = package.render(
        "c/check.c", kernels=checked, digits=DIGITS, tolerance=tolerance
    )
    out["CMakeLists.txt"] = package.render(
        "c/CMakeLists.txt",
        sources=sources,
        headers=headers,
        example=bool(controller),
        component="firmware" in package.targets,
    )
    out[f"{name}.pc.in"] = package.render("c/package.pc.in")
    return out | controller


def functions(
    model: Model,
    kernels: Sequence[str] | None = None,
    *,
    panels: bool = False,
    runtime: bool = False,
) -> dict[str, bytes]:
    """Return the C sources and headers of a model in double, for Python.

    Args:
        model: the derived model.
        kernels: names of the kernels; all by default.
        panels: whether batches work on panels; otherwise they are loops of single calls, which
            compile faster.
        runtime: whether to add the identifiers.
    """
    chosen = tuple(k for k in model.kernels if kernels is None or k.name in kernels)
    # the same cache entry for robots with other limits
    plain = replace(model, robot=model.robot.mechanism())
    package = Package(model.robot.name, plain, "double", chosen)
    written = library_files(package, panels=panels, runtime=runtime)
    return {path: content.encode() for path, content in written.items()}


def library_files(package: Package, *, panels: bool = True, runtime: bool = True) -> dict[str, str]:
    """Return the sources and headers of the functions, and optionally of the runtime."""
    name, robot = package.name, package.model.robot
    kernels = [described(package, k, panels and panelled(k)) for k in package.kernels]
    out = {f"{name}.h": _header(package, kernels)}
    for k in kernels:
        out[f"{name}_{k['name']}.c"] = package.render("c/kernel.c", k=k)
    parts = package.runtime if runtime else ()
    plain = [f"{stem}{suffix}" for stem in parts for suffix in (".h", ".c")]
    if any(k["needs_sincos"] for k in kernels):
        plain.append(_SINCOS)
    on_panels = [k for k in kernels if k["panel"]]
    if on_panels:
        plain.append(_LANES)
        out[f"{name}_panels.h"] = package.render("c/panels.h", kernels=on_panels)
    for k in on_panels:
        out[f"{name}_{k['name']}_panels.c"] = package.render("c/panels.c", k=k)
    for path in plain:
        source = runtime_source(path, robot.gravity_input, package.dtype)
        out[f"{name}_{path}"] = source.replace("NAME", name)
    return out


def runtime_source(path: str, gravity_input: bool, dtype: str = "double") -> str:
    """Return a file of the C runtime with the prefix in place of NAME.

    Args:
        path: path in templates/c/runtime.
        gravity_input: whether its functions take g as the last input.
        dtype: double or float.
    """
    return rendered(
        f"c/runtime/{path}",
        gravity_input=gravity_input,
        dtype=dtype,
        G=", const NAME_real *g" if gravity_input else "",
        g=", g" if gravity_input else "",
        **_REALS[dtype],
    )


def _header(package: Package, kernels: Sequence[Any]) -> str:
    """Return NAME.h."""
    robot = package.model.robot
    return package.render(
        "c/model.h",
        joints=robot.movable,
        comment=c_comment,
        places=_named_places(robot),
        geometry=[(name, literal(value, package.dtype)) for name, value in robot.geometry],
        base=package.model.base.parameters,
        six_digits=six_digits,
        kernels=kernels,
        wrapped=_wrapped,
        digest=robot_digest(robot),
    )


def _named_places(robot: Robot) -> list[tuple[str, int]]:
    """Return an ending of a C identifier for each joint with a name, and its position in q."""
    named = [(k, j.name) for k, j in enumerate(robot.movable) if j.name]
    endings = c_identifiers((name for _, name in named), "joint")
    return [(ending, k) for ending, (k, _) in zip(endings, named, strict=True)]


def _constants(package: Package) -> dict[str, str]:
    """Return the headers of constants from the robot file and the values."""
    name, model = package.name, package.model
    robot, base = model.robot, model.base
    out = {}
    if robot.frames:
        out[f"{name}_links.h"] = package.render("c/links.h", frames=_frames(package))
    limits = {key: getattr(robot.limits, key, None) for key in _LIMITS}
    if any(value is not None for value in limits.values()):
        out[f"{name}_limits.h"] = package.render("c/limits.h", limits=limits)
    if package.values is not None:
        out[f"{name}_values.h"] = values_header_text(
            name,
            robot.name,
            package.values,
            [(b.name, b.expression, b.unit) for b in base.parameters],
            digest=robot_digest(robot),
            standard=[p.name for p in base.standard],
        )
    return out


def _frames(package: Package) -> list[tuple[str, str, Frame]]:
    """Return the frames of links, each with the ending of its C names and its name in a comment."""
    frames = package.model.robot.frames
    endings = c_identifiers((frame.name for frame in frames), "frame")
    return [(e, c_comment(frame.name), frame) for e, frame in zip(endings, frames, strict=True)]


def described(package: Package, kernel: Kernel, on_panels: bool) -> dict[str, Any]:
    """Return the data of a kernel for the templates."""
    name, dtype, robot = package.name, package.dtype, package.model.robot
    macros = {real_symbol(g): f"{name}_geometry_{g}" for g, _ in robot.geometry}
    function = Printer(kernel, macros, robot.values(), dtype, name).function()
    batch_parameters = kernel.listed(dtype, batch=True)
    return {
        "kernel": kernel,
        "name": kernel.name,
        "doc": _wrapped(kernel.doc, _LINE - 4),
        "returns": "int" if kernel.fallible else "void",
        "fallible": kernel.fallible,
        "link": kernel.link,
        "guards": len(kernel.guards),
        "outputs": kernel.outputs,
        "loop": kernel.batch and not on_panels,
        "panel": on_panels and panel_data(kernel, macros, robot.values(), dtype, name),
        "parameters": kernel.listed(dtype),
        "batch_parameters": batch_parameters,
        "batch_lines": _wrapped(batch_parameters, _LINE - 4),
        "operations": vars(kernel.tape.operations),
        "body": function.body,
        "arguments": kernel.arguments,
        "needs_math": function.needs_math,
        "needs_sincos": function.needs_sincos,
    }
