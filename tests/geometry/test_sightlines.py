"""Lines of sight: the places where they cross surfaces, and points whose sensor is unknown."""

import numpy as np

from frontage.geometry.sightlines import SightLines

EYES = np.array([[0.0, -8.0, 1.7], [3.0, -4.0, 2.0], [np.nan] * 3, [1.0, 2.0, 1.0]])
POINTS = np.array([[2.0, 1.0, 3.7], [1.0, 4.0, 6.0], [1.0, 0.5, 2.0], [1.0, 2.0, 5.0]])


def test_a_line_crosses_the_wall_between_its_sensor_and_its_point():
    x, z = SightLines.to_points(POINTS[:2], EYES[:2]).at(0.0)
    share = -EYES[:2, 1] / (POINTS[:2, 1] - EYES[:2, 1])
    expected = EYES[:2] + share[:, None] * (POINTS[:2] - EYES[:2])
    np.testing.assert_allclose(np.column_stack([x, z]), expected[:, [0, 2]], atol=1e-12)


def test_a_point_stands_for_itself_without_a_sensor_and_beside_one():
    lines = SightLines.to_points(POINTS[2:], EYES[2:])  # unknown, and no depth to cover
    np.testing.assert_array_equal(lines.at(-3.0), POINTS[2:, [0, 2]].T)


def test_lines_that_are_moved_or_shifted_stay_the_same_lines():
    lines = SightLines.to_points(POINTS[:2], EYES[:2])
    moved = lines.moved_to(np.array([-1.0, 0.5]))
    np.testing.assert_allclose(moved.at(0.0), lines.at(0.0), atol=1e-12)
    np.testing.assert_allclose(moved.shifted(-moved.level), lines.at(0.0), atol=1e-12)
    np.testing.assert_allclose([lines.along(k, 0.0) for k in (0, 1)], lines.at(0.0), atol=1e-12)
    np.testing.assert_array_equal(lines.take(np.array([1])).place, lines.place[:, 1:2])
