"""The FMU of a package: valid, built by CMake, and the same motion as symgen simulate."""

from __future__ import annotations

import importlib.util
import random
import shutil
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from packages import RICH, STRICT, run

import symgen
from symgen.codegen.verification import physical_parameters

if importlib.util.find_spec("fmpy") is None:
    pytest.skip("fmpy is not installed", allow_module_level=True)
if shutil.which("cc") is None or shutil.which("cmake") is None:
    pytest.skip("cc or cmake is not on this machine", allow_module_level=True)

# A tree with a prismatic, a fixed and two revolute joints.
SMOOTH = """
[robot]
name = "smooth"
gravity = [1.5, 0.0, -9.81]
[geometry]
L1 = 0.4
[[joint]]
friction = ["coulomb", "viscous", "offset"]
coulomb_width = 0.05
[[joint]]
alpha = "pi/2"
d = "L1"
coulomb_width = 0.05
[[joint]]
sigma = 1
alpha = "-pi/2"
coulomb_width = 0.02
[[joint]]
sigma = 2
antecedent = 1
gamma = 0.7
d = "sqrt(2)*L1"
[[joint]]
theta = "pi/3"
coulomb_width = 0.1
"""
DRY = """
[robot]
name = "dry"
gravity = [0.0, -9.81, 0.0]
[[joint]]
[[joint]]
d = 0.5
"""
ROBOTS = {"rich": RICH, "smooth": SMOOTH, "dry": DRY}


@cache
def derived(name: str) -> symgen.Model:
    """The model of one of our robots, or of the library's."""
    text = ROBOTS.get(name)
    robot = symgen.read_robot(name) if text is None else symgen.parse_robot(text)
    return symgen.derive(robot, "all")


@pytest.fixture(scope="module")
def units(tmp_path_factory: pytest.TempPathFactory) -> Mapping[tuple[str, str], Path]:
    """Every FMU that the tests load, built once."""
    root = tmp_path_factory.mktemp("fmu")
    built = {}
    for name, dtype in [("smooth", "double"), ("dry", "double"), ("rich", "float")]:
        package = root / dtype / name
        tree = symgen.generate(derived(name), target="fmu", dtype=dtype, prefix=name)
        symgen.write_package(tree, package)
        flags = f"-DCMAKE_C_FLAGS={' '.join(STRICT[1:])}"
        build = package / "build"
        run(["cmake", "-S", package, "-B", build, f"-D{name}_FMU=ON", flags], root)
        run(["cmake", "--build", build, "--target", f"{name}_fmu"], root)
        built[name, dtype] = build / f"{name}.fmu"
    return built


def truth(model: symgen.Model) -> dict[str, float]:
    """Parameters of a robot that could exist, by name; not those that the FMU starts with."""
    values = physical_parameters(model, random.Random(7))
    return dict(zip(model.base.names, values, strict=True))


def played(
    model: symgen.Model, scale: float, seconds: float = 1.0, rate: float = 2.0
) -> symgen.Log:
    """Torques at 1 kHz: a sine of `rate` rad/s on every joint."""
    t = np.arange(round(1000 * seconds) + 1) * 1e-3
    j = np.arange(model.robot.n)
    tau = scale * np.sin(rate * t[:, None] + 1.3 * j + 0.4)
    return symgen.make_log("torques", t, np.zeros_like(tau), tau)


def motion(
    unit: Path, kind: str, log: symgen.Log, start: Mapping[str, float], step: float = 1e-3
) -> Any:
    """The FMU under the torques of a log."""
    import fmpy

    numbers = [
        v.name.removeprefix("tau")
        for v in fmpy.read_model_description(str(unit)).modelVariables
        if v.causality == "input"
    ]
    names = [f"tau{k}" for k in numbers]
    rows = [(t, *row) for t, row in zip(log.t, log.tau, strict=True)]
    done = fmpy.simulate_fmu(
        str(unit),
        fmi_type=kind,
        stop_time=float(log.t[-1]),
        output_interval=step,
        step_size=step,
        relative_tolerance=1e-10,
        start_values=dict(start),
        input=np.array(rows, dtype=[("time", float), *((n, float) for n in names)]),
        output=[f"{s}{k}" for s in ("q", "qd") for k in numbers],
    )
    columns = np.array([done[n] for n in done.dtype.names[1:]]).T
    return np.split(columns, 2, axis=1)


def test_the_validator_has_no_complaint(units) -> None:
    from fmpy.validation import validate_fmu

    for unit in units.values():
        assert validate_fmu(str(unit)) == []


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_sources_are_free_of_warnings(compiler: str, units) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not on this machine")
    for (name, _), unit in units.items():
        package = unit.parents[1]
        include = [f"-I{package}", f"-I{package / 'fmu'}"]
        source = package / "fmu" / f"{name}_fmu.c"
        run([compiler, *STRICT, "-O1", *include, "-c", source, "-o", "unit.o"], unit.parent)
        prefix = f"-DFMI2_FUNCTION_PREFIX={name}_"
        run([compiler, *STRICT, prefix, *include, "-c", source, "-o", "prefixed.o"], unit.parent)


# A solver of model exchange sees inputs at its own steps: constant ones leave no doubt.
@pytest.mark.parametrize(
    ("kind", "rate", "bound"), [("CoSimulation", 2.0, 1e-9), ("ModelExchange", 0.0, 1e-6)]
)
def test_motion_is_that_of_symgen_simulate(kind: str, rate: float, bound: float, units) -> None:
    model = derived("smooth")
    X = truth(model)
    log = played(model, 6.0, rate=rate)
    rest = (np.full(model.robot.n, 0.2), np.full(model.robot.n, -0.3))
    ours = symgen.simulate(model.robot, X, torque=log, hold=True, initial=rest, tolerance=1e-11)
    numbers = [j.number for j in model.robot.movable]
    start = X | {f"q{k}": 0.2 for k in numbers} | {f"qd{k}": -0.3 for k in numbers}
    q, qd = motion(units["smooth", "double"], kind, log, start)
    assert np.ptp(ours.q[0], axis=0).min() > 0.05
    assert np.abs(q - ours.q[0]).max() < bound
    assert np.abs(qd - ours.qd[0]).max() < 20 * bound


def test_dry_friction_is_that_of_symgen_simulate_up_to_its_width(units) -> None:
    model = derived("dry")
    X = truth(model)
    log = played(model, 25.0)
    ours = symgen.simulate(model.robot, X, torque=log, hold=True, initial=([0, 0], [0, 0]))
    gaps = []
    for width in (0.02, 0.002):
        start = X | {"coulomb_width": width, "integration_step": 2e-5}
        q, _ = motion(units["dry", "double"], "CoSimulation", log, start)
        gaps.append(float(np.abs(q - ours.q[0]).max()))
    assert np.ptp(ours.q[0], axis=0).min() > 0.3
    assert gaps[1] < 2e-3
    assert gaps[1] < gaps[0] / 3


def test_a_joint_held_by_dry_friction_creeps_within_the_width(units) -> None:
    model = derived("dry")
    X = truth(model) | {"FS1": 40.0, "FS2": 40.0}
    log = played(model, 10.0)
    start = X | {"coulomb_width": 0.01, "integration_step": 2e-5}
    q, qd = motion(units["dry", "double"], "CoSimulation", log, start)
    assert 1e-5 < np.abs(q).max() < 0.01
    assert np.abs(qd).max() < 0.01
    _, free = motion(units["dry", "double"], "CoSimulation", log, start | {"FS1": 0, "FS2": 0})
    assert np.abs(free).max() > 1.0


def test_single_precision_and_couplings(units) -> None:
    model = derived("rich")
    X = truth(model)
    log = played(model, 8.0, 0.5)
    n = model.robot.n
    rest = (np.zeros(n), np.zeros(n))
    ours = symgen.simulate(model.robot, X, torque=log, hold=True, initial=rest)
    start = X | {"coulomb_width": 1e-3, "integration_step": 1e-5}
    q, _ = motion(units["rich", "float"], "CoSimulation", log, start)
    assert np.ptp(ours.q[0], axis=0).max() > 0.1
    assert np.abs(q - ours.q[0]).max() < 3e-3


def test_friction_of_a_coupled_drive_is_smoothed_about_the_standstill_of_the_drive(units) -> None:
    """FS tanh(v/v0) is FS/2 at v = v0 atanh(1/2), where v is qd1 + ratio qd2."""
    import fmpy

    model = derived("rich")
    assert model.robot.couplings[0].ratio.xreplace(model.robot.values()) == pytest.approx(-0.4)
    numbers = [j.number for j in model.robot.movable]
    qd = dict.fromkeys(numbers, 1.5) | {1: 0.4 * 1.5 + 0.1 * np.arctanh(0.5)}
    start = truth(model) | {f"qd{k}": v for k, v in qd.items()}

    def accelerations(friction: float, width: float) -> list[float]:
        done = fmpy.simulate_fmu(
            str(units["rich", "float"]),
            stop_time=1e-3,
            start_values=start | {"FSM2": friction, "coulomb_width": width},
            output=[f"qdd{k}" for k in numbers],
        )
        return [done[f"qdd{k}"][0] for k in numbers]

    sharp = accelerations(15.0, 1e-4)
    np.testing.assert_allclose(accelerations(30.0, 0.1), sharp, rtol=1e-4)
    assert not np.allclose(accelerations(30.0, 1e-4), sharp, rtol=0.1)


def slave(unit: Path, folder: Path, guid: str | None = None) -> Any:
    """An instance for co-simulation that has been initialized, and its variables by name."""
    import fmpy
    from fmpy.fmi2 import FMU2Slave

    described = fmpy.read_model_description(str(unit))
    made = FMU2Slave(
        guid=guid or described.guid,
        unzipDirectory=fmpy.extract(str(unit), str(folder)),
        modelIdentifier=described.coSimulation.modelIdentifier,
        instanceName="one",
    )
    made.instantiate()
    made.setupExperiment(startTime=0.0)
    made.enterInitializationMode()
    made.exitInitializationMode()
    return made, {v.name: v.valueReference for v in described.modelVariables}


def test_a_state_can_be_kept_serialized_and_taken_back(units, tmp_path: Path) -> None:
    unit, place = slave(units["dry", "double"], tmp_path)
    states = [place[name] for name in ("q1", "q2", "qd1", "qd2")]
    unit.setReal([place["tau1"]], [40.0])
    unit.doStep(0.0, 0.1)
    kept = unit.getFMUState()
    content = unit.serializeFMUState(kept)
    before = unit.getReal(states)
    unit.doStep(0.1, 0.1)
    after = unit.getReal(states)
    assert max(abs(a - b) for a, b in zip(before, after, strict=True)) > 1e-3
    for state in (kept, unit.deSerializeFMUstate(content)):
        unit.setFMUState(state)
        assert unit.getReal(states) == before
        unit.doStep(0.1, 0.1)
        assert unit.getReal(states) == after
        unit.freeFMUState(state)
    unit.reset()
    assert unit.getReal(states) == [0.0] * 4
    unit.terminate()
    unit.freeInstance()


def test_what_is_wrong_is_refused(units, tmp_path: Path) -> None:
    from fmpy.fmi1 import FMICallException

    with pytest.raises(Exception, match="instantiate"):
        slave(units["dry", "double"], tmp_path / "other", guid="{of-another}")
    unit, place = slave(units["dry", "double"], tmp_path / "own")
    for name, value in (("qdd1", 1.0), ("coulomb_width", 0.0), ("integration_step", -1.0)):
        with pytest.raises(FMICallException):
            unit.setReal([place[name]], [value])
    with pytest.raises(FMICallException):
        unit.getReal([len(place)])
    unit.setReal([place["ZZ1R"]], [-1.0])  # no robot
    for call in (lambda: unit.getReal([place["qdd1"]]), lambda: unit.doStep(0.0, 0.1)):
        with pytest.raises(FMICallException):
            call()
    unit.freeInstance()


def test_the_unit_builds_from_the_sources_inside(units, tmp_path: Path) -> None:
    import fmpy

    folder = Path(fmpy.extract(str(units["dry", "double"]), str(tmp_path / "unit")))
    shutil.rmtree(folder / "binaries")
    described = fmpy.read_model_description(str(folder))
    files = described.buildConfigurations[0].sourceFileSets[0].sourceFiles
    library = folder / "binaries" / "linux64" / "dry.so"
    library.parent.mkdir(parents=True)
    run(["cc", "-shared", "-fPIC", *files, "-lm", "-o", library], folder / "sources")
    done = fmpy.simulate_fmu(str(folder), fmi_type="CoSimulation", stop_time=0.1, output=["qd2"])
    assert abs(done["qd2"][-1]) > 1e-3


def test_the_target_needs_forward_dynamics_and_all_leaves_it_out_without() -> None:
    kernels = ("energy_regressor", "mass_matrix")
    model = symgen.derive(symgen.read_robot("planar2r"), kernels)
    with pytest.raises(symgen.PackageError, match="target fmu: needs the kernels forward_dynamics"):
        symgen.generate(model, target="fmu")
    for tree in (symgen.generate(model), symgen.generate(derived("planar2r"), target="c")):
        assert not [path for path in tree.files if "fmu" in path]
        assert b"FMU" not in tree.files["CMakeLists.txt"]
