import numpy as np
import pytest

from handsim.errors import InputError
from handsim.hand.anthropometry import (
    LENGTHS,
    HandGeometry,
    segment_names,
    thumb_axes,
)
from handsim.joints import FINGERS
from handsim.types import MEDIAN_HAND, HandSize


def extent(geometry: HandGeometry, names: tuple[str, ...], axis: int) -> float:
    """Size along an axis of the hand frame of the ellipsoids named, flat hand."""
    low, high = [], []
    for name in names:
        shape = geometry.ellipsoid(name)
        across = np.array([-shape.direction[1], shape.direction[0], 0.0])
        frame = np.column_stack([shape.direction, across, [0, 0, 1]])
        half = np.linalg.norm(frame[axis] * shape.semi_axes)
        centre = (shape.centre + geometry.origin_of(shape.body))[axis]
        low.append(centre - half)
        high.append(centre + half)
    return max(high) - min(low)


def test_middle_finger_ends_at_99_percent_of_the_hand_length():
    geometry = HandGeometry(HandSize(0.2, 0.09))
    along = geometry.mcp("middle")[0] + 0.2 * sum(LENGTHS["middle"])
    assert along == pytest.approx(0.99 * 0.2, abs=1e-12)
    for finger in FINGERS:
        distal = geometry.ellipsoid(segment_names(finger)[2])
        tip = distal.centre[0] + distal.semi_axes[0]
        assert tip == pytest.approx(LENGTHS[finger][2] * 0.2, abs=1e-12)


@pytest.mark.parametrize(
    ("length", "breadth", "named"),
    [
        (2.0, 0.09, "0.12 to 0.26"),
        (-1.0, 0.09, "0.12 to 0.26"),
        (float("nan"), 0.09, "0.12 to 0.26"),
        (0.119, 0.09, "0.12 to 0.26"),
        (0.19, 0.13, "0.05 to 0.12"),
        (0.19, float("inf"), "0.05 to 0.12"),
    ],
)
def test_size_outside_the_range_is_an_error_that_names_it(length, breadth, named):
    with pytest.raises(InputError, match=named):
        HandGeometry(HandSize(length, breadth))


@pytest.mark.parametrize(("length", "breadth"), [(0.12, 0.05), (0.26, 0.12), (0.12, 0.12)])
def test_ends_of_the_range_can_be_built(length, breadth):
    assert HandGeometry(HandSize(length, breadth)).mass > 0


def test_lengths_follow_hand_length_and_breadths_hand_breadth():
    small, long, broad = (
        HandGeometry(HandSize(0.13, 0.06)),
        HandGeometry(HandSize(0.26, 0.06)),
        HandGeometry(HandSize(0.13, 0.12)),
    )
    assert np.allclose(long.mcp("index"), small.mcp("index") * [2, 1, 1], rtol=1e-12)
    assert np.allclose(broad.mcp("little"), small.mcp("little") * [1, 2, 1], rtol=1e-12)
    assert np.allclose(broad.thumb_cmc, small.thumb_cmc * [1, 2, 2], rtol=1e-12)
    across = [hand.ellipsoid("ring_middle").semi_axes[1] for hand in (small, long, broad)]
    assert np.allclose(across, np.array([1, 1, 2]) * 0.091 * 0.06, rtol=1e-12)


def test_mass_is_a_hands_and_grows_with_the_cube_of_size():
    median = HandGeometry()
    assert 0.35 <= median.mass <= 0.55
    larger = HandGeometry(HandSize(1.2 * MEDIAN_HAND.length, 1.2 * MEDIAN_HAND.breadth))
    assert larger.mass == pytest.approx(1.2**3 * median.mass, rel=1e-12)


def test_breadths_agree_with_the_survey_of_whole_hands():
    """Bodyspace, men: HB 87, index 21 (PIP) and 18 (DIP), palm 33 thick; see the module."""
    hand = HandGeometry(HandSize(breadth=0.087))
    index = [2 * hand.ellipsoid(f"index_{part}").semi_axes[1] for part in ("proximal", "middle")]
    assert index == pytest.approx([0.021, 0.018], rel=0.06)
    palm = tuple(shape.name for shape in hand.ellipsoids if shape.body in ("palm", "palm_ulnar"))
    assert extent(hand, palm, axis=2) == pytest.approx(0.033, rel=0.10)
    assert extent(hand, palm, axis=1) == pytest.approx(0.087, rel=0.06)


def test_inertia_of_a_ball_is_two_fifths():
    shape = HandGeometry().ellipsoid("index_pad")
    ball = type(shape)("ball", "palm", shape.centre, np.full(3, 0.02), shape.direction)
    assert np.allclose(ball.inertia, 0.4 * ball.mass * 0.02**2, rtol=1e-12)
    assert ball.mass == pytest.approx(1100 * 4 / 3 * np.pi * 0.02**3, rel=1e-12)


def test_thumb_lies_beside_the_palm_with_its_pad_to_the_fingers():
    axes = thumb_axes()
    assert np.allclose(axes.T @ axes, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    along, pad = axes[:, 0], -axes[:, 2]
    assert along == pytest.approx([np.cos(np.pi / 6), 0.5, 0.0])
    assert pad[1] < -0.8, "faces ulnar"
    assert -0.5 < pad[2] < -0.1, "a little palmar"
    hand = HandGeometry()
    middle = hand.thumb_cmc + axes @ hand.ellipsoid("thumb_metacarpal").centre
    assert middle[1] > hand.mcp("index")[1], "radial of the index finger"
