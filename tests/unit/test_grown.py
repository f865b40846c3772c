"""A gap that grows on validation data speaks against an effect where it can be seen, in squares."""

from __future__ import annotations

from symgen.estimation.floor import grown

LEAST = 0.008


def test_a_gap_grows_where_its_squares_differ_by_what_matters() -> None:
    # 20 % to 20.1 %: a new error of 2 % of the joint's torque.
    assert grown([0.2, 0.2], [0.201, 0.2001], [0.0, 0.0], LEAST) == [True, False]


def test_a_joint_with_hardly_any_torque_but_noise_has_no_say() -> None:
    assert grown([0.8], [0.9], [0.7], LEAST) == [False]
