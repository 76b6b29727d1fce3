import numpy as np
import pytest

from handsim.hand.model import HandModel, build_hand
from handsim.hand.tasks import task_by_name
from handsim.joints import JOINT_INDEX, clip_to_range
from handsim.simulation.alignment import palm_pose
from handsim.simulation.closings import closing_for
from handsim.simulation.demonstrator import plan_for
from handsim.simulation.placement import pad_targets, place
from handsim.simulation.squeeze import squeeze_offset

TASK = task_by_name("cube-raise")


class Line:
    """A subspace of one component: the way from a closing's open to its shut posture."""

    def __init__(self):
        closing = closing_for(TASK.grasp)
        self.origin, self.way = closing.open, closing.shut - closing.open

    def transform(self, q):
        return np.array([(q - self.origin) @ self.way / (self.way @ self.way)])

    def inverse_transform(self, z):
        return self.origin + z[0] * self.way


@pytest.fixture(scope="module")
def hand():
    return HandModel.from_spec(build_hand())


def test_targets_are_the_pads_of_the_script(hand):
    plan, _ = plan_for(TASK, hand)
    targets = pad_targets(hand, plan, TASK.grasp)
    away = (targets.pos - np.array(TASK.grasp.point)) @ np.array(TASK.grasp.opposition)
    assert away[0] < 0 < away[1]  # thumb and fingers on either side
    np.testing.assert_allclose(targets.outward[0], -targets.outward[1])
    assert targets.weight[4] < targets.weight[1]  # the little finger does not take part


def test_a_subspace_that_holds_the_scripted_grasp_is_led_back_to_it(hand):
    """From a wrong start the fit finds coordinates and palm near the script's own."""
    plan, _ = plan_for(TASK, hand)
    line = Line()
    wanted = line.transform(plan.q_goal)
    box = (np.array([0.0]), np.array([1.2]))
    placement = place(hand, line, pad_targets(hand, plan, TASK.grasp), wanted - 0.3, box)
    assert placement.z[0] == pytest.approx(wanted[0], abs=0.12)
    assert np.linalg.norm(placement.palm.pos - plan.palm.pos) < 0.012
    worse = place(hand, line, pad_targets(hand, plan, TASK.grasp), wanted, (box[0], box[0] + 0.1))
    assert worse.error > placement.error
    assert worse.z[0] <= 0.1


def test_a_lever_between_thumb_and_fingers_is_taken_away_where_it_counts(hand):
    """A thumb turned aside pushes past the fingers; with weight on it, the palm makes up for it."""
    task = task_by_name("pen-move")
    plan, _ = plan_for(task, hand)
    targets = pad_targets(hand, plan, task.grasp)
    aside = np.zeros(22)
    aside[JOINT_INDEX["thumb_rotation"]] = np.deg2rad(-25.0)

    class Askew(Line):
        def __init__(self):
            closing = closing_for(task.grasp)
            self.origin, self.way = closing.open + aside, closing.shut - closing.open

    line, box = Askew(), (np.array([0.0]), np.array([1.2]))
    start = line.transform(plan.q_goal)
    levers = []
    for weight in (0.0, 5.0):
        placement = place(hand, line, targets, start, box, weight)
        closed = line.inverse_transform(placement.z)
        closed = closed + placement.squeeze * squeeze_offset(1.0, task.grasp.fingers)
        hand.set_posture(clip_to_range(closed))
        pads = targets.opposing @ hand.pads()[0]
        turn = placement.palm.rotation * palm_pose(hand).rotation.inv()
        wanted = targets.opposing @ targets.pos
        levers.append(np.linalg.norm(targets.axes[1:] @ (turn.apply(pads) - wanted)))
    assert levers[1] < 0.5 * levers[0]
