from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from handsim.errors import FileError
from handsim.grasping.conditions import Conditions, perturb
from handsim.grasping.judging.quality import grasp_quality
from handsim.grasping.judging.six_axis import six_axis
from handsim.grasping.plan import Pose
from handsim.grasping.planning import demonstrator_offsets as offsets
from handsim.grasping.planning.demonstrator import demonstrate, scripted_plan
from handsim.grasping.planning.demonstrator_offsets import (
    SPREADS,
    DemonstratorOffsets,
    demonstrator_offsets,
    write_demonstrator_offsets,
)
from handsim.grasping.planning.preshapes import PINCH, PRESHAPES, REST, preshape_for
from handsim.grasping.planning.trial_variation import (
    PEAK_APERTURE_RANGE,
    REACH_RANGE,
    USUAL,
    trial_variation,
)
from handsim.grasping.rollout.glove import recorded_reach
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import JOINT_INDEX, LOWER, UPPER
from handsim.tasks.table_one import TASK_NAMES, task_by_name
from handsim.types import HandSize


def offset_by(**values: float) -> DemonstratorOffsets:
    return DemonstratorOffsets(tuple(values.get(name, 0.0) for name in SPREADS))


def test_every_kind_of_grasp_closes_within_the_joint_ranges():
    for preshape in (*PRESHAPES.values(), PINCH):
        for q in (preshape.open, preshape.shut):
            assert (q >= LOWER).all()
            assert (q <= UPPER).all()


def test_thin_objects_are_pinched():
    assert preshape_for(task_by_name("pen-move").grasp) is PINCH
    assert preshape_for(task_by_name("cube-raise").grasp) is PRESHAPES["top"]


def test_offsets_of_zero_change_nothing():
    preshape = DemonstratorOffsets().preshape(PRESHAPES["top"])
    np.testing.assert_array_equal(preshape.shut, PRESHAPES["top"].shut)
    palm = Pose(np.array([0.1, 0.2, 0.3]), Rotation.from_euler("x", 0.4).as_quat(scalar_first=True))
    np.testing.assert_allclose(DemonstratorOffsets().palm(palm, "left").pos, palm.pos)


def test_offsets_are_in_the_palms_frame_and_mirrored_for_the_left():
    turned = Rotation.from_euler("z", 90, degrees=True).as_quat(scalar_first=True)
    palm = Pose(np.zeros(3), turned)
    change = offset_by(x_mm=10, y_mm=4, turn_z_deg=5)
    right, left = change.palm(palm, "right"), change.palm(palm, "left")
    np.testing.assert_allclose(right.pos, [-0.004, 0.010, 0], atol=1e-12)
    np.testing.assert_allclose(left.pos, [0.004, 0.010, 0], atol=1e-12)
    turns = [(palm.rotation.inv() * p.rotation).as_rotvec(degrees=True) for p in (right, left)]
    np.testing.assert_allclose(turns, [[0, 0, 5], [0, 0, -5]], atol=1e-9)


def test_joints_move_by_their_offsets():
    preshape = offset_by(fingers_mcp=5, index_middle_mcp=2, squeeze=0.5).preshape(PRESHAPES["top"])
    moved = np.rad2deg(preshape.shut - PRESHAPES["top"].shut)
    assert moved[JOINT_INDEX["index_mcp"]] == pytest.approx(7)
    assert moved[JOINT_INDEX["ring_mcp"]] == pytest.approx(5)
    assert moved[JOINT_INDEX["ring_pip"]] == pytest.approx(0)
    assert preshape.squeeze == pytest.approx(PRESHAPES["top"].squeeze + 0.5)


def test_fingers_may_be_told_to_stop_before_the_object():
    """The squeeze closes them then."""
    task, hand = task_by_name("scissors-move"), HandModel.from_spec(build_hand())
    preshape = preshape_for(task.grasp)
    short, touching = (
        scripted_plan(task, hand, offset_by(beyond=beyond - preshape.beyond))[0].q_goal
        for beyond in (-0.2, 0.0)
    )
    np.testing.assert_allclose(
        touching - short, 0.2 * (preshape.shut - preshape.open), rtol=0, atol=1e-12
    )


def test_offsets_survive_a_round_trip(tmp_path, monkeypatch):
    path = tmp_path / "demonstrations.json"
    write_demonstrator_offsets({"pen-move": offset_by(x_mm=1.5, squeeze=-0.25)}, path)
    monkeypatch.setattr(offsets, "demonstrator_offsets_file", lambda: path)
    demonstrator_offsets.cache_clear()
    try:
        assert demonstrator_offsets()["pen-move"] == offset_by(x_mm=1.5, squeeze=-0.25)
        path.write_text("[1]")
        demonstrator_offsets.cache_clear()
        with pytest.raises(FileError, match="make it again"):
            demonstrator_offsets()
    finally:
        demonstrator_offsets.cache_clear()


def test_the_stored_offsets_are_of_tasks():
    assert set(demonstrator_offsets()) <= {*TASK_NAMES, "phone-today-view"}


def test_a_left_hand_grasps_as_the_mirror_image():
    task = task_by_name("hammer-use")
    assert task.name in demonstrator_offsets()
    plans = {}
    for side in ("right", "left"):
        hand = HandModel.from_spec(build_hand(HandSize(side=side)))
        plans[side], _ = scripted_plan(task.for_side(side), hand, side=side)
    mirror = np.array([1.0, -1.0, 1.0])
    np.testing.assert_allclose(plans["left"].palm.pos, mirror * plans["right"].palm.pos, atol=1e-6)
    np.testing.assert_allclose(plans["left"].q_goal, plans["right"].q_goal, atol=1e-6)


def test_variations_stay_within_their_ranges_and_repeat():
    variations = [trial_variation(seed) for seed in range(60)]
    np.testing.assert_array_equal(trial_variation(7).rest, variations[7].rest)
    reaches = [m.reach for m in variations]
    assert REACH_RANGE[0] <= min(reaches) < max(reaches) <= REACH_RANGE[1]
    assert PEAK_APERTURE_RANGE[0] <= min(m.peak_aperture_at for m in variations)
    curl = np.array([m.rest[JOINT_INDEX["index_mcp"]] for m in variations]) - REST[4]
    other = np.array([m.rest[JOINT_INDEX["little_pip"]] for m in variations])
    assert np.rad2deg(curl.std()) == pytest.approx(6, abs=2)
    assert np.corrcoef(curl, other)[0, 1] > 0.95  # fingers at rest curl together


def test_a_grasp_by_script_holds_is_closed_and_repeats_bit_by_bit():
    task = task_by_name("cube-raise")
    runs = [demonstrate(task, Conditions(seed=3)) for _ in range(2)]
    assert runs[0].outcome.success
    assert runs[0].qpos.tobytes() == runs[1].qpos.tobytes()
    assert grasp_quality(runs[0]) > 0.05
    assert six_axis(runs[0]).success


def test_a_grasp_of_nothing_resists_nothing():
    task = task_by_name("cube-raise")
    run = demonstrate(task, Conditions(object_offset=(0.0, 0.3, 0.0)))
    assert run.outcome.reason == "missed"
    assert grasp_quality(run) == 0.0
    outcome = six_axis(run)
    assert not outcome.success
    assert max(outcome.shift_m) > 0.05


def test_recordings_end_where_the_squeeze_begins():
    task = task_by_name("jar-unscrew")
    variation = replace(USUAL, reach=1.05)
    run = demonstrate(task, Conditions(seed=2), variation)
    recording = recorded_reach(run, task)
    assert recording.time[-1] == pytest.approx(1.05)
    assert recording.task == task.name
    degrees = np.rad2deg(recording.q)
    np.testing.assert_allclose(degrees, np.round(degrees), atol=1e-9)  # the glove's steps


@pytest.mark.slow
@pytest.mark.parametrize("name", TASK_NAMES)
def test_every_task_is_demonstrated(name):
    assert demonstrate(task_by_name(name), Conditions()).outcome.success


@pytest.mark.slow
def test_perturbed_demonstrations_mostly_hold():
    names = TASK_NAMES[::3]
    held = [
        demonstrate(task_by_name(name), perturb(Conditions(), seed)).outcome.success
        for name in names
        for seed in (1, 2)
    ]
    assert np.mean(held) >= 0.75
