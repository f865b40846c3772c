"""The generated package: C sources, build files, documents and the manifest, from a model.

Same model, same bytes: no dates, no paths, no order of sets, nothing of the SymPy version.
"""

from __future__ import annotations

import hashlib
import json
import random
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sympy as sp

from symgen.codegen.c_printer import DTYPES, CFunction, literal, operation_counts, print_kernel
from symgen.codegen.model import Kernel, Model
from symgen.errors import PackageError
from symgen.files import templates, write_folder
from symgen.robot.expressions import text
from symgen.robot.toml_io import robot_toml
from symgen.symbolic.base_parameters import bound
from symgen.symbolic.tape import Numbers

SCHEMA = "symgen.manifest/1"
TARGETS = ("c", "casadi", "all")
DIGITS = 50
TOLERANCE = {"double": 1e-13, "float": 2e-5}
_POINTS = 4
_SEED = 1988
_RUNTIME = ("least_squares", "identifier")

_DOCS = {
    "energy_regressor": "columns DE + DU of kinetic plus potential energy: E + U = out . X",
    "friction_power": "columns of the power that friction takes: P = out . X[p_inertial..p)",
}


@dataclass(frozen=True)
class SourceTree:
    """The files of a package: relative path and content."""

    name: str
    files: Mapping[str, bytes]


def generate(
    model: Model,
    *,
    target: str = "all",
    dtype: str = "double",
    kernels: tuple[str, ...] | None = None,
) -> SourceTree:
    """Write a model as a package of C, CasADi or both.

    Args:
        model: from `derive`.
        target: "c", "casadi" or "all".
        dtype: "double" or "float", of the C sources.
        kernels: names of the kernels to write; all by default. The identifier in C comes with
            energy_regressor (and friction_power, where the robot has friction).

    Raises:
        PackageError: an option is not one of these.
    """
    if target not in TARGETS:
        raise PackageError(f"target {target!r}; accepted: {', '.join(TARGETS)}")
    if dtype not in DTYPES:
        raise PackageError(f"dtype {dtype!r}; accepted: {', '.join(DTYPES)}")
    known = [k.name for k in model.kernels]
    for name in kernels or ():
        if name not in known:
            raise PackageError(f"kernel {name!r}; accepted: {', '.join(known)}")
    chosen = tuple(k for k in model.kernels if kernels is None or k.name in kernels)
    return _Writer(model, target, dtype, chosen).tree()


def write_package(tree: SourceTree, folder: str | Path) -> None:
    """Write a package to a folder, whole or not at all; an older package there is replaced."""
    write_folder(Path(folder), tree.files, "manifest.json")


@dataclass(frozen=True)
class _Writer:
    model: Model
    target: str
    dtype: str
    kernels: tuple[Kernel, ...]

    @property
    def name(self) -> str:
        return self.model.robot.name

    def tree(self) -> SourceTree:
        verification = self.verification()
        files: dict[str, bytes] = {"robot.toml": robot_toml(self.model.robot).encode()}
        if self.target in ("c", "all"):
            files |= {path: content.encode() for path, content in self.c_files(verification)}
        if self.target in ("casadi", "all"):
            from symgen.codegen.casadi_model import casadi_function, serialized

            for kernel in self.kernels:
                function = casadi_function(self.model, kernel)
                files[f"{self.name}_{kernel.name}.casadi"] = serialized(function)
        files["README.md"] = self.render("README.md", **self.readme()).encode()
        digests = {
            path: hashlib.sha256(content).hexdigest()
            for path, content in sorted(files.items())
            if not path.endswith(".casadi")
        }
        manifest = self.manifest(verification, digests)
        files["manifest.json"] = (json.dumps(manifest, indent=1) + "\n").encode()
        return SourceTree(self.name, dict(sorted(files.items())))

    def render(self, template: str, **data: Any) -> str:
        import jinja2

        environment = jinja2.Environment(
            loader=jinja2.FileSystemLoader(templates() / "c"),
            undefined=jinja2.StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
            keep_trailing_newline=True,
            autoescape=False,
        )
        return environment.get_template(template).render(name=self.name, **data)

    # Data of the templates.

    def geometry(self) -> list[dict[str, str]]:
        return [
            {"name": name, "value": literal(value, self.dtype)}
            for name, value in self.model.robot.geometry
        ]

    def base(self) -> list[dict[str, str]]:
        return [
            {"name": p.name, "expression": p.expression, "unit": p.unit}
            for p in self.model.base.parameters
        ]

    def has_identifier(self) -> bool:
        """The identifier needs every column that the model has."""
        return {k.name for k in self.kernels} >= {k.name for k in self.model.kernels}

    def c_files(self, verification: Mapping[str, Any]) -> list[tuple[str, str]]:
        described = [(k, self.describe(k)) for k in self.kernels]
        out = [
            (
                f"{self.name}.h",
                self.render(
                    "model.h",
                    n=self.model.robot.n,
                    p=len(self.model.base.parameters),
                    inertial=self.model.inertial,
                    joints=", ".join(f"q{j.number}" for j in self.model.robot.movable),
                    dtype=self.dtype,
                    geometry=self.geometry(),
                    base=self.base(),
                    kernels=[d for _, d in described],
                ),
            )
        ]
        out += [(f"{self.name}_{k.name}.c", self.render("kernel.c", k=d)) for k, d in described]
        if self.has_identifier():
            for stem in _RUNTIME:
                for suffix in (".h", ".c"):
                    source = (templates() / "c" / "runtime" / f"{stem}{suffix}").read_text("utf-8")
                    out.append((f"{self.name}_{stem}{suffix}", source.replace("NAME", self.name)))
        sources = [path for path, _ in out if path.endswith(".c")]
        headers = [path for path, _ in out if path.endswith(".h")]
        out.append((f"{self.name}_check.c", self.check_c(verification)))
        cmake = self.render("CMakeLists.txt", sources=sources, headers=" ".join(headers))
        out.append(("CMakeLists.txt", cmake))
        return out

    def describe(self, kernel: Kernel) -> dict[str, Any]:
        """Return what the templates print of one kernel."""
        function = self.printed(kernel)
        arrays = [(name, len(symbols)) for name, symbols in kernel.tape.inputs]
        size = _size(kernel)
        counts = operation_counts([kernel.tape])
        return {
            "name": kernel.name,
            "doc": _DOCS[kernel.name],
            "shapes": [f"{name}: ({length},)" for name, length in arrays]
            + [f"out: {_shape(kernel.shape)}: {', '.join(kernel.columns)}"],
            "parameters": ", ".join(
                [f"const {self.dtype} *{name}" for name, _ in arrays] + [f"{self.dtype} *out"]
            ),
            "strides": ", ".join(f"{a} + k * {s}u" for a, s in [*arrays, ("out", size)]),
            "operations": ", ".join(f"{v} {key}" for key, v in counts.items() if v)
            or "0 operations",
            "body": function.body,
            "needs_math": function.needs_math,
            "size": size,
        }

    def printed(self, kernel: Kernel) -> CFunction:
        robot = self.model.robot
        macros = {sp.Symbol(g, real=True): f"{self.name}_geometry_{g}" for g, _ in robot.geometry}
        return print_kernel(kernel.tape, macros, robot.values(), self.dtype)

    def readme(self) -> dict[str, Any]:
        robot, base = self.model.robot, self.model.base
        keys = ("gamma", "b", "alpha", "d", "theta", "r")
        return {
            "p": len(base.parameters),
            "inertial": self.model.inertial,
            "sources": " ".join(f"{self.name}_{k.name}.c" for k in self.kernels)
            + (
                f" {self.name}_least_squares.c {self.name}_identifier.c"
                if self.has_identifier()
                else ""
            ),
            "table": [
                " | ".join(
                    [
                        str(j.number),
                        str(j.sigma),
                        str(j.antecedent),
                        *(text(getattr(j, key)) for key in keys),
                    ]
                )
                for j in robot.joints
            ],
            "gravity": "[" + ", ".join(text(g) for g in robot.gravity) + "]",
            "geometry": [{"name": n, "value": text(v)} for n, v in robot.geometry],
            "base": self.base(),
            "no_effect": ", ".join(base.no_effect) or "none",
            "proof": {
                "rank": base.proof.rank,
                "primes": " and ".join(map(str, base.proof.primes)),
                "structural": base.proof.structural,
                "lifted": base.proof.lifted,
            },
            "kernels": [{"name": k.name, **operation_counts([k.tape])} for k in self.kernels],
        }

    # Verification: seeded points, and what 50 digits give there.

    def verification(self) -> dict[str, Any]:
        draw = random.Random(_SEED)
        kernels: dict[str, Any] = {}
        for kernel in self.kernels:
            points = [
                {
                    name: [round(draw.uniform(-2.0, 2.0), 6) for _ in symbols]
                    for name, symbols in kernel.tape.inputs
                }
                for _ in range(_POINTS)
            ]
            expected = [evaluate(kernel, self.model, point, DIGITS) for point in points]
            kernels[kernel.name] = {
                "points": points,
                "expected": [[_digits(v) for v in row] for row in expected],
            }
        return kernels

    def check_c(self, verification: Mapping[str, Any]) -> str:
        suffix = "f" if self.dtype == "float" else ""
        kernels = []
        for kernel in self.kernels:
            entry = verification[kernel.name]
            arguments = [
                {
                    "name": name,
                    "size": len(symbols),
                    "rows": [
                        ", ".join(f"{v!r}{suffix}" for v in point[name])
                        for point in entry["points"]
                    ],
                }
                for name, symbols in kernel.tape.inputs
            ]
            kernels.append(
                {
                    "name": kernel.name,
                    "size": _size(kernel),
                    "arguments": arguments,
                    "call": ", ".join(f"{a['name']}[i]" for a in arguments),
                    "expected": [
                        ", ".join(repr(float(v)) for v in row) for row in entry["expected"]
                    ],
                }
            )
        return self.render(
            "check.c",
            kernels=kernels,
            points=_POINTS,
            digits=DIGITS,
            tolerance=repr(TOLERANCE[self.dtype]),
        )

    def manifest(self, verification: Mapping[str, Any], digests: dict[str, str]) -> dict[str, Any]:
        robot, base = self.model.robot, self.model.base
        return {
            "schema": SCHEMA,
            "robot": self.name,
            "options": {
                "target": self.target,
                "dtype": self.dtype,
                "kernels": [k.name for k in self.kernels],
            },
            "joints": robot.n,
            "joint_numbers": [j.number for j in robot.movable],
            "standard_parameters": len(base.standard),
            "base_parameters": self.base(),
            "inertial_parameters": self.model.inertial,
            "no_effect": list(base.no_effect),
            "effects": [],
            "kernels": [
                {
                    "name": k.name,
                    "inputs": [
                        {"name": name, "shape": [len(symbols)]} for name, symbols in k.tape.inputs
                    ],
                    "outputs": [
                        {"name": "out", "shape": list(k.shape), "columns": list(k.columns)}
                    ],
                    "operations": operation_counts([k.tape]),
                }
                for k in self.kernels
            ],
            "proof": {
                "rank": base.proof.rank,
                "primes": list(base.proof.primes),
                "seeds": list(base.proof.seeds),
                "points": base.proof.points,
                "structural_relations": base.proof.structural,
                "lifted_relations": base.proof.lifted,
                "bound": bound(robot),
                "method": base.proof.method,
            },
            "verification": {
                "digits": DIGITS,
                "seed": _SEED,
                "tolerance": TOLERANCE[self.dtype],
                "points": {name: entry["points"] for name, entry in verification.items()},
                "expected": {name: entry["expected"] for name, entry in verification.items()},
            },
            "digests": digests,
        }


def evaluate(
    kernel: Kernel, model: Model, point: Mapping[str, list[float]], digits: int
) -> list[Any]:
    """Evaluate a kernel with many digits (mpmath); the point's numbers are taken as written.

    Returns:
        One mpmath number for every scalar of the output.
    """
    import mpmath

    context = mpmath.mp.clone()
    context.dps = digits + 10
    functions = {"sin": context.sin, "cos": context.cos, "abs": abs, "tanh": context.tanh}

    arithmetic = Numbers(
        model.robot.values(), functions, lambda value: context.mpf(str(value)), digits + 10
    )
    inputs = {name: [context.mpf(repr(v)) for v in values] for name, values in point.items()}
    return kernel.tape.run(arithmetic, inputs)


def _digits(value: Any) -> str:
    import mpmath

    return str(mpmath.nstr(value, 30))


def _size(kernel: Kernel) -> int:
    size = 1
    for extent in kernel.shape:
        size *= extent
    return size


def _shape(shape: tuple[int, ...]) -> str:
    return f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"
