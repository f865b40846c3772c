"""Rest and saturation are found where they are, and no equation touches them."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from symgen.data.mask import Mask, on_grid, saturated, untouched

STEP = 0.002
T = np.arange(0, 10, STEP)
MOVING = np.sin(2 * np.pi * 0.5 * T)


def test_a_torque_is_saturated_at_its_limit_and_where_it_is_stuck():
    tau = 10 * MOVING
    cut = np.clip(tau, -8, 8)
    expected = np.abs(tau) >= 8
    np.testing.assert_array_equal(saturated(cut[:, None], None, None)[:, 0], expected)
    np.testing.assert_array_equal(saturated(tau[:, None], [8 / 0.999], None)[:, 0], expected)
    assert not saturated(tau[:, None], None, None).any()


def test_a_saturated_motor_concerns_every_joint_that_it_moves():
    ratio = np.array([[100.0, 0.0], [3.0, 50.0]])  # motor 2 moves both joints
    motors = np.column_stack([MOVING, np.clip(2 * MOVING, -1, 1)])
    at = np.abs(MOVING) >= 0.5
    flags = saturated(motors @ ratio, None, ratio)
    np.testing.assert_array_equal(flags, np.column_stack([at, at]))
    motors = motors[:, ::-1]
    flags = saturated(motors @ ratio, None, ratio)
    np.testing.assert_array_equal(flags, np.column_stack([at, 0 * at]))


@given(bits=st.lists(st.booleans(), min_size=12, max_size=40), steps=st.integers(1, 9))
@settings(max_examples=100, deadline=None)
def test_a_window_is_untouched_when_none_of_its_samples_is_masked(bits, steps):
    masked = np.array(bits)
    last = np.arange(steps, len(masked))
    expected = [not masked[k - steps : k + 1].any() for k in last]
    np.testing.assert_array_equal(untouched(masked, last - steps, last), expected)


@given(bits=st.lists(st.booleans(), min_size=5, max_size=40), reach=st.integers(0, 9))
@settings(max_examples=100, deadline=None)
def test_a_filter_carries_a_mask_as_far_as_it_reaches(bits, reach):
    masked = np.array(bits)
    expected = [masked[max(k - reach, 0) : k + reach + 1].any() for k in range(len(masked))]
    near = Mask(masked[:, None], masked).near(reach)
    np.testing.assert_array_equal(near[:, 0], expected)


def test_a_sample_of_the_grid_is_masked_when_a_neighbour_was():
    t, grid = np.array([0.0, 1.0, 2.2, 3.0, 4.0]), np.linspace(0, 4, 5)
    masked = np.array([[0], [0], [1], [0], [0]], dtype=bool)
    np.testing.assert_array_equal(on_grid(masked, t, grid)[:, 0], [0, 0, 1, 1, 0])
    np.testing.assert_array_equal(on_grid(masked, t, t), masked)
