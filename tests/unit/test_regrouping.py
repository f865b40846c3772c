"""Base parameters as programs: from standard ones, and with a body on a link, by point masses."""

from __future__ import annotations

import numpy as np
import pytest
from oracles.transforms import LINK_PARAMETERS

import symgen
from symgen.symbolic.regrouping import add_body_tape, base_parameters_tape
from symgen.symbolic.sampling import FUNCTIONS
from symgen.symbolic.tape import Numbers

ROBOT = """
[robot]
name = "arm"
gravity = [0.0, -9.81, 0.0]
[geometry]
L1 = 0.4
[[joint]]
friction = ["viscous", "offset"]
[[joint]]
d = "L1"
alpha = "pi/3"
friction = ["coulomb"]
[[joint]]
sigma = 1
alpha = 0.4
d = "2*L1 + 0.1"
"""
MODEL = symgen.derive(symgen.parse_robot(ROBOT), ())
VALUES = MODEL.robot.values()


def _base(values: dict[str, float]) -> np.ndarray:
    """Regroup by the formulas that the model prints."""
    out = []
    for p in MODEL.base.parameters:
        joined = sum(float(c.subs(VALUES)) * values[name] for c, name in p.terms)
        out.append(values[p.head] + joined)
    return np.array(out)


def _run(tape, **inputs) -> np.ndarray:
    given = {k: [np.array([float(v)]) for v in values] for k, values in inputs.items()}
    out = tape.run(Numbers(VALUES, FUNCTIONS), given)
    return np.array([float(np.asarray(v).ravel()[0]) for v in out])


def test_standard_parameters_regroup_by_the_printed_formulas() -> None:
    assert any(p.terms for p in MODEL.base.parameters)
    names = [p.name for p in MODEL.base.standard]
    draw = np.random.default_rng(1)
    for _ in range(3):
        values = dict(zip(names, draw.normal(size=len(names)), strict=True))
        found = _run(base_parameters_tape(MODEL.robot, MODEL.base), standard=values.values())
        np.testing.assert_allclose(found, _base(values), rtol=1e-12)


@pytest.mark.parametrize("link", [1, 2, 3])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_body_on_a_link_is_its_points_among_those_of_the_link(link: int, sign: float) -> None:
    """Mass points of the body about the link's frame; given by its centre and its own inertia."""
    draw = np.random.default_rng(link)
    points, masses = draw.normal(size=(8, 3)), sign * draw.uniform(0.5, 2, 8)
    mass = masses.sum()
    com = masses @ points / mass

    def inertia(at: np.ndarray) -> np.ndarray:
        return sum(
            m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, at, strict=True)
        )

    own = inertia(points - com)[np.triu_indices(3)]
    about = inertia(points)[np.triu_indices(3)]
    names = [p.name for p in MODEL.base.standard]
    before = dict(zip(names, draw.normal(size=len(names)), strict=True))
    ten = dict(zip(LINK_PARAMETERS, [*about, *(mass * com), mass], strict=True))
    after = {
        k: v + (ten.get(k[:-1], 0.0) if k[-1] == str(link) else 0.0) for k, v in before.items()
    }
    at = [float(k == link) for k in (1, 2, 3)]
    found = _run(
        add_body_tape(MODEL.robot, MODEL.base),
        X=_base(before), link=at, mass=[mass], com=com, inertia=own,
    )  # fmt: skip
    np.testing.assert_allclose(found, _base(after), rtol=1e-10, atol=1e-12)
    assert np.abs(found - _base(before)).max() > 0.1


@pytest.mark.parametrize("tape", [base_parameters_tape, add_body_tape])
def test_steps_have_names_that_c_takes_and_each_has_its_own(tape) -> None:
    found = [symbol.name for symbol, _ in tape(MODEL.robot, MODEL.base).steps]
    assert found
    assert [name for name in found if not (name.isidentifier() and name.isascii())] == []
    assert len(set(found)) == len(found)
