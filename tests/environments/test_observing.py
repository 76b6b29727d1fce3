"""What is observed of a run, against what MuJoCo says of the same state."""

from itertools import pairwise
from typing import Any

import mujoco
import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="comes with handsim[gym]")

from handsim.environments.asked import grasped
from handsim.environments.entries import observation_entries
from handsim.environments.grasp_episode import GraspEpisode
from handsim.environments.observing import Felt, Observer
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import schedule_for
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.sensing import contacts_of
from handsim.joints import CONTACT_PARTS, FINGERS

NEED = 2.5
DESTINATION = np.array([0.1, -0.2, 0.3])


class Observed:
    """Runs of one task that have begun, and what looks at them."""

    def __init__(self, task: str, n: int = 1) -> None:
        self.known = known = grasped(task, Conditions())
        scene = Scene.build(known.task, Conditions())
        self.schedule = schedule_for(known.task)
        self.entries = observation_entries(3, self.schedule.end)
        self.observer = Observer(scene, self.entries, DESTINATION, NEED)
        self.model, self.data = scene.model, scene.hand.data
        self.episode = GraspEpisode([scene] * n, known.plan, known.controller, "components")
        self.observer.begin(self.episode)

    def look(self) -> tuple[dict[str, Any], Felt]:
        """Look at the first run after its state has been set."""
        mujoco.mj_forward(self.model, self.data)
        flat, felt = self.observer.look(self.episode)
        return self.observer.named(flat[0]), felt[0]

    def turned(self, quat: list[float], shift: tuple[float, ...] = (0.0, 0.0, 0.0)) -> None:
        """Turn and shift the object where it is."""
        first = self.model.jnt_qposadr[self.model.body("object").jntadr[0]]
        self.data.qpos[first : first + 3] += shift
        self.data.qpos[first + 3 : first + 7] = quat / np.linalg.norm(quat)


@pytest.fixture(scope="module")
def cube() -> Observed:
    return Observed("cube-raise")


@pytest.fixture
def begun(cube: Observed) -> Observed:
    """The same runs as before, at their start."""
    kept = cube.data.qpos.copy()
    cube.episode.reading = 0
    yield cube
    cube.data.qpos[:] = kept


def test_places_are_those_in_the_frame_of_the_object(begun):
    begun.turned([0.3, -0.5, 0.7, 0.2], (0.02, -0.03, 0.05))
    seen, felt = begun.look()
    body, palm = begun.data.body("object"), begun.data.body("palm")
    turn = body.xmat.reshape(3, 3).T
    np.testing.assert_allclose(seen["palm_position"], turn @ (palm.xpos - body.xpos), atol=1e-12)
    tips = np.array([begun.data.site(f"{finger}_tip").xpos for finger in FINGERS])
    at = (tips - body.xpos) @ turn.T
    np.testing.assert_allclose(seen["fingertips"].reshape(5, 3), at, atol=1e-12)
    grasp = begun.model.site("grasp").pos
    np.testing.assert_allclose(felt.away, np.linalg.norm(at - grasp, axis=1), atol=1e-12)


@pytest.mark.parametrize("quat", [[1, 0, 0, 0], [0.3, -0.5, 0.7, 0.2], [-0.1, 0.9, 0.2, -0.4]])
def test_the_palms_orientation_is_told_in_one_way_of_two(begun, quat):
    begun.turned(quat)
    w, *rest = begun.look()[0]["palm_orientation"]
    body, palm = begun.data.body("object"), begun.data.body("palm")
    found = np.zeros(9)
    mujoco.mju_quat2Mat(found, np.array([w, *rest]))
    want = body.xmat.reshape(3, 3).T @ palm.xmat.reshape(3, 3)
    np.testing.assert_allclose(found.reshape(3, 3), want, atol=1e-12)
    assert w >= 0.0


def test_the_objects_way_is_that_of_its_mass_since_the_start():
    """Its frame turns about the foot, its centre of mass goes aside."""
    hammer = Observed("hammer-use")
    start = hammer.data.body("object").xipos.copy()
    assert np.abs(start - hammer.data.body("object").xpos).max() > 0.01
    hammer.turned([0.9, 0.2, 0.0, 0.3], (0.02, -0.03, 0.05))
    seen, _ = hammer.look()
    way = hammer.data.body("object").xipos - start
    np.testing.assert_allclose(seen["object_shift"], way, atol=1e-12)
    hammer.observer.begin(hammer.episode)
    np.testing.assert_array_equal(hammer.look()[0]["object_shift"], 0.0)


def test_forces_are_those_of_the_contacts(begun):
    """The cube is put into the hand."""
    places = [begun.data.site(f"{finger}_tip").xpos for finger in FINGERS]
    middle = np.mean([*places, begun.data.body("palm").xpos], axis=0)
    begun.turned([1.0, 0.0, 0.0, 0.0], tuple(middle - begun.data.body("object").xpos))
    seen, felt = begun.look()
    exact = contacts_of(begun.model, begun.data)
    assert np.count_nonzero(exact.force) > 3
    np.testing.assert_allclose(felt.force, exact.force, rtol=1e-12)
    np.testing.assert_allclose(felt.press, exact.press, rtol=1e-9, atol=1e-9)
    entry = {each.name: each for each in begun.entries}["forces"]
    np.testing.assert_allclose(seen["forces"], np.minimum(exact.force, entry.high), rtol=1e-12)
    assert entry.numbers == CONTACT_PARTS


def test_the_hinge_is_that_of_the_rule_or_none(begun):
    assert begun.look()[0]["hinge"] == [0.0]
    stapler = Observed("stapler-use")
    place = stapler.model.joint(stapler.known.task.rule.joint).qposadr[0]
    for angle in (0.05, 0.21):
        stapler.data.qpos[place] = angle
        assert stapler.look()[0]["hinge"] == [angle]


def test_what_is_known_before_is_told_of_each_reading(begun):
    schedule, episode = begun.schedule, begun.episode
    starts = [0.0, schedule.squeeze_start, schedule.action_start, schedule.hold_start]
    middles = [0.5 * (a + b) for a, b in pairwise([*starts, schedule.end])]
    for i, middle in enumerate(middles):
        episode.reading = round(100.0 * middle)
        seen, _ = begun.look()
        assert seen["time"] == [0.01 * episode.reading]
        want = [1.0] * i + [0.5] + [0.0] * (3 - i)
        np.testing.assert_allclose(seen["progress"], want, atol=0.06)
        np.testing.assert_array_equal(seen["destination"], DESTINATION)
        assert seen["need"] == [NEED]
    episode.reading = episode.n_readings - 1
    np.testing.assert_array_equal(begun.look()[0]["progress"], 1.0)
    episode.reading = 0
    np.testing.assert_array_equal(begun.look()[0]["progress"], 0.0)


def test_a_phase_that_takes_no_time_is_over_once_it_begins():
    """Who clicks does not move first: the action's only step takes as long as it says."""
    from handsim.environments.observing import _shares

    schedule = schedule_for(grasped("cube-raise", Conditions()).task)
    shares = _shares(type(schedule)(steps=(), hold=schedule.hold))
    begins = round(100.0 * schedule.action_start)
    assert np.isfinite(shares).all()
    np.testing.assert_array_equal(shares[: begins - 1, 2], 0.0)
    np.testing.assert_array_equal(shares[begins + 1 :, 2], 1.0)


def test_the_glove_and_the_point_have_their_places(begun):
    seen, _ = begun.look()
    glove, point = begun.episode.seen()
    np.testing.assert_array_equal(seen["posture"], glove[0])
    np.testing.assert_array_equal(seen["components"], point[0])


@pytest.mark.parametrize("far", [-50.0, 50.0])
def test_numbers_are_cut_off_at_the_bounds_of_their_entries(begun, far):
    begun.turned([1.0, 0.0, 0.0, 0.0], (far, far, far))
    seen, felt = begun.look()
    for entry in begun.entries:
        assert ((seen[entry.name] >= entry.low) & (seen[entry.name] <= entry.high)).all()
    bound = 3.0 if far > 0.0 else -3.0
    np.testing.assert_array_equal(seen["object_shift"], bound)
    np.testing.assert_array_equal(seen["fingertips"], -bound)
    assert min(felt.away) > 40.0  # what is paid for is not cut off


def test_several_runs_are_seen_as_each_by_itself():
    """In one of MuJoCo's batches, whose arrays are others."""
    pytest.importorskip("mujoco.batch", reason="comes with MuJoCo 4.0")
    ways = np.array([[0.3, 0.3, 0.3], [-0.3, 0.1, 0.0]])
    two = Observed("pen-write", 2)
    alone = []
    for way in ways:
        one = Observed("pen-write")
        for _ in range(8):
            one.episode.step(way[None])
        alone.append(one.observer.look(one.episode)[0][0])
    for _ in range(8):
        two.episode.step(ways)
    together, _ = two.observer.look(two.episode)
    assert not np.array_equal(*alone)
    np.testing.assert_array_equal(together, alone)
    both = two.observer.named(together)
    for name, value in one.observer.named(alone[1]).items():
        np.testing.assert_array_equal(both[name][1], value)
