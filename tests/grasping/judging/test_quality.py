"""Force closure: closed forms, and which contacts of a run are taken for it."""

from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from handsim.grasping.judging import quality
from handsim.grasping.judging.quality import ferrari_canny, grasp_quality

X, Y, Z = np.eye(3)


def epsilon(points, normals, friction=0.5, torsion=0.0, scale=1.0, centre=(0.0, 0.0, 0.0)):
    points, normals = np.array(points, float), np.array(normals, float)
    return ferrari_canny(points, normals, friction, torsion, np.array(centre), scale)


def two_soft_fingers(friction: float, torsion: float, scale: float) -> float:
    """Epsilon of two soft fingers that oppose each other at the distance ``scale`` from the centre.

    Let both push along x, towards the centre at arms of length 1 (the scale). In the plane across,
    a tangential force t of the first has the torque -x . t, of the second x . t, so that the
    wrenches (t, torque) of the two fill two planes at right angles, in each an octagon of radius
    sqrt(2) friction. Twists give (1, 0, +-s) and (-1, 0, +-s), s = torsion / scale. The support of
    all in the direction (x, a, b, w): normal force, the two planes, twist, is at its least

        h = max(x + max(P |a|, s |w|), -x + max(P |b|, s |w|)),   P = sqrt(2) friction cos(pi/8),

    in the middle of the octagons' sides. At h = 1 the longest direction has |a| = (1 - x) / P,
    |b| = (1 + x) / P, |w| = (1 - |x|) / s, its square is convex in |x|, and so the largest of
    2/P^2 + 1/s^2 (x = 0) and 1 + 4/P^2 (x = 1); epsilon is one over its root.
    """
    side, s = np.sqrt(2) * friction * np.cos(np.pi / 8), torsion / scale
    return 1 / np.sqrt(max(2 / side**2 + 1 / s**2, 1 + 4 / side**2))


@pytest.mark.parametrize("friction", [0.3, 0.8])
@pytest.mark.parametrize("torsion", [0.002, 0.01, 0.05])
def test_two_soft_fingers_against_the_closed_form(friction, torsion):
    centre = np.array([0.1, -0.2, 0.3])
    for normal in (X, Y, -Z, np.array([2.0, -1.0, 2.0]) / 3):
        points = centre + 0.04 * np.array([-normal, normal])
        found = epsilon(points, [normal, -normal], friction, torsion, 0.04, centre)
        assert found == pytest.approx(two_soft_fingers(friction, torsion, 0.04), rel=1e-9)


@pytest.mark.parametrize("arm", [0.3, 0.9, 1.5])
@pytest.mark.parametrize("scale", [1.0, 2.5])
def test_twelve_frictionless_contacts_against_the_closed_form(arm, scale):
    """A cube with two contacts on each face, an arm from its middle towards the next axis.

    A push along axis i with an arm along the next has a torque about the third alone, so that the
    wrenches are the corners of rectangles (+-1, +-a), a = arm / scale, in three planes at right
    angles. The support of all in a direction (u, v) is max |u_i| + a |v_i|; at 1, the longest
    direction has in each plane the length max(1, 1/a): epsilon is min(1, a) / sqrt(3).
    """
    points, normals = [], []
    for i in range(3):
        for side in (-1.0, 1.0):
            for along in (-arm, arm):
                points.append(side * np.eye(3)[i] + along * np.eye(3)[(i + 1) % 3])
                normals.append(-side * np.eye(3)[i])
    expected = min(1.0, arm / scale) / np.sqrt(3)
    assert epsilon(points, normals, 0.0, scale=scale) == pytest.approx(expected, rel=1e-9)


def test_hard_fingers_that_only_oppose_each_other_leave_a_turn_free():
    assert epsilon([-X, X], [X, -X]) == pytest.approx(0.0, abs=1e-9)


def test_six_frictionless_contacts_against_the_closed_form():
    """Forces alone, along six axes: the hull is flat in the torques, so nothing is closed."""
    points = [X, -X, Y, -Y, Z, -Z]
    assert epsilon(points, [-np.array(p) for p in points], friction=0.0) == pytest.approx(0.0)


def test_without_contacts_nothing_is_held():
    assert epsilon(np.empty((0, 3)), np.empty((0, 3))) == 0.0


def test_friction_and_a_third_contact_help():
    angles = np.deg2rad([0, 120, 240])
    points = [np.array([np.cos(a), np.sin(a), 0.0]) for a in angles]
    normals = [-p for p in points]
    low, high = epsilon(points, normals, friction=0.3), epsilon(points, normals, friction=0.6)
    assert 0 < low < high
    assert high > epsilon(points[:2], normals[:2], friction=0.6)


def test_a_vanishing_twist_adds_nothing():
    """It lies in the middle of its finger's edges, with torques about the same centre."""
    angles = np.deg2rad([0, 120, 240])
    points = [np.array([np.cos(a), np.sin(a), 0.2 * np.cos(3 * a)]) for a in angles]
    normals = [-np.array([np.cos(a + 0.3), np.sin(a + 0.3), 0.0]) for a in angles]
    hard = epsilon(points, normals)
    assert hard > 0.01
    assert epsilon(points, normals, torsion=1e-9) == pytest.approx(hard, rel=1e-6)


def test_where_the_fingers_push_outwards_nothing_is_held():
    assert epsilon([X, Y, -X], [X, X, X], torsion=0.1) == 0.0
    outwards = [np.array([0.6, 0.0, 0.8]), np.array([-0.6, 0.0, 0.8]), np.array([0.0, 0.6, 0.8])]
    assert epsilon([X, Y, -X], outwards, torsion=0.1) == 0.0


def test_it_does_not_depend_on_the_frame():
    from scipy.spatial.transform import Rotation

    points = np.array([[1.0, 0, 0], [-0.5, 0.8, 0.1], [-0.5, -0.8, -0.1]])
    normals = -points / np.linalg.norm(points, axis=1)[:, None]
    turn = Rotation.from_euler("xyz", [0.0, 0.0, 90.0], degrees=True)
    one = epsilon(points, normals, torsion=0.1)
    other = epsilon(turn.apply(points), turn.apply(normals), torsion=0.1)
    assert other == pytest.approx(one, rel=0.1)  # the cones' edges turn against the contacts


RADIUS = 0.03
FRICTION, TORSION = (0.9, 0.6), (0.004, 0.007)
"""Of the two pads; the object's own are smaller, and MuJoCo takes the larger of the two."""


def squeezed(left: float, right: float) -> Any:
    """Return a run that ends with a ball on the table between a round and a flat pad.

    The pads, on bodies of their own, overlap with it by ``left`` and ``right`` [m]; MuJoCo lists
    the round pad before the ball and the flat one after it. The ball's body lies off its centre.
    """
    pads = "".join(
        f'<body pos="{x} 0 0.1"><geom type="{kind}" size="{size}" condim="4" '
        f'friction="{slide} {twist} 0.5"/></body>'
        for kind, size, x, slide, twist in (
            ("sphere", "0.01", -RADIUS - 0.01 + left, FRICTION[0], TORSION[0]),
            ("box", "0.01 0.01 0.01", RADIUS + 0.01 - right, FRICTION[1], TORSION[1]),
        )
    )
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><worldbody>
        <geom name="table" type="plane" size="1 1 1" pos="0 0 0.071" friction="2 1 1"/>
        <body name="forearm">{pads}</body>
        <body name="object" pos="0 0 0.08"><freejoint/>
          <geom type="sphere" size="{RADIUS}" pos="0 0 0.02" condim="4" friction="0.1 0.0001 0.6"/>
        </body></worldbody></mujoco>""")
    away, there = (np.array([x, 0.0, 0.08, 1.0, 0.0, 0.0, 0.0]) for x in (0.2, 0.0))
    return SimpleNamespace(
        model=lambda: model,
        qpos=np.array([away, there]),
        ctrl=np.empty((2, 0)),
        mocap_pos=np.empty((2, 0, 3)),
        mocap_quat=np.empty((2, 0, 4)),
    )


def test_a_ball_between_two_pads_against_the_closed_form():
    """Contacts lie in the middle of the overlap; the least friction of all is taken."""
    expected = two_soft_fingers(min(FRICTION), min(TORSION), RADIUS - 0.0005)
    assert grasp_quality(squeezed(0.001, 0.001)) == pytest.approx(expected, rel=1e-6)


def test_the_hand_pushes_inwards(monkeypatch):
    """Seen by what is handed on: epsilon itself is the same for a hull turned inside out."""
    handed = {}

    def keep(points, normals, **others):
        handed.update(points=points, normals=normals, **others)
        return 0.25

    monkeypatch.setattr(quality, "ferrari_canny", keep)
    assert grasp_quality(squeezed(0.001, 0.001)) == 0.25
    assert len(handed["points"]) == 2
    np.testing.assert_allclose(handed["centre"], [0.0, 0.0, 0.1], atol=1e-12)
    inwards = -np.sign(handed["points"][:, :1]) * X
    np.testing.assert_allclose(handed["normals"], inwards, atol=1e-9)


def test_torques_are_scaled_by_the_farthest_contact():
    points = [[-RADIUS + 0.0005, 0, 0], [RADIUS - 0.004, 0, 0]]
    expected = epsilon(points, [X, -X], min(FRICTION), min(TORSION), RADIUS - 0.0005)
    assert grasp_quality(squeezed(0.001, 0.008)) == pytest.approx(expected, rel=1e-6)
    assert expected != pytest.approx(
        two_soft_fingers(min(FRICTION), min(TORSION), RADIUS), rel=0.01
    )


def test_an_object_that_the_hand_does_not_touch_is_not_held():
    run = squeezed(0.001, 0.001)
    run.qpos = run.qpos[:1]
    assert grasp_quality(run) == 0.0
