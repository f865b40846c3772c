"""Rest and saturation are found where they are, and no equation touches them."""

import numpy as np

from symgen.data.mask import on_grid, saturated

STEP = 0.002
T = np.arange(0, 10, STEP)
MOVING = np.sin(2 * np.pi * 0.5 * T)


def test_a_saturated_motor_concerns_every_joint_that_it_moves():
    ratio = np.array([[100.0, 0.0], [3.0, 50.0]])  # motor 2 moves both joints
    motors = np.column_stack([MOVING, np.clip(2 * MOVING, -1, 1)])
    at = np.abs(MOVING) >= 0.5
    flags = saturated(motors @ ratio, None, ratio)
    np.testing.assert_array_equal(flags, np.column_stack([at, at]))
    motors = motors[:, ::-1]
    flags = saturated(motors @ ratio, None, ratio)
    np.testing.assert_array_equal(flags, np.column_stack([at, 0 * at]))


def test_a_sample_of_the_grid_is_masked_when_a_neighbour_was():
    t, grid = np.array([0.0, 1.0, 2.2, 3.0, 4.0]), np.linspace(0, 4, 5)
    masked = np.array([[0], [0], [1], [0], [0]], dtype=bool)
    np.testing.assert_array_equal(on_grid(masked, t, grid)[:, 0], [0, 0, 1, 1, 0])
    np.testing.assert_array_equal(on_grid(masked, t, t), masked)
