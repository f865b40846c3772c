"""Export of identified values: a C header, and a copy of the robot's URDF or MJCF."""

from __future__ import annotations

import hashlib
import math
import re
from codecs import BOM_UTF8
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import fmean, pstdev
from tempfile import TemporaryDirectory

import numpy as np

from symgen import names
from symgen.codegen.model import Model, derive
from symgen.codegen.values import model_digest, values_header_text
from symgen.data.raw import Reading
from symgen.errors import ParameterError
from symgen.estimation.equation_model import JUDGING
from symgen.estimation.torque_error import percent
from symgen.estimation.values import FloatArray
from symgen.faults.repair import open_samples
from symgen.files import json_text, write_folder, write_text
from symgen.identification.actuators import joint_drives
from symgen.identification.estimate import ROBOT_DIGEST, Estimate, read_estimate
from symgen.identification.judgement import require_scale
from symgen.identification.parameters import (
    base_values,
    cad_parameters,
    estimate_values,
    known_torques,
    read_parameters,
    with_fixed_links,
)
from symgen.identification.physical import LinkParameters, link_parameters
from symgen.identification.prediction import torque_errors
from symgen.robot.body import COUPLING, CouplingDynamics, Dynamics, JointDynamics
from symgen.robot.formats.mjcf import CABLE, DRAG, SPRING
from symgen.robot.formats.mjcf_drives import JointDrive, require_drives
from symgen.robot.formats.mjcf_writer import updated_mjcf
from symgen.robot.formats.urdf import updated_urdf
from symgen.robot.formats.xml import relocated
from symgen.robot.imported import read_text
from symgen.robot.toml_io import read_imported, read_robot
from symgen.robot.toml_text import robot_toml
from symgen.robot.types import Joint, Robot

#: Schema and name of the file that lists the parameters of drawn robots.
SAMPLES, MARKER = "symgen.samples/1", "samples.json"
_NO_ACTUATORS = "a URDF holds no actuators: export an MJCF to have the identified drives"
_CAVEAT = (
    "base parameters do not determine link parameters: these are one of infinitely many sets that "
    "give the same torques, and a single mass or centre need not be the robot's"
)
#: Simulators that clip torques at the limits of a file.
_CLIPS = {
    ".urdf": "Drake, Genesis and the actuators of MuJoCo clip them",
    ".xml": "MuJoCo, Drake and Genesis clip them",
}
#: Largest imaginary part of a root that counts as real, relative to its size.
_REAL = 1e-9
#: Largest rounding error of a parameter that is written and read, as a part of the largest one.
_READ = 1e-8


def values_header(estimate: Estimate, prefix: str | None = None) -> str:
    """Return NAME_values.h: the identified X as `static const NAME_real NAME_values[]`.

    The header includes NAME.h of the generated package. It compares digests, so it compiles only
    with a package of the same robot.toml. Its first lines are the verdict and the reasons.

    Args:
        estimate: the estimate.
        prefix: prefix of the package, for example NAMEf for a float package; by default the name of
            the robot.

    Raises:
        ParameterError: a value is not finite, or the result of method consistent is not possible.
    """
    robot = dict(estimate.provenance).get(ROBOT_DIGEST, "")
    return values_header_text(
        prefix or estimate.robot,
        estimate.robot,
        estimate_values(estimate),
        [(p.name, p.expression, p.unit) for p in estimate.parameters],
        digest=model_digest(robot) if re.fullmatch("[0-9a-f]{64}", robot) else None,
    )


@dataclass(frozen=True, eq=False)
class IdentifiedFile:
    """A robot file of another program with identified values.

    Attributes:
        text: text of the file.
        values: every standard parameter of the robot by name, including those in `left_out`.
        left_out: name, value and unit of each non-zero parameter that the format cannot hold.
        notes: texts on the numbers in the file and on the programs that read them.
    """

    text: str
    values: Mapping[str, float]
    left_out: tuple[tuple[str, float, str], ...]
    notes: tuple[str, ...]


def identified_file(
    path: str | Path,
    estimate: Estimate,
    robot: Robot | None,
    X: FloatArray | None = None,
    folder: str | Path | None = None,
    higher: bool = False,
    actuator: str | None = None,
) -> IdentifiedFile:
    """Return the text of a robot file with identified values.

    Base parameters do not determine link parameters. Of all physically possible ones that give X,
    symgen takes those closest to the values of the file. If X is not physically possible, it takes
    the nearest possible X, in the metric of its covariance.

    Args:
        path: the file from which the robot was read.
        estimate: an estimate of that robot.
        robot: that robot, if it fixes joints that move in the file.
        X: (p,) base parameters to write; by default those of the estimate.
        folder: destination of the text, for its relative paths; by default the folder of the file.
        higher: whether to write dampers and springs of higher order, which MuJoCo 3.7 reads.
        actuator: actuators of identified drives in an MJCF, see `export`.

    Raises:
        RobotError: symgen cannot read the file.
        ParameterError: the file is of another robot, or cannot hold the values.
    """
    path = Path(path)
    require_scale(estimate, f"{path.name}: not exported")
    imported = read_imported(path, None if robot is None else robot.base)
    model = derive(with_fixed_links(robot or imported.robot, imported.robot, path))
    ours = [name.removesuffix("R") for name in model.base.names]
    theirs = [p.name.removesuffix("R") for p in estimate.parameters]
    if ours != theirs:
        raise ParameterError(f"{path}: the estimate is of another robot")
    links = link_parameters(
        model,
        estimate.X if X is None else X,
        prior=cad_parameters(path, model) if imported.parameters else None,
        nearest=estimate.covariance,
    )
    mjcf = path.suffix.lower() == ".xml"
    found = joint_drives(estimate, model.robot, links.values, actuator) if mjcf else {}
    drives = {imported.robot.joints[k - 1].name: drive for k, drive in found.items()}
    moved = {f"FV{k}": links.values[f"FV{k}"] - d.viscous for k, d in found.items() if d.viscous}
    of_joints = replace(links, values={**links.values, **moved})
    dynamics, contained = _dynamics(model.robot, of_joints, higher and mjcf)
    notes = [f"link parameters in {path.name}: {_CAVEAT}"]
    if links.sigmas > 0:
        notes.append(
            "the file contains the possible values nearest to the identified X, "
            f"{links.sigmas:.2g} standard deviations away"
        )
        if X is None and estimate.physical.held_out is not None:
            least, possible = map(percent, estimate.physical.held_out)
            notes.append(
                f"their torque error on held-out folds of the training logs is {possible}, that of "
                f"the identified X {least}"
            )
    if mjcf:
        text = updated_mjcf(path, dynamics, drives, model.robot.base)
    else:
        text, _ = read_text(path, "accepted: a .urdf")
        text = updated_urdf(text, dynamics, str(path), model.robot.base)
        contained = set()
        if estimate.drives:
            notes.append(_NO_ACTUATORS)
        if any(joint.armature for joint in dynamics.joints):
            notes.append(
                "rotor inertia stands in <dynamics armature>, which symgen reads; other programs "
                "ignore it"
            )
        if any(joint.frictionloss for joint in dynamics.joints):
            notes.append(
                "Coulomb friction stands in <dynamics friction>, which Drake and some simulators "
                "ignore"
            )
    left_out = tuple(_not_contained(model, links, contained))
    if mjcf:
        absent = dict.fromkeys((name for name, _, _ in left_out), 0.0)
        _require_read(text, path, model, {**of_joints.values, **absent}, drives)
    text = relocated(text, path, path.parent if folder is None else Path(folder))
    return IdentifiedFile(text, links.values, left_out, tuple(notes))


def _require_read(
    text: str,
    path: Path,
    model: Model,
    values: Mapping[str, float],
    drives: Mapping[str, JointDrive],
) -> None:
    """Refuse an MJCF from which MuJoCo reads other values than symgen wrote.

    Settings of the compiler can change masses and inertias, and springdamper changes damping.

    Args:
        text: the text of the file, with the values.
        path: base of its relative paths.
        model: model of the robot.
        values: the written standard parameters.
        drives: the written drives, by names of joints.

    Raises:
        ParameterError: MuJoCo reads another value of a base parameter, or of a drive.
    """
    with TemporaryDirectory() as folder:
        place = Path(folder) / path.name
        place.write_text(relocated(text, path, place.parent), encoding="utf-8")
        read = read_parameters(place, model)
        require_drives(place, drives)
    written = base_values(values, model, str(path))
    size = float(np.abs(written).max())
    for name, ours, theirs in zip(model.base.names, written, read, strict=True):
        if abs(ours - theirs) > _READ * size:
            raise ParameterError(
                f"{path}: MuJoCo reads {name} = {theirs:.6g} where {ours:.6g} is written; "
                "accepted: a file without springdamper, without losses of actuators, and without "
                "settings of <compiler> that change masses"
            )


def _dynamics(robot: Robot, links: LinkParameters, higher: bool) -> tuple[Dynamics, set[str]]:
    """Return the parameters of a robot that a robot file can hold.

    Args:
        robot: the robot.
        links: its standard parameters.
        higher: whether the file can hold dampers and springs of higher order.

    Returns:
        The parameters, and the names of those of effects and couplings.
    """
    written = set[str]()
    joints = [_joint_dynamics(j, robot, links.values, higher, written) for j in robot.movable]
    couplings = []
    for c in robot.couplings:
        losses = [f"{prefix}{c.second}" for prefix in COUPLING]
        ratio = float(c.ratio.subs(robot.values()))
        values = (links.values.get(name, 0.0) for name in losses)
        couplings.append(CouplingDynamics(*c.joints, ratio, *values))
        written.update(losses)
    return Dynamics(links.bodies, tuple(joints), tuple(couplings)), written


def _joint_dynamics(
    joint: Joint, robot: Robot, values: Mapping[str, float], higher: bool, written: set[str]
) -> JointDynamics:
    """Return the torque of a joint, with its friction of order 2 and 3 and its springs.

        c0 + c1 q + c2 q^2 + c3 q^3 = stiffness x + s1 x^2 + s2 x^3,    x = q - springref

    A spring without a position of rest is left out.

    Args:
        joint: the joint.
        robot, values: the robot and its standard parameters.
        higher: whether to include those of higher order.
        written: receives the names of the parameters of effects.
    """
    k = joint.number
    prefixes = names.ROTOR, "FV", "FS", "OF"
    armature, viscous, friction, offset = (values.get(f"{p}{k}", 0.0) for p in prefixes)
    damping = {2: 0.0, 3: 0.0}
    torque = np.array([offset, 0, 0, 0])
    of_springs = {f"OF{k}"}
    for effect in (e for e in robot.effects if e.joint == k):
        coefficients = [name for name, _ in effect.linear]
        if effect.name == SPRING or (effect.name == CABLE and higher):
            torque[1 : 1 + len(coefficients)] += [values[name] for name in coefficients]
            of_springs.update(coefficients)
        if effect.name == DRAG and higher and effect.nonlinear[0][1] in damping:
            order = int(effect.nonlinear[0][1])
            damping[order] += values[coefficients[0]]
            written.update(coefficients)
    own = JointDynamics(
        k, armature, viscous, friction, damping_2=damping[2], damping_3=damping[3]
    )  # fmt: skip
    spring = np.polynomial.Polynomial(torque)
    roots = np.asarray(spring.roots(), dtype=complex)
    rests = roots.real[np.abs(roots.imag) <= _REAL * (1 + np.abs(roots))]
    if not len(rests):
        return own
    written.update(of_springs)
    rest = float(rests[np.abs(rests).argmin()])
    first, second, third = (float(spring.deriv(m)(rest)) for m in (1, 2, 3))
    return replace(
        own, stiffness=first, stiffness_2=second / 2, stiffness_3=third / 6, springref=rest
    )


def _not_contained(
    model: Model, links: LinkParameters, contained: Collection[str]
) -> Iterator[tuple[str, float, str]]:
    """Yield the non-zero parameters that a format cannot hold.

    Args:
        model: model of the robot.
        links: parameters of the robot.
        contained: names of parameters in the file in addition to links, rotors and friction.
    """
    always = {*names.LINK, names.ROTOR, "FS", "FV"}
    for p in model.base.standard:
        value = links.values[p.name]
        if value and p.prefix not in always and p.name not in contained:
            yield p.name, value, p.unit


def export(
    estimate: str | Path,
    source: str | Path,
    robot: str | Path | Robot | None = None,
    *,
    folder: str | Path | None = None,
    higher: bool = False,
    actuator: str | None = None,
) -> IdentifiedFile:
    """Return a copy of a URDF or MJCF with all parameters of an estimate that it can hold.

    Args:
        estimate: an estimate.json, or the folder that `identify` wrote.
        source: path of the URDF or MJCF. Only <inertial>, friction, rotor inertia, springs,
            couplings and, of an estimate with drives, actuators change in the copy.
        robot: the identified robot, its path or a library name. By default the robot.toml in the
            folder of the estimate, or else the robot of `source`.
        folder: destination of the copy, for relative paths of meshes; by default the folder of
            `source`.
        higher: whether to write dampers and springs of higher order, which MuJoCo 3.7 reads.
        actuator: actuators of an MJCF from an estimate with drives: "position", "motor" or
            "dcmotor"; by default "position" where the controller of the robot commands duty, else
            "motor".

    Raises:
        RobotError: symgen cannot read a robot.
        ParameterError: symgen cannot read the estimate, the estimate is of another robot, or the
            file cannot hold its values.
    """
    known, robot = read_identified(estimate, robot)
    return identified_file(source, known, robot, None, folder, higher, actuator)


def write_copies(
    to: Path,
    source: Path,
    estimate: Estimate,
    robot: Robot | None,
    *,
    samples: int | None = None,
    seed: int = 0,
    higher: bool = False,
    actuator: str | None = None,
) -> tuple[list[Path], IdentifiedFile]:
    """Write copies of a robot's file with identified values: one, or some in a folder.

    Those in a folder have parameters drawn from their distribution, for domain randomisation. A
    table in the folder has the parameters of each.

        X ~ N(X0, C),    moved to the nearest physically possible X

    Args:
        to: path of the copy, or of the folder.
        source: path of the URDF or MJCF.
        estimate, robot: the estimate and its robot, as `read_identified` returns them.
        samples: number of copies in the folder; None for one copy with the values of the estimate.
        seed: seed of the draws.
        higher, actuator: as for `export`.

    Returns:
        The paths of the copies, and the first copy.

    Raises:
        PackageError: the path cannot be written.
        ParameterError: as for `export`, or the estimate has no covariance.
    """
    encoding = "utf-8-sig" if source.read_bytes().startswith(BOM_UTF8) else "utf-8"
    if samples is None:
        file = identified_file(source, estimate, robot, None, to.parent, higher, actuator)
        write_text(to, file.text.encode(encoding))
        return [to], file
    X = _drawn(estimate, samples, seed)
    drawn = [identified_file(source, estimate, robot, x, to, actuator=actuator) for x in X]
    digits = len(str(samples - 1))
    numbers = [f"{k:0{digits}d}" for k in range(samples)]
    names_of_files = [f"{source.stem}_{number}{source.suffix}" for number in numbers]
    values = [dict(file.values) for file in drawn]
    table = {"schema": SAMPLES, "seed": seed, "files": names_of_files, "parameters": values}
    contents = [file.text.encode(encoding) for file in drawn]
    files = dict(zip(names_of_files, contents, strict=True))
    write_folder(to, {**files, MARKER: json_text(table).encode()}, MARKER)
    return [to / name for name in files], drawn[0]


def _drawn(estimate: Estimate, count: int, seed: int) -> FloatArray:
    """Return parameters (count, p) drawn from the normal distribution of an estimate.

    Raises:
        ParameterError: the estimate has no covariance.
    """
    p = len(estimate.parameters)
    if estimate.covariance.shape != (p, p) or not np.isfinite(estimate.covariance).all():
        raise ParameterError(
            f"{estimate.robot}: its estimate has no covariance of all parameters; accepted: an "
            "estimate whose parameters all have a standard deviation"
        )
    values, vectors = np.linalg.eigh(estimate.covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    normal = np.random.default_rng(seed).normal(size=(count, p))
    return np.array([estimate.X + root @ x for x in normal])


def read_identified(
    estimate: str | Path, robot: str | Path | Robot | None = None
) -> tuple[Estimate, Robot | None]:
    """Return an estimate and its robot.

    The robot is None if the caller names none and the folder of the estimate has no robot.toml.

    Raises:
        RobotError: symgen cannot read the robot.
        ParameterError: symgen cannot read the estimate, or it is of another robot.
    """
    known = read_estimate(estimate)
    path = Path(estimate)
    in_folder = (path if path.is_dir() else path.parent) / "robot.toml"
    if robot is None and in_folder.is_file():
        robot = in_folder
    if robot is not None:
        robot = read_robot(robot)
        digest = hashlib.sha256(robot_toml(robot).encode()).hexdigest()
        if dict(known.provenance).get(ROBOT_DIGEST, digest) != digest:
            raise ParameterError(
                f"{path}: the estimate is of another robot than {robot.name}; accepted: --robot "
                "with the robot.toml that was identified"
            )
    return known, robot


def beyond_limits(
    log: str | Path, robot: Robot | None, path: Path, reading: Reading | None = None
) -> Iterator[str]:
    """Yield a note on a log with torques above the limits in a robot file.

    Args:
        log: path of the log.
        robot: the robot; None for that of the file.
        path: path of its URDF or MJCF.
        reading: options of reading the log.

    Raises:
        LogError: symgen cannot read the log.
    """
    file = read_imported(path, None if robot is None else robot.base).robot
    robot = robot or file
    samples, _ = open_samples(log, robot, reading)
    torques = (file.limits and not samples.drive_unit and file.limits.torque) or ()
    limits = dict(zip(file.joint_names, torques, strict=False))
    peaks = np.abs(samples.tau).max(axis=0)
    highest = [limits.get(name, math.inf) for name in robot.joint_names]
    over = peaks > highest
    if over.any():
        yield (
            f"{samples.name}: torques of {robot.listed(np.flatnonzero(over))} are above the limits "
            f"in {path.name}, where {_CLIPS[path.suffix.lower()]}"
        )


@dataclass(frozen=True)
class FileErrors:
    """Torque errors on a log, relative.

    Attributes:
        log: path of the log.
        files: error of the parameters in each file.
        estimate: error of the estimate.
    """

    log: str | Path
    files: tuple[float, ...]
    estimate: float

    @property
    def in_words(self) -> str:
        """The errors in one line."""
        mean = percent(fmean(self.files))
        count = len(self.files)
        if count > 1:
            spread = percent(pstdev(self.files))
            mean = f"{mean} on average over {count} files, std {spread}"
        return f"torque error on {self.log}: {mean}; the estimate {percent(self.estimate)}"

    def exceed(self, least: float) -> bool:
        """Return whether that of the first file is above the estimate's by more than `least`."""
        return self.files[0] > self.estimate + least


def file_errors(
    paths: Sequence[Path],
    log: str | Path,
    estimate: Estimate,
    robot: str | Path | Robot,
    reading: Reading | None = None,
) -> FileErrors:
    """Return the torque errors on a log, of the values in robot files and of the estimate.

    All errors use the band of the estimate. A parameter that a file does not hold is 0.

    Args:
        paths: paths of URDF or MJCF files.
        log: path of the log.
        estimate: an estimate of the robot.
        robot: the robot.
        reading: options of reading the log.

    Raises:
        LogError: symgen cannot read the log.
        ParameterError: a file is of another robot.
    """
    robot = read_robot(robot)
    model = derive(robot, JUDGING)
    parameters = [*(read_parameters(path, model) for path in paths), estimate.X]
    *files, of_estimate = torque_errors(
        robot, log, parameters, estimate.band, estimate.shifts, reading, known_torques(estimate)
    )
    return FileErrors(log, tuple(files), of_estimate)
