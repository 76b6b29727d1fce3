from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from handsim.errors import InputError
from handsim.files import data_folder
from handsim.hand.anthropometry import LENGTHS
from handsim.hand.mjcf import build_hand
from handsim.hand.postures import POSTURES
from handsim.joints import JOINT_INDEX, clip_to_range
from handsim.recordings.folder import read_recordings
from handsim.retargeting import retarget
from handsim.retargeting.retarget import SETTLING, Retargeter, Weights, human_hand
from handsim.retargeting.robot_hand import RobotHand
from handsim.retargeting.solving.movement_fit import Movement
from handsim.retargeting.solving.residuals import Residuals
from handsim.types import HandSize

FOUR_FINGERS = Path(__file__).parent / "data" / "four_finger_hand.xml"
TIPS = {"thumb": "thumb_touch", "index": "f1_touch", "middle": "f2_touch", "ring": "f3_touch"}
SMALLER = HandSize(0.15, 0.15 * 0.0883 / 0.1933)
"""A hand of the default's proportions."""


@pytest.fixture(scope="module")
def robot() -> RobotHand:
    return RobotHand(FOUR_FINGERS, "base_frame", TIPS)


@pytest.fixture(scope="module")
def reach() -> np.ndarray:
    """A recorded reach, every second frame, (n, 22) [rad]."""
    recordings = read_recordings(data_folder("assets") / "experiments")
    recording = next(r for r in recordings if r.name == "tall-glass-drink")
    return clip_to_range(recording.q[::2])


def test_the_four_finger_hand_is_unlike_a_persons(robot):
    assert (len(robot.fingers), len(robot.joint_names)) == (4, 16)
    scale = Retargeter(robot).finger_scale
    assert scale.max() / scale.min() > 1.1
    assert scale.min() > 1.3


@pytest.mark.parametrize("side", ["right", "left"])
@pytest.mark.parametrize("name", ["rest", "pinch", "tripod"])
def test_the_same_kinematics_at_another_size_give_the_posture_back(side, name):
    robot, weights = human_hand(replace(SMALLER, side=side)), Weights(contact=0.0)  # pads touch
    retargeter = Retargeter(robot, HandSize(side=side), weights=weights)
    assert retargeter.scale == pytest.approx(0.15 / 0.1933)
    q = POSTURES[name]
    result = retargeter.retarget(q)
    given = q[[JOINT_INDEX[joint] for joint in result.joint_names]]
    assert np.abs(result.positions - given).max() < np.deg2rad(0.5)
    assert result.tip_error.max() < 2e-5
    assert result.opening_error.max() < 2e-5
    assert result.matched
    assert result.reason == ""


def test_the_same_kinematics_follow_a_recording(reach):
    retargeter = Retargeter(human_hand(SMALLER))
    result = retargeter.retarget(reach)
    given = reach[:, [JOINT_INDEX[joint] for joint in result.joint_names]]
    assert np.sqrt(np.mean((result.positions - given) ** 2)) < np.deg2rad(1)
    assert result.opening_error.max() < 2e-4
    assert result.matched.all()


def test_four_finger_hand_makes_a_recorded_reach(robot, reach):
    retargeter = Retargeter(robot)
    result = retargeter.retarget(reach)
    assert result.positions.shape == (len(reach), 16)
    assert result.tip_error.shape == result.opening_error.shape == (len(reach), 4)
    assert np.all(result.positions >= robot.lower)
    assert np.all(result.positions <= robot.upper)
    assert result.matched.all(), result.reason
    assert np.all(result.opening_error[:, 0] == 0), "the thumb against itself"
    assert result.opening_error[-1].max() < 0.1 * robot.reach.mean(), "at the grasp"
    assert result.tip_error[:, 1:].max() < 0.3 * robot.reach.mean()
    assert np.ptp(result.positions, axis=0).max() > np.deg2rad(30), "it moves"


def test_errors_are_those_of_the_positions_returned(robot, reach):
    retargeter = Retargeter(robot)
    result = retargeter.retarget(reach[-1])
    points, openings, _, _ = retargeter.targets(reach[-1])
    tips = robot.forward(result.positions).points
    assert np.allclose(result.tip_error, np.linalg.norm(tips - points, axis=1))
    apart = tips - tips[0]
    assert np.allclose(result.vector_error, np.linalg.norm(apart - openings, axis=1))
    far, wanted = np.linalg.norm(apart, axis=1), np.linalg.norm(openings, axis=1)
    assert np.allclose(result.opening_error, np.abs(far - wanted))


def closing(n: int) -> np.ndarray:
    """From rest over a wide opening to a pinch, at constant speed, (n, 22) [rad]."""
    wide = 0.6 * POSTURES["rest"]
    wide[[JOINT_INDEX["thumb_rotation"], JOINT_INDEX["thumb_abduction"]]] = np.deg2rad([85, 45])
    corners = np.array([POSTURES["rest"], wide, POSTURES["pinch"]])
    part = np.linspace(0, 1, n)
    return np.transpose([np.interp(part, [0, 0.5, 1], joint) for joint in corners.T])


def test_no_jumps_on_a_continuous_path(robot):
    """Halving the time between postures halves the steps, without any limit on them."""
    retargeter = Retargeter(robot)
    coarse, fine = (retargeter.retarget(closing(n), max_gain=np.inf) for n in (31, 61))
    steps = [np.abs(np.diff(result.positions, axis=0)).max() for result in (coarse, fine)]
    assert steps[1] < 0.65 * steps[0]
    assert np.allclose(coarse.positions[-1], fine.positions[-1], atol=np.deg2rad(4)), "a lag"
    assert fine.matched.all(), fine.reason


def test_joints_move_at_most_so_much_faster_than_the_persons(robot, reach):
    q = np.vstack([reach, np.repeat(reach[-1:], 90, axis=0)])
    changes = np.abs(np.diff(q, axis=0)).max(axis=1)
    free, kept = (Retargeter(robot).retarget(q, max_gain=gain) for gain in (np.inf, 1.5))
    moved = [np.abs(np.diff(result.positions, axis=0)).max(axis=1) for result in (free, kept)]
    limit = 1.5 * changes + SETTLING
    assert np.all(moved[1] <= limit + 1e-9)
    assert np.any(moved[0] > limit + np.deg2rad(1)), "it is what limits"
    kept_tips, free_tips = (robot.forward(each.positions[-1]).points for each in (kept, free))
    assert np.allclose(kept_tips, free_tips, atol=2e-3), "it settles"


def test_limits_are_kept_by_the_fit_and_not_only_by_clipping_it(robot, reach, monkeypatch):
    """What is over them before links are taken out of one another, free and within limits."""
    over, untangled = [], retarget.untangled

    def looked_at(residuals_of, hand, contact, movement, start):
        over.append(float((np.abs(np.diff(start, axis=0)) - limit).max()))
        return untangled(residuals_of, hand, contact, movement, start)

    monkeypatch.setattr(retarget, "untangled", looked_at)
    limit = (1.5 * np.abs(np.diff(reach, axis=0)).max(axis=1) + SETTLING)[:, None]
    for gain in (np.inf, 1.5):
        Retargeter(robot).retarget(reach, max_gain=gain)
    assert over[0] > np.deg2rad(3.0)
    assert over[1] < 0.3 * over[0]


def test_largest_step_is_kept(robot, reach):
    step = np.deg2rad(2.0)
    result = Retargeter(robot).retarget(reach[::4], max_step=step)
    moved = np.abs(np.diff(result.positions, axis=0))
    assert moved.max() <= step + 1e-9
    assert moved.max() > 0.99 * step, "it is what limits"


def test_slides_are_held_back_by_lengths_of_a_finger():
    """A finger that only slides in and out, 0.1 m long; the person's bends by 6 deg."""
    spec = mujoco.MjSpec.from_string("""<mujoco><worldbody><body name="palm"><geom size=".01"/>
      <body name="slider" pos=".1 0 0"><joint type="slide" axis="1 0 0" range="-.1 .1"/>
      <geom size=".01"/><site name="tip" pos=".1 0 0"/></body></body></worldbody></mujoco>""")
    retargeter = Retargeter(RobotHand(spec, "palm", {"index": "tip"}))
    bent = np.zeros((2, 22))
    bent[1, JOINT_INDEX["index_mcp"]] = np.deg2rad(60)
    moved = np.abs(np.diff(retargeter.retarget(bent, max_gain=0.1).positions[:, 0]))
    assert moved == pytest.approx((np.deg2rad(6) + SETTLING) * 0.1, rel=1e-3)


def test_each_posture_is_drawn_to_the_one_before(robot):
    postures = np.array([POSTURES["rest"], POSTURES["pinch"]])
    stiff = Retargeter(robot, weights=Weights(previous=100.0)).retarget(postures)
    assert np.ptp(stiff.positions, axis=0).max() < np.deg2rad(0.1)
    assert np.ptp(Retargeter(robot).retarget(postures).positions, axis=0).max() > np.deg2rad(20)


def test_what_touches_in_the_human_hand_touches_in_the_robots(robot):
    retargeter = Retargeter(robot)
    for name, fingers in (("pinch", [1]), ("tripod", [1, 2])):
        result = retargeter.retarget(POSTURES[name])
        tips = robot.forward(result.positions).points
        _, openings, _, _ = retargeter.targets(POSTURES[name])
        for finger in fingers:
            apart = np.linalg.norm(tips[finger] - tips[0])
            assert apart == pytest.approx(np.linalg.norm(openings[finger]), abs=2e-3)
    weak = Retargeter(robot, weights=Weights(opening=0.1, pinch=0.1, vector=0.05)).retarget(
        POSTURES["pinch"]
    )
    assert weak.opening_error[1] > 0.005, "it is the weight that does it"


def test_closeness_counts_more():
    retargeter = Retargeter(human_hand())
    *_, apart = retargeter.targets(POSTURES["flat"])
    *_, touching = retargeter.targets(POSTURES["pinch"])
    assert apart[0] == touching[0] == 0
    assert touching[1] > 2 * Weights().opening
    assert np.all(apart[1:] < 1.3 * Weights().opening)


def test_opening_scale_of_one_keeps_the_width_of_things(robot):
    q = POSTURES["rest"]
    pads = human_hand().forward(q[[JOINT_INDEX[name] for name in human_hand().joint_names]]).points
    _, as_is, _, _ = Retargeter(robot, opening_scale=1.0).targets(q)
    assert np.allclose(as_is, (pads - pads[0])[:4])
    _, scaled, _, _ = Retargeter(robot).targets(q)
    assert np.allclose(scaled, Retargeter(robot).scale * as_is)
    _, narrow, _, _ = Retargeter(robot, opening_scale=0.8).targets(q)
    assert np.allclose(narrow, 0.8 * as_is)


def test_left_robot_mirrors_a_right_recording(robot, reach):
    """The mirrored hand, y -> -y, moved by the mirrored person: the same joint positions."""
    spec = mujoco.MjSpec.from_file(str(FOUR_FINGERS))
    for body in spec.bodies[1:]:
        body.pos = body.pos * [1, -1, 1]
        body.quat = body.quat * [1, -1, 1, -1]
        body.alt.euler = body.alt.euler * [-1, 1, -1]
    for joint in spec.joints:
        joint.axis = -joint.axis * [1, -1, 1]
    for site in spec.sites:
        site.pos = site.pos * [1, -1, 1]
        site.quat = site.quat * [1, -1, 1, -1]
    left = Retargeter(RobotHand(spec, "base_frame", TIPS), HandSize(side="left")).retarget(
        reach[-1]
    )
    right = Retargeter(robot).retarget(reach[-1])
    assert np.allclose(left.positions, right.positions, atol=1e-4)


@pytest.mark.parametrize("fingers", [("thumb", "index", "little"), ("index", "middle"), ("ring",)])
def test_hands_with_fewer_fingers_and_without_thumb(fingers):
    sites = {
        "thumb": "thumb_touch",
        "index": "f1_touch",
        "middle": "f2_touch",
        "little": "f3_touch",
    }
    sites["ring"] = "f3_touch"
    robot = RobotHand(FOUR_FINGERS, "base_frame", {finger: sites[finger] for finger in fingers})
    result = Retargeter(robot).retarget(POSTURES["rest"])
    assert result.fingers == fingers
    assert result.positions.shape == (4 * len(fingers),)
    assert result.matched, result.reason
    if "thumb" not in fingers:
        assert np.all(result.opening_error == 0)


def test_fingers_are_measured_against_their_own_counterparts():
    pads = {"index": "index_pad", "little": "little_pad"}
    some = RobotHand(build_hand(), "palm", pads, knuckles={"little": "little_mcp"})
    assert np.allclose(Retargeter(some).finger_scale, 1.0)
    little = RobotHand(build_hand(), "palm", {"index": "little_pad"}, {"index": "little_mcp"})
    longer = LENGTHS["index"][0] / LENGTHS["little"][0]
    assert Retargeter(little).scale == pytest.approx(1 / longer, rel=0.1)


def test_what_cannot_match_is_a_result_that_says_whose_limit_it_is(robot):
    postures = np.array([POSTURES["flat"], POSTURES["tripod"]])
    wide = Retargeter(robot, opening_scale=5.0)
    result = wide.retarget(postures, max_gain=np.inf)
    assert not result.matched[0]
    assert "postures do not match; worst is thumb to" in result.reason
    assert "opens to" in result.reason and "choose a smaller opening_scale" in result.reason
    said = float(result.reason.split("opens to ")[1].split(" mm")[0])
    i = robot.fingers.index(result.reason.split("worst is thumb to ")[1].split()[0])
    wanted = np.linalg.norm(wide.targets(POSTURES["flat"])[1], axis=1)
    assert 1e3 * (wanted - result.opening_error[0])[i] < said + 1, "none opens further"
    spec = mujoco.MjSpec.from_file(str(FOUR_FINGERS))
    for joint in spec.joints:
        joint.range = [-1, 1]
    stiff = Retargeter(RobotHand(spec, "base_frame", TIPS)).retarget(POSTURES["tripod"])
    assert not stiff.matched and "comes no closer than" in stiff.reason


def test_the_thumb_may_stand_elsewhere(robot):
    """The whole thumb moved by 20 mm: openings match as before, its fingertip does not."""
    spec = mujoco.MjSpec.from_file(str(FOUR_FINGERS))
    thumb = spec.joint("thumb_roll").parent
    thumb.pos = thumb.pos + [0.0, 0.0, 0.02]
    q = POSTURES["tripod"]
    moved, here = (Retargeter(r).retarget(q) for r in (RobotHand(spec, "base_frame", TIPS), robot))
    assert moved.matched and here.matched
    assert moved.opening_error.max() < 2e-3


def test_coupled_joints_stay_coupled(reach):
    spec = mujoco.MjSpec.from_file(str(FOUR_FINGERS))
    for finger in ("f1", "f2", "f3"):
        spec.add_equality(
            type=mujoco.mjtEq.mjEQ_JOINT,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            name1=f"{finger}_end",
            name2=f"{finger}_middle",
            data=[0.0, 0.7, *[0.0] * 10],
        )
    robot = RobotHand(spec, "base_frame", TIPS)
    result = Retargeter(robot).retarget(reach[-3:])
    assert len(robot.lower) == 13
    assert result.matched.all(), result.reason
    at = result.joint_names.index
    middle, end = result.positions[:, at("f1_middle")], result.positions[:, at("f1_end")]
    assert np.allclose(end, 0.7 * middle)
    assert middle.min() > 0.1


def test_slope_and_curvature_of_the_residual(robot):
    """Against differences of the cost; the curvature where nothing is left over."""
    retargeter = Retargeter(robot)
    rng = np.random.default_rng(2)
    q = np.array([POSTURES["tripod"], POSTURES["rest"]])
    residuals = Residuals(robot, retargeter.targets_of(q), Weights(back=0.04), retargeter.unit)
    x = robot.lower + rng.uniform(0.2, 0.8, (2, 16)) * (robot.upper - robot.lower)
    slope = np.transpose(
        [(residuals.at(x + e).cost - residuals.at(x - e).cost) / 2e-6 for e in 1e-6 * np.eye(16)]
    )
    here = residuals.at(x)
    assert np.allclose(here.gradient, slope, atol=1e-6 * np.abs(slope).max())
    assert np.allclose(here.hessian, here.hessian.swapaxes(1, 2))
    assert np.linalg.eigvalsh(here.hessian).min() > 0


def test_the_same_postures_give_the_same_bits(robot, reach):
    first, again = (Retargeter(robot).retarget(reach[:3]).positions for _ in range(2))
    assert np.array_equal(first, again)


def test_bad_input_names_what_is_wrong(robot):
    retargeter = Retargeter(robot)
    with pytest.raises(InputError, match=r"\(16,\)"):
        retargeter.retarget(np.zeros(16))
    with pytest.raises(InputError, match=r"\(0, 22\)"):
        retargeter.retarget(np.zeros((0, 22)))
    with pytest.raises(InputError, match="finite"):
        retargeter.retarget(np.full(22, np.nan))
    with pytest.raises(InputError, match="step 0"):
        retargeter.retarget(np.zeros(22), max_step=0.0)
    with pytest.raises(InputError, match="gain -1"):
        retargeter.retarget(np.zeros(22), max_gain=-1.0)
    with pytest.raises(InputError, match="opening scale"):
        Retargeter(robot, opening_scale=-1.0)
    with pytest.raises(InputError, match="hand length"):
        Retargeter(robot, HandSize(2.0))


def test_followers_stay_within_both_limits_and_lines_are_what_the_actuators_do(tmp_path, reach):
    """Mimic with a slope and an offset, whose follower would leave its range first."""
    text = FOLLOWING.format(slope=1.4, offset=0.2, upper=1.5)
    (tmp_path / "hand.urdf").write_text(text)
    robot = RobotHand(tmp_path / "hand.urdf")
    result = Retargeter(robot).retarget(reach[::3])
    at = result.joint_names.index
    for finger in ("thumb", "index", "middle"):
        leader = result.positions[:, at(f"{finger}_1")]
        follower = result.positions[:, at(f"{finger}_2")]
        np.testing.assert_allclose(follower, 0.2 + 1.4 * leader, atol=1e-12)
        assert follower.max() <= 1.5 + 1e-9 and leader.min() >= -1e-9
        command = result.commands[:, result.actuator_names.index(f"{finger}_1")]
        np.testing.assert_allclose(command, leader, atol=1e-12)
    assert robot.upper[0] <= (1.5 - 0.2) / 1.4 + 1e-9


FOLLOWING = (
    '<robot name="h"><link name="palm"/>'
    + "".join(
        f'<link name="{f}_a"><collision><origin xyz=".02 0 0"/><geometry><box size=".04 .01 .01"/>'
        f'</geometry></collision></link><link name="{f}_b"><collision><origin xyz=".02 0 0"/>'
        '<geometry><box size=".04 .01 .01"/></geometry></collision></link>'
        f'<joint name="{f}_1" type="revolute"><parent link="palm"/><child link="{f}_a"/>'
        f'<origin xyz="{x} {y} {z}" rpy="{turn}"/><axis xyz="0 1 0"/>'
        '<limit lower="0" upper="1.5" effort="1" velocity="4"/></joint>'
        f'<joint name="{f}_2" type="revolute"><parent link="{f}_a"/><child link="{f}_b"/>'
        '<origin xyz=".045 0 0"/><axis xyz="0 1 0"/>'
        '<limit lower="0" upper="{upper}" effort="1" velocity="4"/>'
        f'<mimic joint="{f}_1" multiplier="{{slope}}" offset="{{offset}}"/></joint>'
        for f, x, y, z, turn in (
            ("thumb", 0.03, 0.03, -0.02, "-1.57 0 0.6"),
            ("index", 0.09, 0.02, 0.0, "0 0 0"),
            ("middle", 0.09, -0.01, 0.0, "0 0 0"),
        )
    )
    + "</robot>"
)


def test_no_coordinate_is_faster_than_the_file_says_where_times_are_given(tmp_path, reach):
    slow = FOLLOWING.format(slope=1.0, offset=0.0, upper=1.5).replace(
        'velocity="4"', 'velocity="0.5"'
    )
    (tmp_path / "hand.urdf").write_text(slow)
    retargeter = Retargeter(RobotHand(tmp_path / "hand.urdf"))
    assert (retargeter.robot.speed == 0.5).all()
    time = 0.04 * np.arange(len(reach))
    moved = np.abs(np.diff(retargeter.retarget(reach, time=time).positions, axis=0))
    assert moved.max() <= 0.5 * 0.04 + 1e-9
    assert moved.max() > 0.9 * 0.5 * 0.04, "it is what limits"
    with pytest.raises(InputError, match="do not increase"):
        retargeter.retarget(reach, time=np.zeros(len(reach)))


def test_links_that_would_run_into_each_other_stay_apart():
    """A fist: without looking, links would be 26 mm in each other."""
    spec = mujoco.MjSpec.from_file(str(FOUR_FINGERS))
    for geom in spec.geoms:
        geom.contype = geom.conaffinity = 1
    robot = RobotHand(spec, "base_frame", TIPS)
    q = np.linspace(POSTURES["rest"], POSTURES["fist"], 40)
    blind = Retargeter(robot, weights=Weights(contact=0.0)).retarget(q, max_gain=np.inf)
    seeing = Retargeter(robot).retarget(q, max_gain=np.inf)
    assert blind.penetration.max() > 0.02
    assert seeing.penetration.max() <= 0.002
    model, data = robot.model, mujoco.MjData(robot.model)
    parent = model.body_parentid
    for at in seeing.positions[::8]:
        data.qpos[model.jnt_qposadr[robot.joint_ids]] = at
        mujoco.mj_forward(model, data)
        for contact in data.contact[: data.ncon]:
            a, b = (int(model.geom_bodyid[g]) for g in contact.geom)
            assert parent[a] == b or parent[b] == a or contact.dist > -0.002


def test_a_posture_at_a_time_follows_the_movement(robot, reach):
    retargeter = Retargeter(robot)
    whole = retargeter.retarget(reach)
    free = robot.joint_map.free
    x = whole.positions[0][free]
    for q in reach[1:]:
        x = retargeter.follow(q, x, max_step=0.2)
    _, openings, _, _ = retargeter.targets(reach[-1])
    tips = robot.forward(x).points
    far, wanted = (np.linalg.norm(v, axis=1) for v in (tips - tips[0], openings))
    assert np.abs(far - wanted).max() < 0.003
    assert ((x >= robot.lower) & (x <= robot.upper)).all()


DATA = Path(__file__).parents[3] / "shared/data/robot_hands"


@pytest.mark.real_data
@pytest.mark.skipif(not DATA.is_dir(), reason="the robot hands are not beside the checkout")
@pytest.mark.parametrize(
    ("file", "most"),
    [("shadow_hand/right_hand.xml", 0.004), ("wonik_allegro/right_hand.xml", 0.006),
     ("leap_hand/leap_hand_right.urdf", 0.006)],
)  # fmt: skip
def test_published_hands_open_as_the_person_does(file, most):
    robot = RobotHand(DATA / file)
    recording = read_recordings(data_folder("assets") / "experiments")[6]
    result = Retargeter(robot, recording.hand).retarget(recording.q)
    assert result.opening_error[:, 1:].mean() <= most
    assert result.penetration.max() <= 0.002
    assert np.isfinite(result.commands).all()
    assert result.matched.all(), result.reason


def test_stretches_that_are_fitted_at_once_do_not_bind_one_another():
    whole = Movement(0.5, 10.0, np.full((5, 2), 0.1))
    x = np.array([[0.0, 0.0], [0.05, 0.0], [3.0, 1.0], [3.3, 1.0]])
    part = whole.part(np.array([0, 1, 4, 5]))
    bound = 0.5 * np.array([(0.5 * 0.05) ** 2, 0.0, (0.5 * 0.3) ** 2 + (10.0 * 0.2) ** 2])
    np.testing.assert_allclose(part.cost(x), bound)
    gradient, curvature = part.slopes(x)
    np.testing.assert_array_equal(gradient[1], 0.0)
    np.testing.assert_array_equal(curvature[1], 0.0)
    assert (curvature[[0, 2]] > 0).all()
