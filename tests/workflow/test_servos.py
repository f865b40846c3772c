"""Servos that report their duty: scales, units, what they give to other commands, refusals."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from oracles import servos

import symgen
from symgen.experiment.playback import compare_simulations
from symgen.identification.estimate import Estimate
from symgen.robot.tables import Drive, Servo
from symgen.robot.types import Robot

LOAD, PLACE = 0.8, (0.01, 0.01, -0.22)  # kg, m in the body of the last link
#: Deviations within which all numbers of one arm lie.
WITHIN = 4.5


class Recorded:
    """One arm, its file without masses, and its logs."""

    def __init__(self, folder: Path) -> None:
        rng = np.random.default_rng(11)
        self.arm = servos.random_arm("leg", rng)
        file = folder / "leg.xml"
        file.write_text(servos.mjcf(self.arm))
        self.file = file
        gains = Servo((self.arm.gain,) * 3, (0.0,) * 3, unit="duty")
        self.robot = replace(symgen.read_robot(file), payload=3, controller=gains)
        self.train = [servos.recorded(self.arm, f"train{k}", rng, 40.0) for k in range(2)]
        self.test = servos.recorded(self.arm, "test", rng, 20.0)
        load = LOAD, PLACE
        self.carried = servos.recorded(self.arm, "carried", rng, 40.0, load=load)
        self.later = servos.recorded(self.arm, "later", rng, 30.0, load=(0.5, PLACE))

    def identified(self, robot: Robot | None = None, **fit: object) -> Estimate:
        """The estimate of the arm by the logs without its load."""
        return symgen.identify(
            robot or self.robot,
            self.train,
            validation=[self.test],
            fit=symgen.FitOptions(**fit),  # type: ignore[arg-type]
        )


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    return Recorded(tmp_path_factory.mktemp("servos"))


@pytest.fixture(scope="module")
def known(recorded: Recorded) -> Estimate:
    return recorded.identified(carried=[recorded.carried], mass=LOAD)


def value(estimate: Estimate, name: str) -> tuple[float, float]:
    """Value and standard deviation of a parameter."""
    return next((p.value, p.std) for p in estimate.parameters if p.name == name)


def test_a_known_mass_gives_the_torque_of_the_drives(recorded: Recorded, known: Estimate) -> None:
    arm = recorded.arm
    assert known.verdict == "trusted"
    for j, drive in enumerate(known.drives):
        assert drive.unit == "N m per duty"
        assert drive.torque == pytest.approx(arm.a[j], abs=WITHIN * drive.std)
        assert drive.std < 0.03 * arm.a[j]
        stall = arm.a[j] - arm.coulomb[j]
        assert drive.stall == pytest.approx(stall, abs=WITHIN * drive.stall_std)
        speed = stall / (arm.b[j] + arm.viscous[j])
        assert drive.no_load == pytest.approx(speed, abs=WITHIN * drive.no_load_std)
        viscous, std = value(known, f"FV{j + 1}")
        assert viscous == pytest.approx(arm.b[j] + arm.viscous[j], abs=WITHIN * std)
        coulomb, std = value(known, f"FS{j + 1}")
        assert coulomb == pytest.approx(arm.coulomb[j], abs=WITHIN * std)
    first, std = value(known, "MX3R")
    assert first == pytest.approx(-arm.mass[2] * 0.45 * 0.25, abs=WITHIN * std)


def test_a_later_load_is_weighed_by_the_same_drives(
    recorded: Recorded, known: Estimate, tmp_path: Path
) -> None:
    symgen.write(known, tmp_path / "known", robot=recorded.robot)
    load = symgen.payload(recorded.robot, recorded.later, parameters=tmp_path / "known")
    assert load.mass.value is not None
    assert load.mass.std is not None
    assert load.mass.value == pytest.approx(0.5, abs=WITHIN * load.mass.std)
    assert load.mass.value == pytest.approx(0.5, rel=0.02)
    predicted = symgen.predict(recorded.robot, recorded.test, tmp_path / "known")
    assert predicted.error.relative == pytest.approx(known.torque_validation.relative, rel=1e-9)


def with_servos(arm: servos.Arm, file: Path, kp: list[float], force: list[float]) -> Path:
    """A file of an arm with position actuators."""
    actuators = "".join(
        f'<position joint="joint{j + 1}" kp="{kp[j]!r}" forcerange="{-force[j]!r} {force[j]!r}"/>'
        for j in range(arm.n)
    )
    text = re.sub("<general.*(?=</actuator>)", actuators, servos.mjcf(arm))
    file.write_text(text.replace(f'timestep="{servos.TIMESTEP}"', 'timestep="0.001"'))
    return file


def test_an_exported_arm_follows_the_reference_as_the_true_one_does(
    recorded: Recorded, known: Estimate, tmp_path: Path
) -> None:
    arm, off = recorded.arm, np.array([1.25, 0.75, 1.3])
    strength = arm.a * arm.gain
    true = replace(arm, viscous=arm.viscous + arm.b)  # no limit clips the back-EMF
    typical = {key: np.full(3, x) for key, x in (("rotor", 0.01), ("coulomb", 0.1))}
    makers = replace(
        arm,
        mass=off * arm.mass,
        inertia=off[:, None] * arm.inertia,
        viscous=0.1 + 0 * off,
        **typical,
    )
    files = [
        tmp_path / "identified.xml",
        with_servos(true, tmp_path / "true.xml", strength.tolist(), arm.a.tolist()),
        with_servos(makers, tmp_path / "makers.xml", [50.0] * 3, (1.1 * arm.a).tolist()),
    ]
    symgen.write(known, tmp_path / "known", robot=recorded.robot)
    files[0].write_text(symgen.export(tmp_path / "known", files[2]).text)
    found = compare_simulations(files, [recorded.test], robot=recorded.robot)
    assert found.driven_by == "reference"
    ours, best, theirs = (file.horizons[-1].position_error for file in found.files)
    assert ours < 1.1 * best
    assert ours < 0.2 * theirs


def test_without_a_mass_everything_is_counted_in_duty(recorded: Recorded, tmp_path: Path) -> None:
    relative = recorded.identified()
    arm = recorded.arm
    assert relative.verdict == "trusted"
    assert {p.unit for p in relative.parameters} == {
        "kg m2 per duty",
        "kg m per duty",
        "duty",
        "duty s/rad",
    }
    assert {joint.unit for joint in relative.joints} == {"duty"}
    (reason,) = (r for r in relative.uses.parameters.reasons if r.kind == "drive_scale_unknown")
    assert "--carried LOG --mass KG" in reason.text
    for j, drive in enumerate(relative.drives):
        assert drive.torque == pytest.approx(arm.a[j] / arm.a[0], abs=WITHIN * drive.std + 1e-12)
        viscous, std = value(relative, f"FV{j + 1}")
        wanted = (arm.b[j] + arm.viscous[j]) / arm.a[0]
        assert viscous == pytest.approx(wanted, abs=WITHIN * std)
    symgen.write(relative, tmp_path / "relative", robot=recorded.robot)
    with pytest.raises(symgen.ParameterError, match=r"counted in the duty.*--carried"):
        symgen.export(tmp_path / "relative", recorded.file)
    with pytest.raises(symgen.ParameterError, match=r"no mass in kg.*--carried"):
        symgen.payload(recorded.robot, recorded.later, parameters=tmp_path / "relative")


def test_values_of_a_motor_from_its_catalogue_give_newton_metres(recorded: Recorded) -> None:
    arm = recorded.arm
    supply, ratio = 12.0, 200.0
    torque_constant = 0.9 * arm.a[0] / ratio / supply * np.ones(3)  # at 1 ohm, 10 % off
    drive = Drive(
        ratio=tuple(map(tuple, (ratio * np.eye(3)).tolist())),
        torque_constant=tuple((torque_constant * arm.a / arm.a[0]).tolist()),
        supply=(supply,) * 3,
        resistance=(1.0,) * 3,
        position_side="joint",
        torque_side="joint",
    )
    rough = recorded.identified(replace(recorded.robot, drive=drive))
    for j, found in enumerate(rough.drives):
        assert found.unit == "N m per duty"
        assert 0.05 * found.torque < found.std < 0.2 * found.torque
        assert found.torque == pytest.approx(arm.a[j], abs=3 * found.std)
    assert any("15 %; --carried LOG --mass KG measures it" in note for note in rough.notes)


@pytest.mark.parametrize(
    ("fit", "said"),
    [
        ({"mass": 1.0}, "--carried LOG with --mass KG"),
        ({"carried": ["log"], "mass": 0.0}, "--mass 0; accepted: a mass above 0 kg"),
        ({"carried": ["log"]}, "--carried LOG with --mass KG"),
    ],
)
def test_what_a_known_mass_needs(recorded: Recorded, fit: dict[str, object], said: str) -> None:
    with pytest.raises(symgen.IdentificationError, match=said):
        recorded.identified(**fit)


def test_a_known_mass_needs_its_link_and_another_log(recorded: Recorded) -> None:
    bare = replace(recorded.robot, payload=None)
    with pytest.raises(symgen.RobotError, match=r"\[payload\] with joint = 3"):
        recorded.identified(bare, carried=[recorded.carried], mass=LOAD)
    with pytest.raises(symgen.LogError, match="same data"):
        recorded.identified(carried=[recorded.train[0]], mass=LOAD)


def test_open_windings_tell_back_emf_from_viscous_friction(recorded: Recorded) -> None:
    arm, rng = recorded.arm, np.random.default_rng(5)
    opened = [servos.recorded(arm, f"open{k}", rng, 3.0, opened=True) for k in range(6)]
    estimate = recorded.identified(carried=[recorded.carried], mass=LOAD, opened=opened)
    known = [d for d in estimate.drives if np.isfinite(d.back_emf)]
    assert [d.joint for d in known] == [1, 2]  # friction holds joint 3
    for drive in known:
        b = arm.b[drive.joint - 1]
        assert drive.back_emf == pytest.approx(b, abs=WITHIN * drive.back_emf_std)
        assert drive.back_emf_std < 0.02 * b
