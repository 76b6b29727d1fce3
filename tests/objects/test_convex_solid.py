"""Lines through solids of convex pieces."""

import numpy as np
import pytest

from handsim.objects.convex_solid import ConvexSolid
from handsim.objects.mjcf import OBJECTS
from handsim.objects.object import Collider

from .shapes import box

X = np.array([[1.0, 0.0, 0.0]])


def boxes(*parts) -> ConvexSolid:
    return ConvexSolid.of_hulls([part.vertices for part in parts])


def test_a_line_through_two_walls() -> None:
    solid = boxes(box(0.01, 0.1, 0.1, (-0.04, 0, 0)), box(0.02, 0.1, 0.1, (0.04, 0, 0)))
    spans = solid.spans(np.array([[-1.0, 0.0, 0.0], [-1.0, 0.06, 0.0]]), np.repeat(X, 2, axis=0))
    np.testing.assert_array_equal(spans.line, [0, 0])  # the second line passes by
    np.testing.assert_allclose(spans.enter, [0.955, 1.03])
    np.testing.assert_allclose(spans.leave, [0.965, 1.05])
    np.testing.assert_allclose(spans.normal_in, [[-1, 0, 0]] * 2, atol=1e-9)
    np.testing.assert_allclose(spans.normal_out, [[1, 0, 0]] * 2, atol=1e-9)
    np.testing.assert_allclose(spans.room_before, [np.inf, 0.065])
    np.testing.assert_allclose(spans.room_after, [0.065, np.inf])


def test_pieces_that_overlap_or_touch_are_one_stretch() -> None:
    nested = box(0.002, 0.1, 0.1, (0.0, 0, 0))
    solid = boxes(box(0.04, 0.1, 0.1), nested, box(0.02, 0.1, 0.1, (0.0301, 0, 0)))
    spans = solid.spans(np.array([[-1.0, 0.0, 0.0]]), X)
    np.testing.assert_allclose([spans.enter, spans.leave], [[0.98], [1.0401]])
    np.testing.assert_allclose(spans.normal_out, [[1, 0, 0]], atol=1e-9)


@pytest.mark.parametrize("name", sorted(OBJECTS))
def test_stretches_and_points_inside_agree(name: str) -> None:
    solid = ConvexSolid.of(OBJECTS[name])
    rng = np.random.default_rng(0)
    starts = solid.points.mean(axis=0) + rng.normal(0, 0.03, (200, 3))
    directions = rng.normal(size=(200, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    spans = solid.spans(starts, directions)
    assert (spans.leave > spans.enter).all()
    around = np.zeros(200, dtype=bool)
    around[spans.line[(spans.enter < 0) & (spans.leave > 0)]] = True
    np.testing.assert_array_equal(solid.contains(starts), around)


@pytest.mark.parametrize(
    ("collider", "reach"),
    [
        (Collider("cylinder", (0.02, 0.05), pos=(0, 0, 0.1)), (0.02, 0.02, 0.05)),
        (Collider("capsule", (0.02, 0.05), pos=(0, 0, 0.1)), (0.02, 0.02, 0.07)),
        (Collider("sphere", (0.02,), pos=(0, 0, 0.1)), (0.02, 0.02, 0.02)),
        (Collider("box", (0.02, 0.03, 0.05), pos=(0, 0, 0.1)), (0.02, 0.03, 0.05)),
        (Collider("box", (0.02, 0.03, 0.05), (0, 0, 0.1), (0.5**0.5, 0, 0, 0.5**0.5)),
         (0.03, 0.02, 0.05)),
    ],
)  # fmt: skip
def test_primitives_reach_as_far_as_mujocos(collider: Collider, reach: tuple) -> None:
    from handsim.objects.convex_solid import corners

    solid = ConvexSolid.of_hulls([corners(collider)])
    middle = np.tile([0.0, 0.0, 0.1], (3, 1))
    spans = solid.spans(middle, np.eye(3))
    np.testing.assert_allclose(spans.leave, reach, rtol=0.02)
