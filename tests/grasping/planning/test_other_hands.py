"""Plans of one hand start the search of another: the mirror image, another size, and the order."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning import planner
from handsim.grasping.planning.fingertip_fit import carried_over, mirrored
from handsim.grasping.planning.opposition import palm_pose
from handsim.grasping.planning.plan_store import StoredPlan, plan_store, shipped_plans, usual_store
from handsim.grasping.planning.search import (
    NO_ARM,
    Effort,
    Estimate,
    out_of_reach,
    strain_of,
    within_reach,
)
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import FINGERS, clip_to_range
from handsim.learning.controller import GraspController
from handsim.tasks.table_one import task_by_name
from handsim.types import MEDIAN_HAND, HandSize

TASK, UNSCREW = task_by_name("cube-raise"), task_by_name("jar-unscrew")
LEFT, SMALL = HandSize(side="left"), HandSize(0.165, 0.072)
ACROSS = np.array([1.0, -1.0, 1.0])


@pytest.fixture(scope="module")
def controller():
    return GraspController.load(data_folder("assets") / "controller.npz")


@pytest.fixture(scope="module")
def plans(controller):
    return shipped_plans(controller.digest, Conditions()).read()


@pytest.fixture(scope="module")
def plan(plans):
    return plans[TASK.name]


@pytest.fixture(scope="module")
def carry(controller):
    box = planner.destination_box(controller)

    def carried(plan, of, to):
        return carried_over(plan, (of, to), TASK.grasp, controller.subspace, box)

    return carried


def pads(size, plan):
    """Pads of a hand at the grasp and the palm's axes, in the object's frame."""
    hand = HandModel.from_spec(build_hand(size))
    hand.set_posture(plan.q_goal)
    palm, turn = palm_pose(hand), plan.palm.rotation
    return plan.palm.pos + turn.apply(palm.rotation.inv().apply(hand.pads()[0] - palm.pos))


def numbers(plan):
    return np.concatenate([plan.palm.pos, plan.palm.quat, plan.retreat, plan.z_goal, plan.q_goal])


def test_the_mirror_image_has_the_pads_of_the_other_hand_on_the_other_side(plan):
    other = mirrored(plan)
    np.testing.assert_allclose(pads(LEFT, other), ACROSS * pads(MEDIAN_HAND, plan), atol=1e-9)
    aside = replace(plan, retreat=np.array([0.05, -0.1, 0.1]))
    np.testing.assert_array_equal(mirrored(aside).retreat, [0.05, 0.1, 0.1])
    np.testing.assert_array_equal(other.z_goal, plan.z_goal)
    assert np.linalg.norm(other.palm.pos - plan.palm.pos) > 0.02
    np.testing.assert_array_equal(numbers(mirrored(other)), numbers(plan))


def test_a_plan_is_carried_to_the_other_side_and_back_to_the_bit(plan, carry):
    np.testing.assert_array_equal(numbers(carry(plan, MEDIAN_HAND, MEDIAN_HAND)), numbers(plan))
    left = carry(plan, MEDIAN_HAND, LEFT)
    np.testing.assert_array_equal(numbers(left), numbers(mirrored(plan)))
    np.testing.assert_array_equal(numbers(carry(left, LEFT, MEDIAN_HAND)), numbers(plan))


@pytest.mark.parametrize("side", ["right", "left"])
def test_pads_of_another_size_stand_as_they_did(plan, carry, controller, side):
    small = replace(SMALL, side=side)
    mirror = ACROSS if side == "left" else 1.0
    fingers = [0, *(FINGERS.index(finger) for finger in TASK.grasp.fingers)]
    wanted = (mirror * pads(MEDIAN_HAND, plan))[fingers]
    asis = plan if side == "right" else mirrored(plan)
    carried = carry(plan, MEDIAN_HAND, small)
    off = np.linalg.norm(pads(small, carried)[fingers] - wanted, axis=1)
    before = np.linalg.norm(pads(small, asis)[fingers] - wanted, axis=1)
    assert before.max() > 0.012
    assert off.max() < 0.007 and off.mean() < 0.4 * before.mean()
    np.testing.assert_allclose(
        carried.q_goal, controller.subspace.inverse_transform(carried.z_goal), atol=0.2
    )
    assert (carried.squeeze, carried.grip, carried.arrive) == (
        plan.squeeze,
        plan.grip,
        plan.arrive,
    )


def test_destinations_of_another_size_stay_where_the_controller_goes(plan, controller):
    low, _ = planner.destination_box(controller)
    box = (low, plan.z_goal - 0.05)
    carried = carried_over(plan, (MEDIAN_HAND, SMALL), TASK.grasp, controller.subspace, box)
    assert (carried.z_goal <= box[1]).all() and (carried.z_goal >= box[0]).all()


def test_a_lid_that_no_arm_can_turn_so_is_grasped_turned_about_it(plans):
    """The left hand turns the lid as the right one does, so that it has to begin elsewhere."""
    scene = Scene.build(UNSCREW, Conditions(hand=LEFT))
    start = mirrored(plans[UNSCREW.name])
    assert out_of_reach(scene, start) is not None
    turned = within_reach(scene, start)
    assert strain_of(turned, scene.task, scene.arm) < 1.5 < NO_ARM
    step = turned.palm.rotation * start.palm.rotation.inv()
    np.testing.assert_allclose(step.as_rotvec(), [0.0, 0.0, np.deg2rad(-60.0)], atol=1e-9)
    np.testing.assert_allclose(step.apply(start.palm.pos), turned.palm.pos, atol=1e-12)
    aside = replace(start, retreat=np.array([0.0, 0.05, 0.15]))
    turned = within_reach(scene, aside)
    step = turned.palm.rotation * start.palm.rotation.inv()
    assert step.magnitude() > 0.5
    np.testing.assert_allclose(step.apply(aside.retreat), turned.retreat, atol=1e-12)


def test_what_an_arm_can_follow_or_is_not_round_is_not_turned(plans):
    lid = Scene.build(UNSCREW, Conditions())
    assert within_reach(lid, plans[UNSCREW.name]) is plans[UNSCREW.name]
    free = Scene.build(UNSCREW, Conditions(hand=LEFT, base="free"))
    start = mirrored(plans[UNSCREW.name])
    assert within_reach(free, start) is start
    cube = Scene.build(TASK, Conditions())
    away = replace(plans[TASK.name], palm=plans[TASK.name].palm.moved(np.array([0, 0, 5.0])))
    assert out_of_reach(cube, away) is not None
    assert within_reach(cube, away) is away


class Pretended:
    """A search in which all that is found is known before; what is asked of it is noted."""

    def __init__(self, share, cost, fits=("fit",)):
        self.share, self.price, self.fits = share, cost, fits
        self.asked, self.efforts = [], []

    def __call__(self, controller, task, conditions, estimate, n_perturbed):
        return self

    def known(self, known, others):
        return iter([known] if known is not None else others)

    def starts(self):
        self.asked.append("fits")
        return list(self.fits)

    def cost(self, plan):
        self.asked.append(plan)
        return self.price.get(plan, 0.0)

    def confirmed(self, plan, cost):
        return self.share.get(plan, 0.0), plan

    def from_start(self, start, effort, seed):
        self.asked.append(f"from {start}, {seed}")
        self.efforts.append(effort)
        return -0.5, f"better {start}"


@pytest.fixture
def planned(controller, monkeypatch):
    def plan(pretended, *, known=None, others=(), lost=(), seed=0):
        def run_plan(controller, scene, plan):
            return SimpleNamespace(outcome=SimpleNamespace(success=plan not in lost))

        monkeypatch.setattr(planner, "_Search", pretended)
        monkeypatch.setattr(planner, "run_plan", run_plan)
        return planner.plan_grasp(controller, TASK, Conditions(), known, others=others, seed=seed)[
            0
        ]

    return plan


def test_the_first_plan_of_another_hand_that_holds_is_kept_without_a_search(planned):
    pretended = Pretended({"a": 0.7, "b": planner.ENOUGH, "c": 1.0}, {})
    assert planned(pretended, others=["a", "b", "c"]) == "b"
    assert pretended.asked == ["a", "b"]


def test_a_known_plan_that_holds_is_kept_without_a_fit(planned):
    pretended = Pretended({"a": planner.ENOUGH}, {})
    assert planned(pretended, known="a") == "a"
    assert pretended.asked == ["a"]


def test_the_first_search_is_from_the_best_plan_of_another_hand(planned):
    pretended = Pretended({"a": 0.7, "b": 0.6, "better b": planner.FAIR}, {"a": 2.0, "b": 1.5})
    assert planned(pretended, others=["a", "b"], seed=4) == "a"
    assert pretended.asked == ["a", "b", "from b, 4"]
    pretended = Pretended({"a": 0.0, "better a": planner.FAIR}, {"a": 2.0})
    assert planned(pretended, others=["a"]) == "better a"
    assert pretended.asked == ["a", "from a, 0"]
    assert pretended.efforts == [planner.NEAR]


def test_where_it_finds_too_little_fits_are_made_and_nothing_is_searched_from_twice(planned):
    pretended = Pretended({}, {"a": 0.5, "b": 2.0, "fit": 1.0, "other": 3.0}, ("fit", "other"))
    planned(pretended, others=["a", "b"])
    assert pretended.asked == ["a", "b", "from a, 0", "fits", "fit", "other", "from fit, 1"]
    assert planner.N_NEAR == 2


def test_a_known_plan_that_does_not_hold_is_searched_from_in_its_turn(planned):
    pretended = Pretended({"a": 0.7}, {"a": 2.0, "fit": 1.0})
    assert planned(pretended, known="a") == "a"
    assert pretended.asked == ["a", "fits", "fit", "from fit, 0", "from a, 1"]
    assert set(pretended.efforts) == {Effort(planner.GENERATIONS)}


@pytest.mark.parametrize("how", ["known", "others"])
def test_what_is_lost_in_the_whole_task_is_not_kept(planned, how):
    pretended = Pretended({"a": 1.0}, {"a": -0.4, "fit": 1.0})
    found = planned(pretended, **{how: "a" if how == "known" else ["a"]}, lost=("a",))
    assert found == "better a"
    assert pretended.asked[-1] == f"from a, {planner.SEARCHES}"
    assert "fits" in pretended.asked


def test_plans_of_others_are_aimed_in_the_subspace_of_this_controller(controller, plan):
    search = planner._Search(controller, TASK, Conditions(hand=LEFT), Estimate(None))
    others = [StoredPlan(plan, True, hand=MEDIAN_HAND), StoredPlan(plan, True)]
    one, unknown = search.known(None, others)
    np.testing.assert_array_equal(numbers(one), numbers(mirrored(plan)))
    np.testing.assert_array_equal(numbers(unknown), numbers(plan))  # taken as it is
    (foreign,) = search.known(None, [replace(others[0], plan=replace(plan, z_goal=None))])
    np.testing.assert_array_equal(foreign.z_goal, controller.subspace.transform(plan.q_goal))


def test_a_destination_out_of_reach_of_this_controller_is_moved_to_where_it_leads(controller, plan):
    """Another controller's people may have closed further than anybody whom this one knows."""
    search = planner._Search(controller, TASK, Conditions(), Estimate(None))
    far = replace(plan, z_goal=3.0 * search.box[1])
    assert planner.refused(controller, far)
    for begun in (search.known(far, ()), search.known(None, [StoredPlan(far, True)])):
        (aimed,) = begun
        assert not planner.refused(controller, aimed)
        lower, upper = search.box
        assert ((lower <= aimed.z_goal) & (aimed.z_goal <= upper)).all()
        np.testing.assert_allclose(
            aimed.q_goal, clip_to_range(controller.subspace.inverse_transform(aimed.z_goal))
        )


def test_a_store_knows_whose_hand_and_controller_its_plans_are_for(tmp_path, plan):
    left = Conditions(hand=LEFT)
    store = plan_store(tmp_path, "c", left)
    store.add(TASK.name, StoredPlan(plan, True))
    assert store.entries()[TASK.name].hand == LEFT
    assert (store.controller, store.hand) == ("c", LEFT)
    assert '"side"' not in store.path.read_text()
    assert usual_store(tmp_path, "c", left) == (plan_store(tmp_path, "c", Conditions()),)
    assert usual_store(tmp_path, "c", Conditions()) == ()
