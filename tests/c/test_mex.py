"""The MEX gateway of a package: built in Octave, every kernel against the evaluator."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from packages import RICH, STRICT, run, with_probe

import symgen

OCTAVE = ["octave", "--no-gui", "--norc", "--quiet"]
pytestmark = pytest.mark.skipif(
    any(shutil.which(tool) is None for tool in ("octave", "mkoctfile", "cc")),
    reason="octave, mkoctfile (octave-dev) or cc is not on this machine",
)
N = 3


@pytest.fixture(
    scope="module",
    params=[
        ("planar2r", "double"),
        pytest.param(("rich", "float"), marks=pytest.mark.slow),
    ],
)
def gateway(request, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, symgen.Model, str]:
    """A package whose gateway Octave has compiled in its folder."""
    name, dtype = request.param
    robot = symgen.parse_robot(RICH) if name == "rich" else symgen.read_robot(name)
    model = symgen.derive(robot, "all")
    package = tmp_path_factory.mktemp("mex") / name
    symgen.write_package(symgen.generate(model, target="mex", dtype=dtype, prefix=name), package)
    built = package / "built"
    built.mkdir()
    run([*OCTAVE, "--eval", f"addpath('../mex'); {name}_build();"], built)
    return built, model, dtype


def matlab(a: np.ndarray) -> str:
    """Write a vector or matrix as MATLAB reads it, to the last bit."""
    rows = [" ".join(repr(float(x)) for x in row) for row in a]
    return f"[{'; '.join(rows)}]"


def drawn(model: symgen.Model, samples: int) -> dict[str, np.ndarray]:
    """Inputs of every kernel."""
    rng = np.random.default_rng(4)
    inputs = {a: rng.uniform(-1, 1, (samples, model.robot.n)) for a in ("q", "qd", "qdd", "tau")}
    return inputs | {"X": 2.0 + np.arange(len(model.base.parameters))[None, ::-1] % 5}


def known(model: symgen.Model, inputs: dict[str, np.ndarray]) -> list[Any]:
    """The kernels with these inputs alone."""
    return [k for k in model.kernels if all(a in inputs for a, _ in k.tape.inputs)]


def calls(model: symgen.Model, inputs: dict[str, np.ndarray], turned: bool) -> str:
    """A script that calls every kernel and prints sizes and numbers of what comes out."""
    name = model.robot.name
    lines = ["function say(varargin)", "  for i = 1:numel(varargin)", "    a = varargin{i};"]
    lines += ["    printf('%d ', ndims(a), size(a)); printf('%.17g ', a(:)); printf('\\n');"]
    lines += ["  end", "end"]
    for key, value in inputs.items():
        lines.append(f"{key} = {matlab(value)}{chr(39) if turned else ''};")
    for kernel in known(model, inputs):
        outputs = [f"o{i}" for i in range(len(kernel.outputs))]
        given = ", ".join(a for a, _ in kernel.tape.inputs)
        lines.append(f"[{', '.join(outputs)}] = {name}_mex('{kernel.name}', {given});")
        lines.append(f"say({', '.join(outputs)});")
    return "1;\n" + "\n".join(lines) + "\n"


def printed(built: Path, script: str) -> list[np.ndarray]:
    """Run a script; the arrays that it prints, with their shapes."""
    (built / "script.m").write_text(script)
    out = []
    for line in run([*OCTAVE, "script.m"], built).splitlines():
        rank, *rest = line.split()
        shape = [int(x) for x in rest[: int(rank)]]
        out.append(np.array(rest[int(rank) :], dtype=float).reshape(shape, order="F"))
    return out


def expected(model: symgen.Model, inputs: dict[str, np.ndarray], single: bool) -> list[np.ndarray]:
    """What the evaluator gives, in the shapes that the gateway promises."""
    loaded: Any = symgen.load(model)
    out = []
    for kernel in known(model, inputs):
        given = [inputs[a][0] if single or a == "X" else inputs[a] for a, _ in kernel.tape.inputs]
        result = loaded[kernel.name](*given)
        for array, output in zip(
            result if isinstance(result, tuple) else (result,), kernel.outputs, strict=True
        ):
            samples = () if single else (N,)
            array = np.asarray(array).reshape(*samples, *output.shape)
            if len(output.shape) == 1:  # (N, k), or a column
                out.append(array.reshape(-1, 1) if single else array)
            elif len(output.shape) == 2:  # (r, c, N)
                out.append(array if single else np.moveaxis(array, 0, -1))
            else:  # (4, 4, links, N)
                last = np.moveaxis(array, 0 if single else 1, -1)
                out.append(last if single else np.moveaxis(last, 0, -1))
    return out


@pytest.mark.parametrize("form", ["rows", "columns", "samples"])
def test_every_kernel_gives_matrices_in_the_shapes_of_matlab(gateway, form: str) -> None:
    built, model, dtype = gateway
    single = form != "samples"
    inputs = drawn(model, 1 if single else N)
    found = printed(built, calls(model, inputs, form == "columns"))
    wanted = expected(model, inputs, single)
    assert len(found) == len(wanted) > 14
    precision = 2e-5 if dtype == "float" else 1e-13
    for ours, theirs in zip(found, wanted, strict=True):
        assert ours.shape == theirs.shape
        assert np.abs(ours - theirs).max() <= precision * max(1.0, np.abs(theirs).max())


def test_what_is_wrong_is_refused_by_name(gateway) -> None:
    built, model, _ = gateway
    name, n, p = model.robot.name, model.robot.n, len(model.base.parameters)
    wrong = {
        f"{name}_mex()": f"{name}:kernel",
        f"{name}_mex(3)": f"{name}:kernel",
        f"{name}_mex('mass')": f"{name}:kernel",
        f"{name}_mex('jacobian')": f"{name}:arguments",
        f"[a, b] = {name}_mex('jacobian', zeros(1, {n}))": f"{name}:arguments",
        f"{name}_mex('jacobian', zeros(1, {n + 1}))": f"{name}:size",
        f"{name}_mex('jacobian', single(zeros(1, {n})))": f"{name}:type",
        f"{name}_mex('jacobian', sparse(zeros(1, {n})))": f"{name}:type",
        f"{name}_mex('jacobian', 1i * ones(1, {n}))": f"{name}:type",
        f"{name}_mex('mass_matrix', zeros(1, {n}), ones({p + 1}, 1))": f"{name}:size",
        f"{name}_mex('mass_matrix', zeros(1, {n}), ones(2, {p}))": f"{name}:size",
        f"{name}_mex('torque_regressor', zeros(3, {n}), zeros(3, {n}), zeros(2, {n}))": f"{name}:size",  # noqa: E501
        f"{name}_mex('forward_dynamics', zeros(1, {n}), zeros(1, {n}), ones(1, {n}), -ones({p}, 1))": f"{name}:mass_matrix",  # noqa: E501
    }  # fmt: skip
    lines = [f"try, {call}; disp('accepted'); catch e, disp(e.identifier); end" for call in wrong]
    (built / "wrong.m").write_text("1;\n" + "\n".join(lines) + "\n")
    assert run([*OCTAVE, "wrong.m"], built).split() == list(wrong.values())


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_gateway_is_free_of_warnings(gateway, compiler: str, tmp_path: Path) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not on this machine")
    built, model, _ = gateway
    place = run(["octave-config", "-p", "OCTINCLUDEDIR"], tmp_path).strip()
    source = built.parent / "mex" / f"{model.robot.name}_mex.c"
    flags = [f"-I{built.parent}", "-isystem", place, "-O1", "-c"]
    run([compiler, *STRICT, *flags, source, "-o", "gateway.o"], tmp_path)


def test_links_plain_numbers_and_what_is_changed_in_place(tmp_path: Path) -> None:
    model = with_probe(symgen.derive(symgen.read_robot("planar2r"), ("jacobian",)))
    symgen.write_package(symgen.generate(model, target="mex"), tmp_path / "planar2r")
    run([*OCTAVE, "--eval", "addpath('planar2r/mex'); planar2r_build();"], tmp_path)
    script = "X = [1 2 3 4]; [out, Y] = planar2r_mex('probe', [3 5], 2, 10, X);"
    script += "printf('%g ', out', Y, X, size(out));"
    printed = run([*OCTAVE, "--eval", script], tmp_path)
    assert printed.split() == "30 50 2 0 1 1 10 20 30 40 1 2 3 4 2 3".split()


def test_a_link_that_the_robot_has_not_is_named(tmp_path: Path) -> None:
    kernels = ("link_jacobian", "add_body")
    model = symgen.derive(symgen.read_robot("planar2r"), kernels)
    symgen.write_package(symgen.generate(model, target="mex"), tmp_path / "planar2r")
    run([*OCTAVE, "--eval", "addpath('planar2r/mex'); planar2r_build();"], tmp_path)
    lines = ["1;"]
    for link in ("0", "3", "-1", "1.5", "NaN", "Inf", "2"):
        for call in (
            f"planar2r_mex('link_jacobian', [3 5], {link}, [1 2 3])",
            f"planar2r_mex('add_body', [1 2 3 4], {link}, 1, [1 2 3], 1:6)",
        ):
            lines.append(f"try, {call}; disp('none'); catch e, disp(e.message); end")
    (tmp_path / "script.m").write_text("\n".join(lines) + "\n")
    found = run([*OCTAVE, "script.m"], tmp_path).splitlines()
    assert [("link" in line and "1 to 2" in line) for line in found] == [True] * 12 + [False] * 2
    assert found[12:] == ["none"] * 2


def test_only_kernels_that_are_written_are_known() -> None:
    model = symgen.derive(symgen.read_robot("planar2r"), ("mass_matrix", "jacobian"))
    tree = symgen.generate(model, target="mex", kernels=("jacobian",))
    gateway = tree.files["mex/planar2r_mex.c"].decode()
    assert "planar2r_jacobian(" in gateway
    assert "mass_matrix(" not in gateway
    assert not [p for p in tree.files if p.endswith(".casadi")]
