"""The oracles agree with each other and with published counts, before anything relies on them."""

from dataclasses import replace

import numpy as np
import pytest
from oracles import planar2r
from oracles.arm import Arm as TwoLinks
from oracles.exact import (
    MP,
    exact_energy_regressor,
    exact_torque_regressor,
)
from oracles.ground_truth import TRUTH, VARIANTS
from oracles.numeric_rank import (
    NoGapError,
    count_base_parameters,
    numeric_rank,
    random_states,
)
from oracles.pinocchio_arm import PinocchioArm, load_pinocchio
from oracles.random_arms import random_arm, random_arms, random_parameters
from oracles.transforms import (
    PRISMATIC,
    Arm,
    column_names,
    kinetic_regressor,
    parameter_vector,
    potential_regressor,
    world_transforms,
)
from support import sampled

PLANAR2R = Arm.from_table({"sigma": (0, 0), "d": (0.0, 0.5)})
# Two arms on joint 1 whose joints alternate in the file.
CROSSED = Arm.from_table(
    {
        "sigma": (0,) * 5,
        "ant": (0, 1, 1, 2, 3),
        "alpha": (0.3, 0.4, 0.5, 0.6, 0.7),
        "d": (0.1, 0.2, 0.3, 0.4, 0.5),
    }
)


@pytest.fixture
def pinocchio() -> None:
    try:
        load_pinocchio()
    except ImportError as error:
        pytest.skip(f"Pinocchio is not at hand (pip install pin): {error}")


@pytest.mark.usefixtures("pinocchio")
@pytest.mark.parametrize("seed", range(30))
def test_energies_equal_pinocchio(seed: int) -> None:
    arm = random_arm(seed)
    links, rotors = random_parameters(arm, seed)
    X = parameter_vector(arm, links, rotors)
    reference = PinocchioArm(arm, links, rotors)
    q, qd = random_states(arm, 5, seed)
    kinetic = kinetic_regressor(arm, q, qd) @ X
    potential = potential_regressor(arm, q) @ X
    expected_kinetic = [reference.kinetic_energy(*state) for state in zip(q, qd, strict=True)]
    expected_potential = np.array([reference.potential_energy(state) for state in q])
    np.testing.assert_allclose(kinetic, expected_kinetic, rtol=0, atol=1e-10)
    # Up to a constant: Pinocchio leaves out links that are fixed to the base.
    shift = potential - expected_potential
    np.testing.assert_allclose(shift - shift[0], 0, rtol=0, atol=1e-10)


@pytest.mark.usefixtures("pinocchio")
@pytest.mark.parametrize("arm", [*random_arms(10, seed=6, min_joints=4, tree=True), CROSSED])
def test_mass_matrix_and_frames_equal_pinocchio(arm: Arm) -> None:
    links, rotors = random_parameters(arm, 0)
    X = parameter_vector(arm, links, rotors)
    reference = PinocchioArm(arm, links, rotors)
    q, qd = (x[0] for x in random_states(arm, 1, 0))
    energy = kinetic_regressor(arm, q, qd) @ X
    assert qd @ reference.mass_matrix(q) @ qd / 2 == pytest.approx(energy, abs=1e-10)
    frames = world_transforms(arm, q)[[j - 1 for j in arm.movable]]
    np.testing.assert_allclose(frames, reference.frame_placements(q), rtol=0, atol=1e-12)


@pytest.mark.usefixtures("pinocchio")
@pytest.mark.parametrize("seed", range(6))
def test_exact_torques_equal_pinocchio(seed: int) -> None:
    arm = random_arm(seed, max_joints=5)
    links, rotors = random_parameters(arm, seed)
    q, qd = random_states(arm, 2, seed)
    Y = exact_torque_regressor(arm, q[0], qd[0], qd[1]).astype(float)
    torque = PinocchioArm(arm, links, rotors).inverse_dynamics(q[0], qd[0], qd[1])
    np.testing.assert_allclose(Y @ parameter_vector(arm, links, rotors), torque, atol=1e-10)


@pytest.mark.parametrize(
    ("robot", "variant"), sampled([(r, v) for r in TRUTH for v in VARIANTS], 11)
)
def test_counts_equal_ground_truth(robot: str, variant: str) -> None:
    entry = TRUTH[robot]
    rotor, friction = VARIANTS[variant]
    count = count_base_parameters(Arm.from_table(entry), rotor, friction)
    assert entry["counts"][variant] == {"torque": count, "energy": count, "agree": True}


def test_rank_of_random_arms_is_certain_and_does_not_depend_on_the_samples() -> None:
    for arm in random_arms(60, seed=3):
        friction = ("coulomb", "offset")
        counts = {count_base_parameters(arm, True, friction, seed=seed) for seed in (0, 1)}
        assert len(counts) == 1, arm


def test_a_column_of_rounding_noise_is_not_a_parameter() -> None:
    rng = np.random.default_rng(0)
    signal = rng.normal(size=(50, 3))
    noise = 1e-16 * rng.normal(size=(50, 2))
    assert numeric_rank(np.hstack([signal, noise, signal @ rng.normal(size=(3, 2))])) == 3
    assert numeric_rank(noise) == 0


def test_a_rank_without_a_gap_is_refused() -> None:
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 50, 1))
    for apart in (1e-9, 1e-10, 1e-11):
        with pytest.raises(NoGapError):
            numeric_rank(np.hstack([a, a + apart * b]))
    assert numeric_rank(np.hstack([a, a + 1e-6 * b])) == 2
    assert numeric_rank(np.hstack([a, a + 1e-14 * b])) == 1
    with pytest.raises(NoGapError):
        numeric_rank(np.hstack([a, 1e-8 * b]))


def test_offset_mass_and_rotor_of_a_vertical_slide_are_two_parameters() -> None:
    vertical = Arm.from_table({"sigma": (PRISMATIC,)})
    horizontal = Arm.from_table({"sigma": (PRISMATIC,), "gravity": (-9.81, 0.0, 0.0)})
    assert count_base_parameters(vertical, True, ("offset",)) == 2
    assert count_base_parameters(vertical, True) == 2
    assert count_base_parameters(horizontal, True, ("offset",)) == 2
    assert count_base_parameters(horizontal, True) == 1
    assert count_base_parameters(horizontal, True, ("coulomb", "viscous", "offset")) == 4


def test_mpmath_carries_50_digits_and_is_exact_at_right_angles() -> None:
    arm = Arm.from_table(
        {"sigma": (0, 0), "alpha": (0.0, np.pi / 2), "d": (0.0, 0.1), "gravity": (0, 0, -9.81)}
    )
    h = exact_energy_regressor(arm, ["0.3", "0.7"], ["1", "2"])
    values = dict(zip(column_names(arm), h, strict=True))
    # In frame 2: v2 = (0, 0, -d qd1), w2 = (sin q2 qd1, cos q2 qd1, qd2); x2 rises by sin q2.
    sine, cosine = MP.sin(MP.mpf("0.7")), MP.cos(MP.mpf("0.7"))
    expected = MP.mpf("9.81") * sine + cosine / 10
    assert abs(values["XX2"] - sine**2 / 2) < MP.mpf(10) ** -55
    assert abs(values["MX2"] - expected) < MP.mpf(10) ** -55
    assert abs(values["M1"]) == 0


def _planar_parameters() -> tuple[np.ndarray, np.ndarray, float]:
    links, _ = random_parameters(PLANAR2R, 0)
    L1 = PLANAR2R.d[1]
    X = np.array([links[0, 5] + L1**2 * links[1, 9], links[1, 5], links[1, 6], links[1, 7]])
    return links, X, L1


@pytest.mark.usefixtures("pinocchio")
def test_planar2r_equals_pinocchio() -> None:
    links, X, L1 = _planar_parameters()
    reference = PinocchioArm(PLANAR2R, links)
    q, qd = random_states(PLANAR2R, 20, 0)
    qdd = random_states(PLANAR2R, 20, 1)[1]
    tau = planar2r.inverse_dynamics(q, qd, qdd, X, L1)
    energy = planar2r.energy_regressor(q, qd, L1) @ X
    for i in range(len(q)):
        M = planar2r.mass_matrix(q[i], X, L1)
        np.testing.assert_allclose(M, reference.mass_matrix(q[i]), atol=1e-12)
        expected = reference.inverse_dynamics(q[i], qd[i], qdd[i])
        np.testing.assert_allclose(tau[i], expected, atol=1e-11)
        assert energy[i] == pytest.approx(reference.kinetic_energy(q[i], qd[i]), abs=1e-11)


@pytest.mark.usefixtures("pinocchio")
def test_the_arm_with_gravity_equals_pinocchio() -> None:
    links, X, L1 = _planar_parameters()
    links[0, 7] = 0.0  # MY1
    vertical = replace(PLANAR2R, gravity=(0, -9.81, 0))
    reference = PinocchioArm(vertical, links, rotor_inertia=np.array([0.0, 0.3]))
    hanging = TwoLinks(X, MX1R=links[0, 6] + L1 * links[1, 9], g=9.81, IA2=0.3, L1=L1)
    q, qd = random_states(PLANAR2R, 20, 0)
    qdd = random_states(PLANAR2R, 20, 1)[1]
    tau = hanging.torque(q, qd, qdd)
    expected = [reference.inverse_dynamics(*x) for x in zip(q, qd, qdd, strict=True)]
    np.testing.assert_allclose(tau, expected, atol=1e-10)
    np.testing.assert_allclose(hanging.acceleration(q, qd, tau), qdd, atol=1e-10)


def test_planar2r_equals_the_transforms() -> None:
    links, X, L1 = _planar_parameters()
    q, qd = random_states(PLANAR2R, 20, 0)
    standard = kinetic_regressor(PLANAR2R, q, qd, rotor=False) @ links.ravel()
    np.testing.assert_allclose(planar2r.energy_regressor(q, qd, L1) @ X, standard, atol=1e-12)
