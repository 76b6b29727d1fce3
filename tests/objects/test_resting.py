"""How things rest on a table."""

import numpy as np
import pytest
import trimesh

from handsim.errors import InputError
from handsim.objects.meshes.resting import resting_poses, turn_up


def corners(mesh: trimesh.Trimesh) -> np.ndarray:
    return np.array(mesh.convex_hull.vertices)


def test_a_brick_rests_on_six_sides_the_broadest_first() -> None:
    poses = resting_poses(corners(trimesh.creation.box((0.03, 0.06, 0.12))), np.zeros(3))
    assert [pose.name for pose in poses] == ["+x", "-x", "+y", "-y", "+z", "-z"]
    # From standing on the side of 60 x 120 mm over its edge of 120 mm.
    assert poses[0].rise == pytest.approx(np.hypot(0.015, 0.03) - 0.015)
    assert poses[0].tips_at_deg == pytest.approx(np.rad2deg(np.arctan2(0.03, 0.015)))


def test_ways_that_are_as_stable_come_with_the_files_own_way_up_first() -> None:
    poses = resting_poses(corners(trimesh.creation.box((0.05, 0.05, 0.05))), np.zeros(3))
    assert [pose.name for pose in poses[:2]] == ["+z", "+y"]


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_a_can_stands_whatever_the_axis_of_its_file(up: str) -> None:
    can = trimesh.creation.cylinder(0.033, 0.122, sections=48)
    turned = turn_up(up).inv().apply(corners(can))
    poses = resting_poses(turned, np.zeros(3))
    assert poses[0].name == f"+{up}"
    assert poses[0].rise == pytest.approx(np.hypot(0.033, 0.061) - 0.061, rel=0.02)


def test_the_centre_of_mass_decides() -> None:
    """A cube whose weight is at its bottom."""
    cube = corners(trimesh.creation.box((0.05, 0.05, 0.05)))
    poses = resting_poses(cube, np.array([0.0, -0.02, 0.0]))
    assert poses[0].name == "+y"
    assert len(poses) == 6


@pytest.mark.parametrize("up", ["x", "y", "z", (0.0, 0.0, -1.0), (0.6, 0.0, 0.8)])
def test_what_is_turned_up_is_up(up) -> None:
    direction = np.eye(3)["xyz".index(up)] if isinstance(up, str) else np.array(up)
    np.testing.assert_allclose(turn_up(up).apply(direction), [0, 0, 1], atol=1e-12)


def test_a_flat_cloud_rests_nowhere() -> None:
    with pytest.raises(InputError, match="flat"):
        resting_poses(np.random.default_rng(0).uniform(size=(20, 3)) * [1, 1, 0], np.zeros(3))
