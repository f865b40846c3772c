"""Link parameters from base parameters: they give X, could exist, and what cannot is refused."""

from __future__ import annotations

import random

import numpy as np
import pytest
from oracles.random_arms import random_arm, random_parameters
from packages import RICH
from support import PROJECT, robot_of, sampled

import symgen
from symgen import names
from symgen.codegen.model import regrouping
from symgen.codegen.verification import physical_parameters
from symgen.identification.parameters import cad_parameters
from symgen.identification.physical import LinkParameters, bodies

DRIVES = ("IA", "IAM", "FS", "FV", "FSM", "FVM")
L1 = 0.5
#: planar2r: a mass M2 with ZZ2 M2 > MX2^2 + MY2^2 and L1^2 M2 < ZZ1R must exist.
POSSIBLE = np.array([1.702, 0.05644, 0.15, 0.075])


@pytest.fixture(scope="module")
def planar() -> symgen.Model:
    return symgen.derive(symgen.read_robot("planar2r"))


def require_bodies(found: LinkParameters, model: symgen.Model) -> None:
    """Masses and principal moments positive, none above the sum of the others; drives dissipate."""
    links = sorted({p.name[2:] for p in model.base.standard if p.prefix == "XX"})
    for suffix in links:
        v = {prefix: found.values[prefix + suffix] for prefix in names.LINK}
        c = np.array([v["MX"], v["MY"], v["MZ"]]) / v["M"]
        own = np.array(
            [[v["XX"], v["XY"], v["XZ"]], [v["XY"], v["YY"], v["YZ"]], [v["XZ"], v["YZ"], v["ZZ"]]]
        ) + v["M"] * np.linalg.matrix_power(np.cross(np.eye(3), c), 2)
        a, b, largest = np.linalg.eigvalsh(own)
        assert v["M"] > 0, suffix
        assert a > 0, suffix
        assert a + b > largest, suffix
    for p in model.base.standard:
        if p.prefix in DRIVES:
            assert found.values[p.name] >= 0, p.name


def require_values(found: LinkParameters, model: symgen.Model, X: np.ndarray) -> None:
    """They regroup to X, by the code that the packages are made with."""
    standard = [found.values[p.name] for p in model.base.standard]
    given = regrouping(model) @ standard
    assert np.abs(given - X).max() <= 1e-9 * np.abs(X).max()
    np.testing.assert_allclose(given, X, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("seed", sampled(range(8), 3))
def test_a_robot_that_exists_is_found_possible(seed: int) -> None:
    arm = random_arm(seed, max_joints=6)
    model = symgen.derive(robot_of(arm, friction=("coulomb", "viscous", "offset")))
    links, rotors = random_parameters(arm, seed)
    draw = random.Random(seed)
    truth = {p.name: draw.uniform(0.1, 2.0) for p in model.base.standard}
    for number, row in enumerate(links, 1):
        truth |= {f"{k}{number}": float(x) for k, x in zip(names.LINK, row, strict=True)}
    truth |= {f"IA{j.number}": float(r) for j, r in zip(model.robot.movable, rotors, strict=True)}
    X = regrouping(model) @ [truth[p.name] for p in model.base.standard]
    found = symgen.link_parameters(model, X)
    assert found.sigmas == 0
    require_values(found, model, X)
    require_bodies(found, model)
    # The robot itself as the prior comes back: it is the closest to itself.
    own = symgen.link_parameters(model, X, prior=truth).values
    assert max(abs(own[name] - value) for name, value in truth.items()) < 1e-4


@pytest.mark.parametrize("seed", [3, 5])
def test_the_nearest_robot_with_the_links_of_a_file_has_bodies(seed: int) -> None:
    """An estimate that no robot can have, and the file's links as the prior, as export does it."""
    arm = random_arm(seed, max_joints=4)
    model = symgen.derive(robot_of(arm, friction=("coulomb", "viscous")))
    links, _ = random_parameters(arm, seed)
    file = {f"{k}{number}": float(x) for number, row in enumerate(links, 1)
            for k, x in zip(names.LINK, row, strict=True)}  # fmt: skip
    truth = {p.name: 0.0 if p.prefix == "IA" else 1.0 for p in model.base.standard} | file
    X = regrouping(model) @ [truth[p.name] for p in model.base.standard]
    std = 0.3 * np.abs(X) + 0.01
    off = X + std * np.random.default_rng(seed).standard_normal(len(X))
    found = symgen.link_parameters(model, off, prior=file, nearest=np.diag(std**2))
    require_bodies(found, model)


def test_links_at_the_limit_of_the_possible_stay_near_those_of_the_file() -> None:
    """Next to no links give such an X, and these weigh tonnes; a hundredth of a std helps."""
    file = PROJECT / "docs" / "files" / "arm.urdf"
    model = symgen.derive(file)
    X = np.array(
        [1.1629835118374097, -0.925583410001023, -0.007755738547198051, 0.00616491357489489,
         0.0002497339992926721, 0.9323486225348537, -2.615759804417566, -0.05648261958287486,
         -0.19745940891758262, -0.004357581517823988, 0.012589614846281929, 0.003374318282463664,
         0.1983120061304168, -0.7539290703307541, -0.001169666551328342, 0.0032586790787563127,
         1.9931507864189921, 1.2069389952288059, 2.474921937875697, 1.6183232143770274,
         1.09192200997713, 0.6093245835446295]
    )  # fmt: skip
    std = np.array(
        [0.0257, 0.0438, 0.0312, 0.0252, 0.0212, 0.0462, 0.0103, 0.0198, 0.011, 0.0165, 0.0042,
         0.0045, 0.0147, 0.0065, 0.0109, 0.023, 0.0336, 0.0286, 0.1271, 0.1011, 0.1382, 0.0664]
    )  # fmt: skip
    prior = cad_parameters(file, model)
    found = symgen.link_parameters(model, X, prior=prior, nearest=np.diag(std**2))
    require_bodies(found, model)
    assert found.sigmas < 0.1
    for name in ("M1", "M2", "M3"):
        assert found.values[name] == pytest.approx(prior[name], rel=0.5)


def test_trees_couplings_payload_and_named_lengths() -> None:
    model = symgen.derive(symgen.parse_robot(RICH))
    X = np.array(physical_parameters(model, random.Random(5)))
    found = symgen.link_parameters(model, X)
    require_values(found, model, X)
    require_bodies(found, model)
    assert [b.joint for b in found.bodies] == [1, 2, 3, 4, 5]


@pytest.mark.parametrize("share", [0.5, 0.999, 1.001, 2.0])
def test_the_limit_of_the_possible_is_that_of_the_closed_form(
    planar: symgen.Model, share: float
) -> None:
    ZZ2, MX2, MY2 = POSSIBLE[1:]
    X = np.array([share * L1**2 * (MX2**2 + MY2**2) / ZZ2, ZZ2, MX2, MY2])
    if share > 1:
        require_bodies(symgen.link_parameters(planar, X), planar)
    else:
        with pytest.raises(symgen.ParameterError, match="link 1 and link 2 cannot be positive"):
            symgen.link_parameters(planar, X)


@pytest.mark.parametrize(
    ("position", "value", "words"),
    [(0, -0.3, r"ZZ1R is -0.3.*ZZ1 \+ L1\*\*2\*M2"), (1, -0.1, "ZZ2 is -0.1 and cannot be neg")],
)
def test_what_no_robot_can_have_is_named(planar, position, value, words) -> None:
    X = POSSIBLE.copy()
    X[position] = value
    with pytest.raises(symgen.ParameterError, match=words) as refused:
        symgen.link_parameters(planar, X)
    assert "nearest=" in str(refused.value)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"X": POSSIBLE[:3]}, "4 finite base parameters"),
        ({"X": POSSIBLE * np.nan}, "4 finite base parameters"),
        ({"prior": {"M7": 1.0}}, "M7 is no standard parameter; accepted: XX1"),
        ({"prior": {"M2": float("inf")}}, "M2 is inf; accepted: a finite number"),
        ({"X": -POSSIBLE, "nearest": np.eye(3)}, r"not a \(4, 4\) matrix"),
        ({"X": -POSSIBLE, "nearest": np.zeros((4, 4))}, "positive diagonal"),
    ],
)
def test_bad_arguments_are_refused_in_words(planar, change, words) -> None:
    with pytest.raises(symgen.ParameterError, match=words):
        symgen.link_parameters(planar, **{"X": POSSIBLE, **change})


def test_bodies_are_those_of_point_masses() -> None:
    robot = symgen.parse_robot(RICH)
    draw = np.random.default_rng(1)
    values: dict[str, float] = {}
    loads = {}
    for suffix in ("1", "2", "3", "4", "5", "L"):
        m, r = draw.uniform(0.1, 1.0, 6), draw.normal(size=(6, 3))
        J = sum(mi * (ri @ ri * np.eye(3) - np.outer(ri, ri)) for mi, ri in zip(m, r, strict=True))
        row = [*J[np.triu_indices(3)], *(m @ r), m.sum()]
        values |= {f"{k}{suffix}": float(x) for k, x in zip(names.LINK, row, strict=True)}
        loads[suffix] = (m, r)
    for body in bodies(robot, values):
        carried = [loads[str(body.joint)]] + [loads["L"]] * (body.joint == 5)
        m = np.concatenate([m for m, _ in carried])
        r = np.concatenate([r for _, r in carried])
        com = m @ r / m.sum()
        away = r - com
        J = sum(mi * (a @ a * np.eye(3) - np.outer(a, a)) for mi, a in zip(m, away, strict=True))
        assert body.mass == pytest.approx(m.sum())
        np.testing.assert_allclose(body.com, com, rtol=1e-12)
        np.testing.assert_allclose(body.inertia, J, rtol=1e-9, atol=1e-12)


def test_an_estimate_says_whether_its_robot_could_exist() -> None:
    t = np.arange(0.0, 8.0, 0.01)
    q = np.sin(1.3 * t)[:, None]
    qd, qdd = 1.3 * np.cos(1.3 * t), -(1.3**2) * np.sin(1.3 * t)
    force = 95.0 * qdd + 20.0 * np.sign(qd) - 3.0 * qd  # friction that drives
    log = symgen.make_log("driven", t, q, force[:, None], qd[:, None])
    estimate = symgen.identify("emps", log, model="torque", method="wls")
    written = estimate.to_json()
    assert written["possible"] is False
    assert written["physical"]["distance_sigma"] > 3
    assert written["physical"]["reason"]["kind"] == "not_possible"
    assert "FV1" in written["physical"]["reason"]["text"]
