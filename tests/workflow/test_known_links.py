"""Known masses and boxes of links: what they leave, the closest links, and what cannot be."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

import symgen
from symgen import names
from symgen.identification.physical import box_fact, mass_fact

#: planar2r: a mass M2 with ZZ2 M2 > MX2^2 + MY2^2 and L1^2 M2 < ZZ1R must exist.
POSSIBLE = np.array([1.702, 0.05644, 0.15, 0.075])
L1 = 0.5
FILE = {"XX1": 0.1, "YY1": 0.5, "ZZ1": 0.5, "MX1": 1.0, "M1": 4.0,
        "XX2": 0.05, "YY2": 0.06, "ZZ2": 0.056, "MX2": 0.15, "MY2": 0.07, "M2": 1.0}  # fmt: skip
TWO = [f"{prefix}{link}" for link in (1, 2) for prefix in names.LINK]


@pytest.fixture(scope="module")
def planar() -> symgen.Model:
    return symgen.derive(symgen.read_robot("planar2r"))


def density(links: np.ndarray) -> np.ndarray:
    """Pseudo-inertias (2, 4, 4) of two links of ten parameters each."""
    out = []
    for xx, xy, xz, yy, yz, zz, mx, my, mz, m in links.reshape(2, 10):
        out.append([[(yy + zz - xx) / 2, -xy, -xz, mx], [-xy, (xx + zz - yy) / 2, -yz, my],
                    [-xz, -yz, (xx + yy - zz) / 2, mz], [mx, my, mz, m]])  # fmt: skip
    return np.array(out)


def by_slsqp(equal, least) -> np.ndarray:
    """The links of planar2r closest to FILE that give POSSIBLE and meet constraints."""
    prior = np.array([FILE.get(name, 0.0) for name in TWO])
    inverse = np.linalg.inv(density(prior))
    at = {name: i for i, name in enumerate(TWO)}

    def divergence(x: np.ndarray) -> float:
        P = density(x)
        if (np.linalg.eigvalsh(P) <= 0).any():
            return 1e6
        return float(np.einsum("lab,lba->", inverse, P) - np.linalg.slogdet(P)[1].sum())

    units = np.array([density(unit) for unit in np.eye(20)])

    def slope(x: np.ndarray) -> np.ndarray:
        return np.einsum("lab,klba->k", inverse - np.linalg.inv(density(x)), units)

    def base(x: np.ndarray) -> np.ndarray:
        ends = [x[at[name]] for name in ("ZZ2", "MX2", "MY2")]
        return np.array([x[at["ZZ1"]] + L1**2 * x[at["M2"]], *ends]) - POSSIBLE

    start = prior.copy()
    start[at["ZZ1"]] = POSSIBLE[0] - L1**2 * start[at["M2"]]
    start[at["YY1"]] = start[at["ZZ1"]]
    constraints = [{"type": "eq", "fun": base}]
    if equal:
        constraints.append({"type": "eq", "fun": lambda x: equal(dict(zip(TWO, x, strict=True)))})
    if least:
        constraints.append({"type": "ineq", "fun": lambda x: least(dict(zip(TWO, x, strict=True)))})
    found = minimize(divergence, start, jac=slope, method="SLSQP", constraints=constraints,
                     options={"maxiter": 2000, "ftol": 1e-12})  # fmt: skip
    assert found.success, found.message
    return found.x


LOW, HIGH = np.array([0.0, -0.05, -0.1]), np.array([0.45, 0.2, 0.1])


def inside(v) -> np.ndarray:
    """Integrals of (x - low)(high - x) dm of link 2 along the three axes."""
    second = [(v["YY2"] + v["ZZ2"] - v["XX2"]) / 2, (v["XX2"] + v["ZZ2"] - v["YY2"]) / 2,
              (v["XX2"] + v["YY2"] - v["ZZ2"]) / 2]  # fmt: skip
    first = [v["MX2"], v["MY2"], v["MZ2"]]
    return -np.array(second) + (LOW + HIGH) * first - LOW * HIGH * v["M2"]


CASES = {
    "nothing": ((), None, None),
    "mass": ((mass_fact("arm", ["2"], 1.5),), lambda v: v["M2"] - 1.5, None),
    "box": ((box_fact("arm", {"2": np.eye(4)}, LOW, HIGH),), None, inside),
    "both": (
        (mass_fact("arm", ["2"], 0.8), box_fact("arm", {"2": np.eye(4)}, LOW, HIGH)),
        lambda v: v["M2"] - 0.8,
        inside,
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_the_closest_links_are_those_of_another_solver(planar, case) -> None:
    facts, equal, least = CASES[case]
    found = symgen.link_parameters(planar, POSSIBLE, prior=dict.fromkeys(TWO, 0.0) | FILE,
                                   facts=facts).values  # fmt: skip
    ours = np.array([found[name] for name in TWO])
    np.testing.assert_allclose(ours, by_slsqp(equal, least), rtol=0, atol=2e-4)
    if equal:
        assert equal(found) == pytest.approx(0, abs=1e-9)
    if least:
        assert least(found).min() > -1e-7


def test_a_box_in_another_frame_is_the_same_box(planar) -> None:
    """The link's frame is turned by 90 degrees about z and moved: x' = -y + 0.3, y' = x, z' = z."""
    pose = np.array([[0, -1, 0, 0.3], [1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])
    low, high = (
        np.array([0.3 - HIGH[1], LOW[0], LOW[2]]),
        np.array([0.3 - LOW[1], HIGH[0], HIGH[2]]),
    )
    here, there = (
        symgen.link_parameters(planar, POSSIBLE, prior=FILE, facts=[fact]).values
        for fact in (
            box_fact("arm", {"2": np.eye(4)}, LOW, HIGH), box_fact("arm", {"2": pose}, low, high),
        )
    )  # fmt: skip
    for name, value in here.items():
        assert there[name] == pytest.approx(value, abs=1e-7), name


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_the_masses_that_can_be_are_those_of_the_closed_form(planar, share: float) -> None:
    ZZ1R, ZZ2, MX2, MY2 = POSSIBLE
    least, most = (MX2**2 + MY2**2) / ZZ2, ZZ1R / L1**2
    for limit, inward in ((least, share > 1), (most, share < 1)):
        fact = mass_fact("link arm", ["2"], share * limit)
        if inward:
            found = symgen.link_parameters(planar, POSSIBLE, prior=FILE, facts=[fact]).values
            assert found["M2"] == pytest.approx(share * limit)
        else:
            told = f"at least {least:.3g} kg and at most {most:.3g} kg"
            with pytest.raises(symgen.ParameterError, match=rf"link arm: a mass of .*{told}"):
                symgen.link_parameters(planar, POSSIBLE, facts=[fact])


def test_what_cannot_be_is_said_by_link(planar) -> None:
    thin = box_fact("link arm", {"2": np.eye(4)}, LOW, np.array([0.01, 0.2, 0.1]))
    fine = mass_fact("link upper", ["1"], 3.0)
    with pytest.raises(symgen.ParameterError, match=r"cannot be: link arm: a box from \(0, -0.05"):
        symgen.link_parameters(planar, POSSIBLE, facts=[thin, fine])
    # Each is possible, and not both: MX2 puts the centre of so large a mass outside the box.
    box = box_fact("link arm", {"2": np.eye(4)}, np.array([0.05, -0.05, -0.1]), HIGH)
    heavy = mass_fact("link arm", ["2"], 6.0)
    for fact in (box, heavy):
        symgen.link_parameters(planar, POSSIBLE, facts=[fact])
    both = r"cannot be together: link arm: a box [^;]*; link arm: a mass of 6 kg;"
    with pytest.raises(symgen.ParameterError, match=both):
        symgen.link_parameters(planar, POSSIBLE, facts=[box, fine, heavy])


def test_X_moves_for_a_fact_as_little_as_it_can(planar) -> None:
    """With one uncertain entry, MX2 falls until the mass has room: M2 ZZ2 = MX2^2 + MY2^2."""
    std = np.array([1e-4, 1e-4, 0.05, 1e-4])
    fact = mass_fact("link arm", ["2"], 0.45)
    found = symgen.link_parameters(planar, POSSIBLE, nearest=np.diag(std**2), facts=[fact])
    assert found.values["M2"] == pytest.approx(0.45)
    edge = np.sqrt(0.45 * POSSIBLE[1] - POSSIBLE[3] ** 2)
    assert 0.99 * edge < found.X[2] <= edge  # a link at the edge would be a rod
    assert found.sigmas == pytest.approx((POSSIBLE[2] - found.X[2]) / std[2], rel=0.01)
