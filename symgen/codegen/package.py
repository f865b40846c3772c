"""The generated package: C sources, build files, documents and the manifest, from a model.

Same model, same bytes: no dates, no paths, no order of sets, nothing of the SymPy version.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sympy as sp

from symgen.codegen import example
from symgen.codegen.backends import Package, cpp, optimal_control
from symgen.codegen.c_printer import DTYPES, CFunction, literal, operation_counts, print_kernel
from symgen.codegen.c_runtime import runtime_parts, runtime_source
from symgen.codegen.check_program import checks
from symgen.codegen.kernels import Kernel
from symgen.codegen.manifest import SCHEMA, base_table, described
from symgen.codegen.model import Model
from symgen.codegen.parts import in_parts
from symgen.codegen.recipes import FRICTION, RECIPES
from symgen.codegen.targets import BACKENDS, backends
from symgen.codegen.verification import DIGITS, POINTS, TOLERANCE, verification
from symgen.codegen.wording import columns_text, input_text, markdown, shape_text, wrapped
from symgen.codegen.worst_case import worst_case
from symgen.errors import PackageError
from symgen.files import rendered, write_folder
from symgen.robot.expressions import text
from symgen.robot.identifiers import is_robot_name
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import joint_variable

#: Of a package's interface, in C, CMake and pkg-config: the first number is that of its layout.
_VERSION = (int(SCHEMA.split("/")[1]), 1, 0)
_LINE = 100  # columns of a header
_SINCOS = "math.h"


@dataclass(frozen=True)
class SourceTree:
    """The files of a package: relative path and content."""

    name: str
    files: Mapping[str, bytes]

    @property
    def library(self) -> dict[str, bytes]:
        """The sources and headers of the functions: without the check and the example."""
        return {
            path: content
            for path, content in self.files.items()
            if path.endswith((".c", ".h")) and "/" not in path and path != f"{self.name}_check.c"
        }


def generate(
    model: Model,
    *,
    target: str = "all",
    dtype: str = "double",
    kernels: tuple[str, ...] | None = None,
    tex: bool = False,
    prefix: str | None = None,
) -> SourceTree:
    """Write a model as a package of C, CasADi and what is built on the C.

    Args:
        model: from `derive`.
        target: "c", "casadi", "fmu" or "mex" (with their C), or "all" that the kernels allow.
        dtype: "double" or "float", of the C sources.
        kernels: names of the kernels to write; all by default. The identifier in C comes with
            energy_regressor (and friction_power, where the robot has friction).
        tex: whether to write the model as a LaTeX document too, with the formulas of the kernels.
        prefix: of every file and name; by default the robot's name, with an f behind it in float,
            so that both packages of a robot link into one program.

    Raises:
        PackageError: an option is not one of these, or no kernel is left to write.
    """
    if dtype not in DTYPES:
        raise PackageError(f"dtype {dtype!r}; accepted: {', '.join(DTYPES)}")
    chosen = _chosen(model, kernels)
    added = backends(target, chosen, model.robot)
    name = default_prefix(model.robot.name, dtype) if prefix is None else prefix
    if not is_robot_name(name):
        raise PackageError(f"prefix {name!r}; accepted: a C identifier that hides no header of C")
    return _Writer(model, target, dtype, chosen, tex, name, added).tree()


def _chosen(model: Model, names: Sequence[str] | None) -> tuple[Kernel, ...]:
    known = [k.name for k in model.kernels]
    for name in known if names is None else names:
        if name in FRICTION and name not in known and model.base.linear == model.base.inertial:
            others = ", ".join(other for other in RECIPES if other not in FRICTION)
            raise PackageError(
                f"kernel {name!r}: {model.robot.name} has no friction and no effects; "
                f"accepted: all, or some of {others}"
            )
        if name not in known:
            raise PackageError(f"kernel {name!r}; accepted: {', '.join(known)}")
    chosen = tuple(k for k in model.kernels if names is None or k.name in names)
    if not chosen:
        accepted = ", ".join(known) or "a model with at least one kernel"
        raise PackageError(f"a package without kernels; accepted: {accepted}")
    return chosen


def library(model: Model, kernels: Sequence[str] | None = None) -> dict[str, bytes]:
    """Return the sources and headers of a model's functions in double: what an evaluator builds.

    They are those of `generate` for target "c", without what goes beside them.
    """
    chosen = tuple(k for k in model.kernels if kernels is None or k.name in kernels)
    writer = _Writer(model, "c", "double", chosen, False, model.robot.name, ())
    described = [writer.describe(k) for k in chosen]
    return {path: text.encode() for path, text in writer.library(described)}


def default_prefix(robot: str, dtype: str) -> str:
    """Return the prefix of a robot's package where none is asked for."""
    return f"{robot}f" if dtype == "float" else robot


def model_digest(robot_file: str) -> str:
    """Return what tells a model from another, as C writes it: 64 bits of a SHA-256.

    Args:
        robot_file: the SHA-256 of the canonical robot.toml, in hexadecimal digits.
    """
    return f"0x{robot_file[:16]}ULL"


def write_package(tree: SourceTree, folder: str | Path) -> None:
    """Write a package to a folder, whole or not at all; an older package there is replaced."""
    write_folder(Path(folder), tree.files, "manifest.json")


@dataclass(frozen=True)
class _Writer:
    model: Model
    target: str
    dtype: str
    kernels: tuple[Kernel, ...]
    tex: bool
    name: str
    backends: tuple[str, ...]

    def tree(self) -> SourceTree:
        verified = verification(self.model, self.kernels)
        files: dict[str, bytes] = {"robot.toml": robot_toml(self.model.robot).encode()}
        if self.target != "casadi":
            files |= {path: content.encode() for path, content in self.c_files(verified)}
        if self.target in ("casadi", "all"):
            from symgen.codegen.casadi_model import casadi_function, serialized

            for kernel in self.kernels:
                function = casadi_function(self.model, kernel)
                files[f"{self.name}_{kernel.name}.casadi"] = serialized(function)
            if optimal_control.possible(self.model, self.kernels):
                program = optimal_control.program(self.name, self.model)
                files[f"example/{self.name}_optimal_control.py"] = program.encode()
        if self.tex:
            from symgen.codegen.tex import tex_document

            document = tex_document(self.model.robot, self.model.base, self.kernels)
            files[f"{self.name}.tex"] = document.encode()
        files["README.md"] = self.render("README.md", **self.readme()).encode()
        digests = {
            path: hashlib.sha256(content).hexdigest()
            for path, content in sorted(files.items())
            if not path.endswith(".casadi")
        }
        options = {
            "target": self.target,
            "dtype": self.dtype,
            "kernels": [k.name for k in self.kernels],
            "prefix": self.name,
            **({"tex": True} if self.tex else {}),
        }
        manifest = described(self.model, self.kernels, options, verified, digests)
        files["manifest.json"] = (json.dumps(manifest, indent=1) + "\n").encode()
        return SourceTree(self.name, dict(sorted(files.items())))

    def render(self, template: str, **data: Any) -> str:
        robot = self.model.robot
        known = {"name": self.name, "robot": robot.name, "gravity_input": robot.gravity_input}
        return rendered(f"c/{template}", **known, **data)

    @property
    def version(self) -> str:
        return ".".join(map(str, _VERSION))

    # Data of the templates.

    def geometry(self) -> list[dict[str, str]]:
        return [
            {"name": name, "value": literal(value, self.dtype)}
            for name, value in self.model.robot.geometry
        ]

    def runtime(self) -> tuple[str, ...]:
        return runtime_parts(self.model, self.kernels)

    def examples(self) -> tuple[str, ...]:
        if self.target == "casadi":
            return ()
        return example.programs(self.model, self.kernels, identifier=bool(self.runtime()))

    def library(self, described: Sequence[dict[str, Any]]) -> list[tuple[str, str]]:
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
                    base=self.named_base(),
                    kernels=described,
                    version=self.version,
                    major=_VERSION[0],
                    minor=_VERSION[1],
                    digest=model_digest(
                        hashlib.sha256(robot_toml(self.model.robot).encode()).hexdigest()
                    ),
                ),
            )
        ]
        out += [(f"{self.name}_{d['name']}.c", self.render("kernel.c", k=d)) for d in described]
        for stem in self.runtime():
            out += [self.plain(f"{stem}{suffix}") for suffix in (".h", ".c")]
        if any(d["needs_sincos"] for d in described):
            out.append(self.plain(_SINCOS))  # private to the sources
        return out

    def c_files(self, verified: Mapping[str, Any]) -> list[tuple[str, str]]:
        out = self.library([self.describe(k) for k in self.kernels])
        private = f"{self.name}_{_SINCOS}"
        sources = [path for path, _ in out if path.endswith(".c")]
        out.append((f"{self.name}.hpp", cpp.header(self.name, self.model, self.kernels)))
        headers = [p for p, _ in out if p.endswith((".h", ".hpp")) and p != private]
        out.append((f"{self.name}_check.c", self.check_c(verified)))
        if self.examples():
            out.append((f"example/{self.name}_simulated.h", self.example("simulated.h")))
        out += [(f"example/{self.name}_{e}.c", self.example(f"{e}.c")) for e in self.examples()]
        cmake = self.render(
            "CMakeLists.txt",
            sources=sources,
            headers=" ".join(headers),
            version=self.version,
            examples=self.examples(),
            backends=self.backends,
        )
        out.append(("CMakeLists.txt", cmake))
        out.append((f"{self.name}.pc.in", self.render("package.pc.in")))
        package = Package(self.name, self.model, self.dtype, self.kernels, dict(out))
        for target in self.backends:
            out += BACKENDS[target].files(package).items()
        return out

    def plain(self, path: str) -> tuple[str, str]:
        """Return a file of plain C with this package's name."""
        source = runtime_source(path, self.model.robot.gravity_input)
        return f"{self.name}_{path}", source.replace("NAME", self.name)

    def describe(self, kernel: Kernel) -> dict[str, Any]:
        """Return what the templates print of one kernel."""
        function = self.printed(kernel)
        counts = operation_counts([kernel.tape])
        listed = kernel.arguments
        names = [a.name for a in listed]
        shapes = [
            f"{name}: {input_text(self.name, name, len(s))}" for name, s in kernel.tape.inputs
        ] + [f"{o.name}: {shape_text(o.shape)}{columns_text(o.columns)}" for o in kernel.outputs]
        return {
            "name": kernel.name,
            "doc": wrapped(kernel.doc),
            "shapes": [line for shape in shapes for line in wrapped(shape, "  ")],
            "returns": "int" if kernel.fallible else "void",
            "fallible": kernel.fallible,
            "guarded": bool(kernel.guards),
            "links": kernel.links,
            "batch": kernel.batch,
            "parameters": ", ".join(a.declared(self.dtype) for a in listed),
            "batch_parameters": ", ".join(a.declared(self.dtype, batch=True) for a in listed),
            "strides": ", ".join(
                a.name if a.shared else f"&{a.name}[k * {a.size}u]" for a in listed
            ),
            "declarations": [
                line
                for text in kernel.prototypes(self.name, self.dtype)
                for line in wrapped(text, "    ", _LINE)
            ],
            "operations": ", ".join(f"{v} {key}" for key, v in counts.items() if v)
            or "0 operations",
            "body": function.body,
            "parts": in_parts(function.body, names, self.dtype),
            "dtype": self.dtype,
            "names": ", ".join(names),
            "needs_math": function.needs_math,
            "needs_sincos": function.needs_sincos,
        }

    def printed(self, kernel: Kernel) -> CFunction:
        robot = self.model.robot
        macros = {sp.Symbol(g, real=True): f"{self.name}_geometry_{g}" for g, _ in robot.geometry}
        return print_kernel(kernel, macros, robot.values(), self.dtype, self.name)

    def named_base(self) -> list[dict[str, Any]]:
        """Return name and comment of each base parameter, in lines that are not too long."""
        return [
            {"name": b["name"], "lines": wrapped(f"{b['expression']} [{b['unit']}]")}
            for b in base_table(self.model)
        ]

    def readme(self) -> dict[str, Any]:
        robot, base = self.model.robot, self.model.base
        keys = ("gamma", "b", "alpha", "d", "theta", "r")
        return {
            "p": len(base.parameters),
            "inertial": self.model.inertial,
            "version": self.version,
            "dtype": self.dtype,
            "casadi": self.kernels[-1].name if self.target in ("casadi", "all") else "",
            "sources": " ".join(
                f"{self.name}_{stem}.c"
                for stem in (*(k.name for k in self.kernels), *self.runtime())
            ),
            "table": [
                " | ".join(
                    [
                        str(j.number),
                        str(j.sigma),
                        str(j.antecedent),
                        *(text(getattr(j, key)) for key in keys),
                        text(sum((c * joint_variable(k) for k, c in j.shares), j.offset)),
                        markdown(j.name) or "-",
                    ]
                )
                for j in robot.joints
            ],
            "effects": [
                {
                    "name": markdown(e.name),
                    "joint": j,
                    "torque": text(torque),
                    "constants": e.nonlinear,
                }
                for e in robot.effects
                for j, torque in e.torque
            ],
            "gravity": "[" + ", ".join(text(g) for g in robot.gravity) + "]",
            "identifier": bool(self.runtime()),
            "geometry": [{"name": n, "value": text(v)} for n, v in robot.geometry],
            "base": base_table(self.model),
            "no_effect": ", ".join(base.no_effect) or "none",
            "proof": {
                "rank": base.proof.rank,
                "primes": " and ".join(map(str, base.proof.primes)),
                "structural": base.proof.structural,
                "lifted": base.proof.lifted,
            },
            "kernels": [{"name": k.name, **operation_counts([k.tape])} for k in self.kernels],
            "worst_case": worst_case(robot, self.kernels),
            "examples": self.examples(),
            "backends": self.backends,
            "control": optimal_control.possible(self.model, self.kernels),
            "percent": example.PERCENT,
        }

    def check_c(self, verified: Mapping[str, Any]) -> str:
        return self.render(
            "check.c",
            kernels=checks(self.name, self.kernels, verified, self.dtype),
            points=POINTS,
            digits=DIGITS,
            tolerance=repr(TOLERANCE[self.dtype]),
        )

    def example(self, file: str) -> str:
        return self.render(
            f"example/{file}",
            g=", GRAVITY" if self.model.robot.gravity_input else "",
            percent=example.PERCENT,
            better=example.BETTER,
            share=example.SHARE,
            **example.facts(self.model, self.kernels),
            **example.parameters(self.model, "f" if self.dtype == "float" else ""),
        )
