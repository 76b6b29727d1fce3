import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.tasks.table_one import task_by_name
from handsim.viewing.live.table_place import TablePlace, dragged, on_plane

CUP = task_by_name("cup-drink")


def test_a_task_is_done_where_the_object_is_put() -> None:
    moved = TablePlace(30, -40, 15).of(CUP)
    assert moved.place == pytest.approx((0.03, -0.04))
    assert moved.yaw_deg == CUP.yaw_deg + 15
    assert TablePlace(10, 0, 0).of(moved).place == pytest.approx((0.04, -0.04))


def test_places_are_kept_on_the_part_of_the_table_that_is_laid_out() -> None:
    assert TablePlace(999, -999, 400).within() == TablePlace(150, -200, 90)
    assert TablePlace(1.4, -2.6, 3.5).within() == TablePlace(1, -3, 4)


def test_the_pose_turns_about_the_vertical_and_keeps_its_height() -> None:
    lying = Rotation.from_euler("x", 90, degrees=True)
    pose = np.array([0.01, 0.02, 0.03, *lying.as_quat(scalar_first=True)])
    moved = TablePlace(100, -50, 90).moved_pose(pose)
    np.testing.assert_allclose(moved[:3], [0.11, -0.03, 0.03])
    turned = Rotation.from_quat(moved[3:], scalar_first=True)
    expected = Rotation.from_euler("z", 90, degrees=True) * lying
    assert (turned * expected.inv()).magnitude() == pytest.approx(0, abs=1e-12)


def test_the_pointer_meets_the_table() -> None:
    camera = np.array([0.0, 0.0, 1.0])
    met = on_plane(camera, np.array([0.1, 0.2, 0.5]), 0.0)
    np.testing.assert_allclose(met, [0.2, 0.4, 0.0])
    assert on_plane(camera, np.array([0.1, 0.0, 1.5]), 0.0) is None, "above the horizon"
    assert on_plane(camera, np.array([0.1, 0.0, 1.0]), 0.0) is None


def test_dragging_moves_and_turns() -> None:
    middle, grabbed = np.array([0.1, 0.0, 0.0]), np.array([0.12, 0.0, 0.05])
    place = TablePlace(100, 0, 0)
    moved = dragged(place, middle, grabbed, np.array([0.10, 0.03, 0.05]), turning=False)
    assert moved == TablePlace(80, 30, 0)
    turned = dragged(place, middle, grabbed, np.array([0.1, 0.02, 0.05]), turning=True)
    assert turned == TablePlace(100, 0, 90)
    east, north = np.array([0.15, 0.0, 0.0]), np.array([0.1, 0.05, 0.0])
    back = dragged(TablePlace(100, 0, 80), middle, north, east, turning=True)
    assert back == TablePlace(100, 0, -10)
    across = dragged(
        TablePlace(), np.zeros(3), np.array([-1, 0.1, 0]), np.array([-1, -0.1, 0]), turning=True
    )
    assert across.turn == pytest.approx(11)
