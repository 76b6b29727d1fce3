import numpy as np
import pytest

from handsim.arm.arm_geometry import ArmGeometry, Seat, SegmentInertia
from handsim.errors import InputError
from handsim.types import HandSize


def test_lengths_are_parts_of_the_stature_that_the_hand_tells() -> None:
    arm = ArmGeometry(HandSize(0.108 * 1.8, 0.088))
    assert arm.stature == pytest.approx(1.8)
    assert arm.upper_arm == pytest.approx(0.186 * 1.8)
    assert arm.forearm == pytest.approx(0.146 * 1.8)
    assert arm.reach == pytest.approx(0.332 * 1.8)


def test_masses_are_parts_of_a_body_of_25_kg_a_square_metre() -> None:
    arm = ArmGeometry(HandSize(0.108 * 1.8, 0.088))
    assert arm.body_mass == pytest.approx(81.0)
    upper, fore = arm.upper_arm_inertia, arm.forearm_inertia
    assert upper.mass == pytest.approx(0.028 * 81)
    assert fore.mass == pytest.approx(0.016 * 81)
    assert upper.centre == pytest.approx(0.436 * arm.upper_arm)
    assert fore.across == pytest.approx(fore.mass * (0.303 * arm.forearm) ** 2)
    assert fore.along == pytest.approx(fore.mass**2 / (2 * np.pi * 1130 * arm.forearm))


def test_what_is_left_of_a_segment_and_its_part_make_the_whole() -> None:
    whole = SegmentInertia(1.3, 0.11, 0.008, 0.0009)
    part = SegmentInertia(0.36, 0.19, 0.0007, 0.0001)
    rest = whole.without(part)
    assert rest.mass + part.mass == pytest.approx(1.3)
    assert rest.mass * rest.centre + part.mass * part.centre == pytest.approx(1.3 * 0.11)
    about_joint = [s.across + s.mass * s.centre**2 for s in (whole, part, rest)]
    assert about_joint[1] + about_joint[2] == pytest.approx(about_joint[0])
    assert rest.along == pytest.approx(0.0008)


def test_the_shoulders_are_behind_the_table_and_as_high_as_the_upper_arm() -> None:
    right, left = (ArmGeometry(HandSize(side=side)) for side in ("right", "left"))
    x, y, z = right.shoulder()
    assert (x, z) == pytest.approx((-0.25 * right.stature, right.upper_arm))
    assert y == pytest.approx(-0.105 * right.stature)
    assert left.shoulder() == pytest.approx([x, -y, z])
    assert right.shoulder(Seat(aside=0.01))[1] == pytest.approx(y + 0.01 * right.stature)


def test_a_hand_that_cannot_be_built_has_no_arm() -> None:
    with pytest.raises(InputError, match="hand length"):
        ArmGeometry(HandSize(0.5, 0.09))
