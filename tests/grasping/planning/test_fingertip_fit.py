from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.grasping.gripping.squeeze import squeeze_offset
from handsim.grasping.plan import GraspPlan, Pose
from handsim.grasping.planning import fingertip_fit
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.planning.fingertip_fit import FingertipFit, fit_fingertips, pad_targets
from handsim.grasping.planning.opposition import palm_pose
from handsim.grasping.planning.preshapes import preshape_for
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import FINGERS, JOINT_INDEX, LOWER, UPPER, clip_to_range
from handsim.tasks.table_one import task_by_name

TASK = task_by_name("cube-raise")


class Line:
    """A subspace of one component: the way from a preshape's open to its shut posture."""

    def __init__(self):
        preshape = preshape_for(TASK.grasp)
        self.origin, self.way = preshape.open, preshape.shut - preshape.open

    def transform(self, q):
        return np.array([(q - self.origin) @ self.way / (self.way @ self.way)])

    def inverse_transform(self, z):
        return self.origin + z[0] * self.way


@pytest.fixture(scope="module")
def hand():
    return HandModel.from_spec(build_hand())


def test_targets_are_the_pads_of_the_script(hand):
    plan, _ = scripted_plan(TASK, hand)
    targets = pad_targets(hand, plan, TASK.grasp)
    away = (targets.pos - np.array(TASK.grasp.point)) @ np.array(TASK.grasp.opposition)
    assert away[0] < 0 < away[1]  # thumb and fingers on either side
    np.testing.assert_allclose(targets.outward[0], -targets.outward[1])
    assert targets.weight[4] < targets.weight[1]  # the little finger does not take part


def test_a_subspace_that_holds_the_scripted_grasp_is_led_back_to_it(hand):
    """From a wrong start the fit finds coordinates and palm near the script's own."""
    plan, _ = scripted_plan(TASK, hand)
    line = Line()
    wanted = line.transform(plan.q_goal)
    box = (np.array([0.0]), np.array([1.2]))
    placed = fit_fingertips(hand, line, pad_targets(hand, plan, TASK.grasp), wanted - 0.3, box)
    assert placed.z[0] == pytest.approx(wanted[0], abs=0.12)
    assert np.linalg.norm(placed.palm.pos - plan.palm.pos) < 0.012
    worse = fit_fingertips(
        hand, line, pad_targets(hand, plan, TASK.grasp), wanted, (box[0], box[0] + 0.1)
    )
    assert worse.error > placed.error
    assert worse.z[0] <= 0.1


def test_a_lever_between_thumb_and_fingers_is_taken_away_where_it_counts(hand):
    """A thumb turned aside pushes past the fingers; with weight on it, the palm makes up for it."""
    task = task_by_name("pen-move")
    plan, _ = scripted_plan(task, hand)
    targets = pad_targets(hand, plan, task.grasp)
    aside = np.zeros(22)
    aside[JOINT_INDEX["thumb_rotation"]] = np.deg2rad(-25.0)

    class Askew(Line):
        def __init__(self):
            preshape = preshape_for(task.grasp)
            self.origin, self.way = preshape.open + aside, preshape.shut - preshape.open

    line, box = Askew(), (np.array([0.0]), np.array([1.2]))
    start = line.transform(plan.q_goal)
    levers = []
    for weight in (0.0, 5.0):
        placed = fit_fingertips(hand, line, targets, start, box, weight)
        closed = line.inverse_transform(placed.z)
        closed = closed + placed.squeeze * squeeze_offset(1.0, task.grasp.fingers)
        hand.set_posture(clip_to_range(closed))
        pads = targets.opposing @ hand.pads()[0]
        turn = placed.palm.rotation * palm_pose(hand).rotation.inv()
        wanted = targets.opposing @ targets.pos
        levers.append(np.linalg.norm(targets.axes[1:] @ (turn.apply(pads) - wanted)))
    assert levers[1] < 0.5 * levers[0]


# What follows is weighed in closed form: a hand with its pads on the line of opposition, each of
# which a radian of its finger's base brings 50 mm nearer to the middle.

INWARD, HALF = 0.05, 0.03
BASES = [JOINT_INDEX[f"{finger}_mcp"] for finger in FINGERS]
AXES = Rotation.from_euler("xyz", [25, -40, 70], degrees=True).as_matrix().T
"""Opposition, approach and across both, object frame."""
GRASP = replace(
    TASK.grasp,
    opposition=tuple(AXES[0]),
    approach=tuple(AXES[1]),
    fingers=("index", "middle", "ring", "little"),
)
PALM = Pose(
    np.array([0.1, -0.2, 0.05]),
    Rotation.from_euler("xyz", [-15, 35, 5], degrees=True).as_quat(scalar_first=True),
)
BENT = np.where(np.isin(np.arange(22), BASES), 0.3, 0.0)
PLAN = GraspPlan(PALM, np.zeros(3), np.zeros(22), BENT)
PRESSED_BY = INWARD * np.deg2rad([10, 12, 12, 12, 12])
"""How far a squeeze of strength 1 takes the pads inward [m]."""
OUTWARD = np.array([-1.0, 1, 1, 1, 1])
SHIFT, TURN = slice(1, 4), slice(4, 7)


class Sliding:
    """A hand of such pads, somewhere in the world; a bent base may sink its pad as well."""

    def __init__(self, sink: float = 0.0):
        self.sink, self.axes = sink, PALM.rotation.inv().apply(AXES)
        self.palm = Pose(np.array([0.7, 0.3, -0.4]), np.array([0.5, -0.5, 0.5, 0.5]))
        body = SimpleNamespace(xpos=self.palm.pos, xquat=self.palm.quat)
        self.data = SimpleNamespace(body=lambda name: {"palm": body}[name])

    def pose(self, q):
        self.bent = q[BASES]

    def pads(self):
        along = OUTWARD * (HALF - INWARD * self.bent)
        pos = np.outer(along, self.axes[0]) + np.outer(self.sink * self.bent, self.axes[1])
        turn = self.palm.rotation
        return self.palm.pos + turn.apply(pos), turn.apply(np.outer(-OUTWARD, self.axes[0]))


class Bases:
    """A subspace of one component that bends all bases."""

    def inverse_transform(self, z):
        return BENT + z[0] * (BENT > 0)


SCRIPT = np.zeros(8)


@pytest.fixture
def weigh(monkeypatch):
    """Weigh one point (z, shift, turn, squeeze) instead of searching for the lightest."""

    def weigh(
        point=SCRIPT, sink=0.0, lever=0.0, grasp=GRASP, plan=PLAN, z_start=None, **changed
    ) -> FingertipFit:
        hand = Sliding(sink)
        targets = replace(pad_targets(hand, plan, grasp), **changed)

        def here(residuals, start, **_):
            weigh.start = start
            return SimpleNamespace(x=point, fun=residuals(point))

        monkeypatch.setattr(fingertip_fit, "least_squares", here)
        start = point[:1] if z_start is None else np.array([z_start])
        return fit_fingertips(
            hand, Bases(), targets, start, (np.array([-1.0]), np.array([1.0])), lever
        )

    return weigh


def point(z=0.0, shift=(0, 0, 0), turn=(0, 0, 0), squeeze=0.0):
    """A point to weigh, shift and turn along opposition, approach and across both."""
    return np.array([z, *(shift @ AXES), *(turn @ AXES), squeeze])


def root(*parts) -> object:
    return pytest.approx(float(np.sqrt(np.sum(np.square(np.hstack(parts))))), rel=1e-9, abs=1e-12)


def test_targets_are_where_the_script_has_the_pads():
    grasp = replace(GRASP, fingers=("index", "ring"))
    targets = pad_targets(Sliding(), PLAN, grasp)
    away = OUTWARD * (HALF - INWARD * 0.3)
    np.testing.assert_allclose(targets.pos, PALM.pos + np.outer(away, AXES[0]), atol=1e-12)
    np.testing.assert_allclose(targets.normal, np.outer(-OUTWARD, AXES[0]), atol=1e-12)
    np.testing.assert_allclose(targets.outward, np.outer(OUTWARD, AXES[0]), atol=1e-12)
    np.testing.assert_allclose(targets.axes, AXES, atol=1e-12)
    np.testing.assert_allclose(targets.weight**2, [1, 1, 0.05, 1, 0.05])
    np.testing.assert_allclose(targets.opposing, [1, -0.5, 0, -0.5, 0])


def test_the_script_itself_weighs_nothing(weigh):
    placed = weigh()
    assert placed.error == pytest.approx(0.0, abs=1e-12)
    assert placed.squeeze == 1.0
    np.testing.assert_allclose(placed.palm.pos, PALM.pos)


def test_a_displaced_palm_weighs_by_direction(weigh):
    for way in (-0.01, 0.01):
        assert weigh(point(shift=(0, way, 0))).error == root(np.full(5, 0.6 * way))
        assert weigh(point(shift=(0, 0, way))).error == root(np.full(5, 0.25 * way))
    # Along the opposition the thumb is too near by 3 mm, and the fingers are too wide.
    assert weigh(point(shift=(0.003, 0, 0))).error == root(0.003, np.full(4, 0.3 * 0.003))


def test_a_narrow_hand_weighs_more_than_a_wide_one(weigh):
    assert weigh(point(z=0.05)).error == root(np.full(5, 0.0025))
    assert weigh(point(z=-0.05)).error == root(np.full(5, 0.3 * 0.0025))


def test_a_wide_hand_has_to_press_six_millimetres_beyond(weigh):
    lacking = np.maximum(0.01 - PRESSED_BY + 0.006, 0.0)
    assert (lacking > 0.005).all()
    assert weigh(point(z=-0.2)).error == root(np.full(5, 0.3 * 0.01), lacking)


def test_a_weak_squeeze_lacks_pressure(weigh):
    placed = weigh(point(squeeze=-0.6))
    assert placed.squeeze == pytest.approx(0.4)
    assert placed.error == root(0.006 - 0.4 * PRESSED_BY, 0.002 * 0.6)
    assert weigh(point(squeeze=0.6)).error == root(0.002 * 0.6)  # more than enough is no fault


def test_joints_stay_within_their_ranges_before_and_after_the_squeeze(weigh):
    upper = UPPER[BASES]
    plan = replace(PLAN, q_goal=np.where(BENT > 0, UPPER, 0.0))
    after = np.minimum(1.2 + np.deg2rad([10, 12, 12, 12, 12]), upper)  # stops the thumb
    lacking = INWARD * (upper - after) + 0.006
    wide = INWARD * (upper - 1.2)
    assert weigh(point(z=0.9), plan=plan).error == root(0.3 * wide, np.maximum(lacking, 0.0))
    wide = INWARD * (0.3 - LOWER[BASES])  # asked for are 40 deg below zero
    lacking = wide - PRESSED_BY + 0.006
    assert weigh(point(z=-1.0)).error == root(0.3 * wide, lacking)


def test_idle_fingers_weigh_little_and_are_not_squeezed(weigh):
    grasp = replace(GRASP, fingers=("index", "middle"))
    idle = np.sqrt(0.05) * np.full(2, 0.006)
    assert weigh(grasp=grasp).error == root(idle)
    moved = 0.01 * 0.6 * np.sqrt([1, 1, 1, 0.05, 0.05])
    assert weigh(point(shift=(0, 0.01, 0)), grasp=grasp).error == root(idle, moved)


def test_askew_pads_weigh_by_their_direction(weigh):
    normal = pad_targets(Sliding(), PLAN, GRASP).normal
    for axis in AXES:
        assert weigh(normal=normal + 0.5 * axis).error == root(np.full(5, 0.006 * 0.5))


def test_what_is_away_from_the_record_and_the_script_weighs(weigh):
    assert weigh(z_start=0.5).error == root(0.003 * 0.5)
    # About the line on which the pads are: nothing else moves.
    assert weigh(point(turn=(0.2, 0, 0))).error == root(0.008 * 0.2)


def test_what_is_aside_counts_by_the_mean_of_before_and_after_the_squeeze(weigh):
    sunk = 0.02 * np.deg2rad([10, 12, 12, 12, 12])
    assert weigh(sink=0.02).error == root(0.6 * sunk / 2)
    apart = sunk[0] - sunk[1:].mean()
    assert weigh(sink=0.02, lever=3.0).error == root(0.6 * sunk / 2, 3.0 * apart)


def test_a_lever_is_what_lies_between_thumb_and_fingers_across(weigh):
    pos = pad_targets(Sliding(), PLAN, GRASP).pos
    for axis, weight in ((1, 0.6), (2, 0.25)):
        thumb, finger = pos.copy(), pos.copy()
        thumb[0] += 0.004 * AXES[axis]
        finger[2] += 0.004 * AXES[axis]
        aside = weight * 0.004
        assert weigh(pos=thumb, lever=2.0).error == root(aside, 2.0 * 0.004)
        assert weigh(pos=finger, lever=2.0).error == root(aside, 2.0 * 0.004 / 4)
        assert weigh(pos=thumb).error == root(aside)
    # All together, or along the opposition, turns nothing.
    all_aside = weigh(pos=pos + 0.004 * AXES[1], lever=2.0)
    assert all_aside.error == root(np.full(5, 0.6 * 0.004))
    wide = pos.copy()
    wide[0] += 0.001 * AXES[0]
    assert weigh(pos=wide, lever=2.0).error == root(0.3 * 0.001)


def test_what_is_found_stays_within_its_limits(weigh):
    plan = replace(PLAN, squeeze=0.8)
    assert weigh(point(squeeze=0.4), plan=plan).squeeze == pytest.approx(1.2)
    assert weigh(point(squeeze=9.0)).squeeze == 2.0
    assert weigh(point(squeeze=-9.0)).squeeze == 0.3
    assert weigh(point(z=3.0)).z.tolist() == [1.0]
    assert weigh(point(z=-3.0), z_start=0.0).z.tolist() == [-1.0]
    weigh(z_start=-3.0)
    np.testing.assert_array_equal(weigh.start, [-1.0, *np.zeros(7)])


def test_the_palm_is_shifted_and_turned_in_the_objects_frame(weigh):
    turn = np.array([0.1, -0.2, 0.3])
    palm = weigh(np.array([0.0, 0.01, 0.02, 0.03, *turn, 0.0])).palm
    np.testing.assert_allclose(palm.pos, PALM.pos + [0.01, 0.02, 0.03])
    expected = Rotation.from_rotvec(turn) * PALM.rotation
    np.testing.assert_allclose(palm.rotation.as_matrix(), expected.as_matrix(), atol=1e-12)


def test_pads_that_are_remembered_are_those_of_the_posture(monkeypatch):
    hand = HandModel.from_spec(build_hand())
    pads, asked = fingertip_fit._Pads(hand), []
    found = fingertip_fit._pads_in_palm
    monkeypatch.setattr(
        fingertip_fit, "_pads_in_palm", lambda h, q: (asked.append(q.copy()), found(h, q))[1]
    )
    postures = [np.full(22, 0.01 * i) for i in range(fingertip_fit.REMEMBERED + 1)]
    for q in (postures[0], postures[1], postures[0]):
        hand.set_posture(q)
        palm = hand.data.body("palm")
        pos, normal = hand.pads()
        back = palm.xmat.reshape(3, 3)
        np.testing.assert_allclose(pads(q)[0], (pos - palm.xpos) @ back, atol=1e-12)
        np.testing.assert_allclose(pads(q)[1], normal @ back, atol=1e-12)
    assert len(asked) == 2
    for q in postures:  # one more than are remembered: the first is forgotten
        pads(q)
    assert len(asked) == len(postures)
    pads(postures[-1])
    assert len(asked) == len(postures)
    pads(postures[0])
    assert len(asked) == len(postures) + 1
