import numpy as np
import pytest

from handsim.simulation.quality import ferrari_canny

X, Y, Z = np.eye(3)


def epsilon(points, normals, friction=0.5, torsion=0.0, scale=1.0):
    points, normals = np.array(points, float), np.array(normals, float)
    return ferrari_canny(points, normals, friction, torsion, np.zeros(3), scale)


def test_hard_fingers_that_only_oppose_each_other_leave_a_turn_free():
    assert epsilon([-X, X], [X, -X]) == pytest.approx(0.0, abs=1e-9)


def test_soft_fingers_that_oppose_each_other_close():
    assert epsilon([-X, X], [X, -X], torsion=0.3) > 0.05


def test_six_frictionless_contacts_against_the_closed_form():
    """Forces alone, along six axes: the hull is flat in the torques, so nothing is closed."""
    points = [X, -X, Y, -Y, Z, -Z]
    assert epsilon(points, [-np.array(p) for p in points], friction=0.0) == pytest.approx(0.0)


def test_friction_and_a_third_contact_help():
    angles = np.deg2rad([0, 120, 240])
    points = [np.array([np.cos(a), np.sin(a), 0.0]) for a in angles]
    normals = [-p for p in points]
    low, high = epsilon(points, normals, friction=0.3), epsilon(points, normals, friction=0.6)
    assert 0 < low < high
    assert high > epsilon(points[:2], normals[:2], friction=0.6)


def test_where_the_fingers_push_outwards_nothing_is_held():
    assert epsilon([X, Y, -X], [X, X, X], torsion=0.1) == 0.0


def test_it_does_not_depend_on_the_frame():
    from scipy.spatial.transform import Rotation

    points = np.array([[1.0, 0, 0], [-0.5, 0.8, 0.1], [-0.5, -0.8, -0.1]])
    normals = -points / np.linalg.norm(points, axis=1)[:, None]
    turn = Rotation.from_euler("xyz", [0.0, 0.0, 90.0], degrees=True)
    one = epsilon(points, normals, torsion=0.1)
    other = epsilon(turn.apply(points), turn.apply(normals), torsion=0.1)
    assert other == pytest.approx(one, rel=0.1)  # the cones' edges turn against the contacts
