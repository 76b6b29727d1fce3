from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from handsim.errors import FileError, InputError, UnknownNameError
from handsim.hand.anthropometry import HandGeometry, segment_names
from handsim.hand.export import write_hand
from handsim.hand.mjcf import ARMATURE, FRICTION, PASSING_PAIRS, attach_hand, build_hand, mount_hand
from handsim.hand.model import HandModel
from handsim.hand.population import PRESETS
from handsim.hand.postures import POSTURES
from handsim.hand.strength import FINGERTIP_FORCE, position_gains, torque_limits
from handsim.joints import FINGERS, JOINT_INDEX, JOINT_NAMES, JOINTS, LOWER, UPPER
from handsim.physics import CONTACT_SOLREF
from handsim.types import MEDIAN_HAND, HandSize

MODELS = Path(__file__).parents[2] / "models" / "hand"
SIDES = ("right", "left")
SEGMENTS = tuple(name for finger in FINGERS for name in segment_names(finger))


@pytest.fixture(scope="module")
def hand() -> HandModel:
    return HandModel.from_spec(build_hand())


def deepest(hand: HandModel) -> float:
    """Deepest penetration in the present state [m], 0 if nothing touches."""
    return -min((contact.dist for contact in hand.data.contact), default=0.0)


def run(hand: HandModel, seconds: float) -> None:
    for _ in range(round(seconds / hand.model.opt.timestep)):
        mujoco.mj_step(hand.model, hand.data)


# --- structure ---------------------------------------------------------------------------------


def test_22_hinges_and_22_actuators_in_glove_order(hand):
    model = hand.model
    assert model.nq == model.nv == model.nu == 22
    assert np.all(model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE)
    assert tuple(model.actuator(i).name for i in range(22)) == JOINT_NAMES
    assert sorted(hand.qpos_index) == list(range(22))
    assert np.array_equal(hand.ctrl_index, np.arange(22))
    for name, address in zip(JOINT_NAMES, hand.qpos_index, strict=True):
        assert model.joint(name).qposadr[0] == address


def test_everything_that_touches_is_an_ellipsoid(hand):
    model = hand.model
    touching = np.flatnonzero(model.geom_contype | model.geom_conaffinity)
    assert np.all(model.geom_type[touching] == mujoco.mjtGeom.mjGEOM_ELLIPSOID)
    names = {model.geom(i).name for i in touching}
    assert names >= {f"{segment}_geom" for segment in SEGMENTS}
    assert len(names) == len(HandGeometry().ellipsoids) + 1, "and the forearm"


def test_what_is_only_seen_has_no_mass(hand):
    model = hand.model
    seen = [i for i in range(model.ngeom) if model.geom(i).name.endswith(("_nail", "_knuckle"))]
    assert len(seen) == 5 + 10
    assert not model.geom_contype[seen].any()
    assert not model.geom_conaffinity[seen].any()
    bare = HandGeometry().mass
    assert model.body("palm").subtreemass[0] == pytest.approx(bare, rel=1e-9)
    assert 0.35 <= bare <= 0.55


@pytest.mark.parametrize("size", [(0.1933, 0.0883), (0.15, 0.12)])
def test_compiled_numbers_are_those_of_the_tables(size):
    hand, geometry = HandModel.from_spec(build_hand(HandSize(*size))), HandGeometry(HandSize(*size))
    model = hand.model
    gains, limits = position_gains(geometry), torque_limits(geometry)
    for i, joint in enumerate(JOINTS):
        limits_rad = np.deg2rad([joint.lower_deg, joint.upper_deg])
        assert np.allclose(model.joint(joint.name).range, limits_rad)
        actuator = model.actuator(joint.name)
        assert np.allclose(actuator.ctrlrange, limits_rad)
        assert np.allclose(actuator.forcerange, [-limits[i], limits[i]])
        assert actuator.gainprm[0] == pytest.approx(gains[i])
        assert actuator.biasprm[1] == pytest.approx(-gains[i])
        assert actuator.biasprm[2] < 0, "damped"
        assert model.joint(joint.name).armature[0] in ARMATURE.values()
    compared = 0
    for shape in geometry.ellipsoids:
        geom = model.geom(f"{shape.name}_geom")
        assert np.allclose(geom.size, shape.semi_axes)
        assert np.allclose(geom.friction, FRICTION)
        assert np.allclose(geom.solref, CONTACT_SOLREF)
        assert geom.condim[0] == 4
        assert geom.priority[0] == 1
        if shape.name in SEGMENTS:
            body = model.body(shape.name)
            assert body.mass[0] == pytest.approx(shape.mass, rel=1e-9)
            assert sorted(body.inertia) == pytest.approx(sorted(shape.inertia), rel=1e-9)
            compared += 1
    assert compared == 15


def test_solver_is_the_one_the_hand_was_tried_with(hand):
    option = hand.model.opt
    assert option.timestep == 0.002
    assert option.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert option.solver == mujoco.mjtSolver.mjSOL_NEWTON
    assert option.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    assert option.impratio == 10
    assert option.noslip_iterations == 2
    assert np.all(hand.model.body_gravcomp[1:] == 1)


def test_sensors_of_every_joint_and_fingertip(hand):
    q = np.clip(POSTURES["rest"] + 0.01, LOWER, UPPER)
    hand.set_posture(q)
    for i, name in enumerate(JOINT_NAMES):
        assert hand.data.sensor(f"{name}_position").data[0] == pytest.approx(q[i])
        assert hand.data.sensor(f"{name}_velocity").data[0] == 0
        force = hand.data.actuator_force[hand.ctrl_index[i]]
        assert hand.data.sensor(f"{name}_force").data[0] == pytest.approx(force)
    assert hand.model.nsensor == 3 * 22 + 5


# --- size, side, reach -------------------------------------------------------------------------


def test_middle_fingertip_is_at_99_percent_of_hand_length_and_scales():
    reach = {}
    for length in (0.13, 0.1933, 0.26):
        hand = HandModel.from_spec(build_hand(HandSize(length)))
        hand.set_posture(np.zeros(22))
        tip = hand.fingertips()[2]
        assert tip == pytest.approx([0.99 * length, 0, 0], abs=1e-9)
        geom = hand.model.geom("middle_distal_geom")
        end = hand.data.geom("middle_distal_geom").xpos[0] + geom.size[0]
        assert end == pytest.approx(tip[0], abs=1e-9), "the segment ends at the fingertip"
        reach[length] = np.linalg.norm(tip)
    assert reach[0.26] == pytest.approx(2 * reach[0.13], rel=1e-9)


@pytest.mark.parametrize("preset", PRESETS)
def test_left_hand_is_the_exact_mirror_image(preset):
    right, left = (
        HandModel.from_spec(build_hand(replace(PRESETS[preset], side=side))) for side in SIDES
    )
    assert right.model.ngeom == left.model.ngeom > 30
    flip = np.array([1, -1, 1])
    q_random = np.random.default_rng(2).uniform(LOWER, UPPER, size=(5, 22))
    for q in (*POSTURES.values(), *q_random):
        for hand in (right, left):
            hand.set_posture(q)
        for kind in ("geom_xpos", "site_xpos", "xipos"):
            assert np.allclose(
                getattr(left.data, kind), getattr(right.data, kind) * flip, rtol=0, atol=1e-12
            )
        for kind in ("xmat", "geom_xmat", "site_xmat"):
            turned = getattr(right.data, kind).reshape(-1, 3, 3) * np.outer(flip, flip)
            assert np.allclose(
                getattr(left.data, kind).reshape(-1, 3, 3), turned, rtol=0, atol=1e-12
            )
    assert np.allclose(left.model.body_mass, right.model.body_mass, rtol=1e-12)


# --- motion ------------------------------------------------------------------------------------


def test_every_joint_reaches_both_ends_of_its_range(hand):
    """One joint at a time, with the other fingers and the palm out of its way."""
    for i, joint in enumerate(JOINTS):
        for end in (LOWER[i], UPPER[i]):
            q = np.zeros(22)
            if joint.finger == "thumb":
                q[[JOINT_INDEX["thumb_rotation"], JOINT_INDEX["thumb_abduction"]]] = 1.0, 0.9
            elif joint.motion == "abduction":
                others = [f for f in FINGERS[1:] if f != joint.finger]
                q[[JOINT_INDEX[f"{finger}_mcp"] for finger in others]] = 0.8
            hand.set_posture(q)
            hand.data.ctrl[hand.ctrl_index[i]] = end
            run(hand, 0.4)
            assert np.rad2deg(abs(hand.q[i] - end)) < 2, f"{joint.name} to {np.rad2deg(end):.0f}"


def test_targets_beyond_the_range_are_cut_off(hand):
    ends = []
    for target in (UPPER, np.full(22, 10.0)):
        mujoco.mj_resetData(hand.model, hand.data)
        hand.data.ctrl[:] = target
        run(hand, 0.2)
        ends.append(hand.q.copy())
    assert np.array_equal(*ends)
    assert np.any(ends[0] > 1.0)


def test_index_at_its_torque_limit_pushes_with_the_stated_force(hand):
    hand.set_posture(np.zeros(22))
    jacobian = np.zeros((3, 22))
    mujoco.mj_jacSite(hand.model, hand.data, jacobian, None, hand.tip_site[1])
    dof = hand.qvel_index[JOINT_INDEX["index_mcp"]]
    limit = hand.model.actuator("index_mcp").forcerange[1]
    assert limit / -jacobian[2, dof] == pytest.approx(FINGERTIP_FORCE, rel=1e-9)


def test_fingertip_that_pushes_is_felt_by_its_touch_sensor():
    """10 deg past the surface at the MCP joint: about 1.3 N a degree, less what bends back."""
    spec = build_hand()
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.02, 0.02, 0.01], pos=[0.178, 0.022, -0.0185]
    )
    hand = HandModel.from_spec(spec)
    hand.set_posture(np.zeros(22))
    hand.data.ctrl[hand.ctrl_index[JOINT_INDEX["index_mcp"]]] = np.deg2rad(10)
    run(hand, 0.5)
    touch = {finger: hand.data.sensor(f"{finger}_touch").data[0] for finger in FINGERS}
    assert 4 < touch["index"] < 14
    assert touch["middle"] == touch["thumb"] == 0


@pytest.mark.parametrize("side", SIDES)
def test_ten_seconds_of_control_noise_raise_no_warning(side):
    hand = HandModel.from_spec(build_hand(HandSize(side=side)))
    low, high = hand.model.actuator_ctrlrange.T
    rng = np.random.default_rng(7)
    start = hand.data.ctrl.copy()
    for _ in range(100):  # a new target every 0.1 s
        target = rng.uniform(low, high)
        for _ in range(50):
            start += 0.1 * (target - start)
            hand.data.ctrl[:] = start
            mujoco.mj_step(hand.model, hand.data)
        assert deepest(hand) < 0.006
    assert hand.data.time == pytest.approx(10)
    assert not hand.data.warning.number.any()
    assert np.all(hand.q > LOWER - 0.2)
    assert np.all(hand.q < UPPER + 0.2)


def test_targets_are_reached_without_overshoot(hand):
    hand.set_posture(np.zeros(22))
    goal = 0.9 * POSTURES["rest"]
    hand.data.ctrl[:] = goal
    largest = np.zeros(22)
    for _ in range(500):
        mujoco.mj_step(hand.model, hand.data)
        largest = np.maximum(largest, hand.q * np.sign(goal))
    assert np.allclose(hand.q, goal, atol=np.deg2rad(0.5))
    assert np.all(largest <= abs(goal) + np.deg2rad(3))


# --- bases -------------------------------------------------------------------------------------


def test_carried_hand_follows_its_target_and_leaves_other_bodies_alone():
    scene = mujoco.MjSpec()
    other = scene.worldbody.add_body(name="other", pos=[1, 0, 1])
    other.add_freejoint()
    other.add_geom(size=[0.01, 0, 0])
    attach_hand(scene, HandSize(side="left"), (0.1, 0.2, 0.3), (0, 1, 0, 0))
    hand = HandModel.from_spec(scene)
    assert (hand.model.nq, hand.model.nv, hand.model.nu) == (7 + 7 + 22, 6 + 6 + 22, 22)
    assert hand.model.geom_priority[hand.model.body("other").geomadr[0]] == 0
    run(hand, 0.3)
    assert np.allclose(hand.data.body("forearm").xpos, [0.1, 0.2, 0.3], atol=1e-4), "carried"
    for step in range(500):
        hand.data.mocap_pos[0] = [0.1 + 0.2 * min(1, step / 300), 0.2, 0.3]
        mujoco.mj_step(hand.model, hand.data)
    assert np.allclose(hand.data.body("forearm").xpos, [0.3, 0.2, 0.3], atol=1e-3)
    assert not hand.data.warning.number.any()


def test_hand_mounted_on_an_arm_moves_with_it():
    arm = mujoco.MjSpec()
    link = arm.worldbody.add_body(name="link")
    link.add_joint(name="elbow", axis=[0, 0, 1])
    link.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CAPSULE, fromto=[0, 0, 0, -0.2, 0, 0], size=[0.02, 0, 0]
    )
    mount_hand(arm, body="link", pos=(0.3, 0, 0))
    hand = HandModel.from_spec(arm)
    assert hand.model.nq == 23
    hand.data.qpos[hand.model.joint("elbow").qposadr[0]] = np.pi / 2
    mujoco.mj_forward(hand.model, hand.data)
    assert hand.fingertips()[2] == pytest.approx([0, 0.3 + 0.99 * 0.1933, 0], abs=1e-9)


def two_hands() -> tuple[mujoco.MjSpec, dict[str, str]]:
    """A right and a left hand side by side, and the prefixes of their names."""
    scene, prefixes = mujoco.MjSpec(), {"right": "", "left": "left_"}
    attach_hand(scene, HandSize(), (0.0, -0.2, 0.3))
    attach_hand(scene, HandSize(side="left"), (0.0, 0.2, 0.3), prefix="left_")
    return scene, prefixes


def test_two_hands_stand_in_one_scene_as_each_would_alone():
    scene, prefixes = two_hands()
    hands = {side: HandModel.from_spec(scene, prefix) for side, prefix in prefixes.items()}
    model = hands["left"].model
    assert (model.nq, model.nu) == (2 * (7 + 22), 2 * 22)
    assert model.nexclude == 2 * len(PASSING_PAIRS)
    for side, hand in hands.items():
        alone = mujoco.MjSpec()
        attach_hand(alone, HandSize(side=side), (0.0, -0.2 if side == "right" else 0.2, 0.3))
        expected = HandModel.from_spec(alone)
        for both in (hand, expected):
            both.set_posture(POSTURES["fist"])
        np.testing.assert_allclose(hand.fingertips(), expected.fingertips(), atol=1e-9)
        for name in ("actuator_gainprm", "actuator_forcerange"):
            np.testing.assert_array_equal(
                getattr(hand.model, name)[hand.ctrl_index],
                getattr(expected.model, name)[expected.ctrl_index],
            )
        body, other = hand.model.body(f"{prefixes[side]}palm"), expected.model.body("palm")
        np.testing.assert_allclose(body.subtreemass, other.subtreemass)


def test_two_hands_move_apart_and_keep_their_bases():
    scene, prefixes = two_hands()
    hand = HandModel.from_spec(scene, "left_")
    right = HandModel.from_spec(scene).ctrl_index
    hand.data.ctrl[hand.ctrl_index] = POSTURES["fist"]
    mujoco.mj_forward(hand.model, hand.data)
    mujoco.mj_step(hand.model, hand.data, nstep=500)
    np.testing.assert_allclose(hand.q, POSTURES["fist"], atol=0.25)
    assert np.abs(hand.data.ctrl[right]).max() == 0
    assert hand.q[JOINT_NAMES.index("index_mcp")] > 0.5
    for side, y in (("right", -0.2), ("left", 0.2)):
        base = hand.data.body(f"{prefixes[side]}forearm").xpos
        np.testing.assert_allclose(base, [0.0, y, 0.3], atol=2e-3)
    assert not hand.data.warning.number.any()


def test_a_second_hand_of_the_same_names_is_refused():
    scene = mujoco.MjSpec()
    attach_hand(scene)
    before = len(scene.bodies)
    for place in (attach_hand, mount_hand):
        with pytest.raises(InputError, match="prefix such as 'left_'"):
            place(scene, HandSize(side="left"))
    assert len(scene.bodies) == before


def test_wrong_sizes_sides_and_bodies_are_errors():
    with pytest.raises(InputError, match=r"0\.12 to 0\.26"):
        build_hand(HandSize(2.0))
    with pytest.raises(UnknownNameError, match="right"):
        build_hand(HandSize(side="rigth"))
    with pytest.raises(UnknownNameError, match="world"):
        mount_hand(mujoco.MjSpec(), body="worlt")


# --- files -------------------------------------------------------------------------------------


@pytest.mark.parametrize("side", SIDES)
def test_written_hand_is_the_built_one_for_plain_mujoco(side):
    model = mujoco.MjModel.from_xml_path(str(MODELS / f"{side}_hand.xml"))
    built = HandModel.from_spec(build_hand(HandSize(side=side)))
    assert (model.nq, model.nu) == (22, 22)
    for field in (
        "geom_size",
        "geom_pos",
        "body_pos",
        "body_quat",
        "body_mass",
        "jnt_axis",
        "actuator_gainprm",
        "actuator_biasprm",
        "actuator_forcerange",
        "actuator_ctrlrange",
        "actuator_ctrlspec",
    ):
        assert np.allclose(getattr(model, field), getattr(built.model, field), atol=1e-5)
    model = mujoco.MjModel.from_xml_path(str(MODELS / f"scene_{side}.xml"))
    data = mujoco.MjData(model)
    names = {model.key(i).name for i in range(model.nkey)}
    assert names >= set(POSTURES)
    for name, q in POSTURES.items():
        mujoco.mj_resetDataKeyframe(model, data, model.key(name).id)
        assert np.allclose(data.qpos[built.qpos_index], q, atol=1e-5)
        assert np.allclose(data.ctrl, q, atol=1e-5)


@pytest.mark.parametrize("which", [*SIDES, "both"])
def test_scenes_stay_in_their_keyframes(which):
    model = mujoco.MjModel.from_xml_path(str(MODELS / f"scene_{which}.xml"))
    data = mujoco.MjData(model)
    assert model.nkey == 11
    for key in range(model.nkey):
        mujoco.mj_resetDataKeyframe(model, data, key)
        start = data.qpos.copy()
        mujoco.mj_step(model, data, nstep=500)
        assert np.rad2deg(np.abs(data.qpos - start).max()) < 3, model.key(key).name
    assert not data.warning.number.any()


def test_folder_is_made_unless_something_is_in_its_place(tmp_path):
    assert write_hand(MEDIAN_HAND, tmp_path / "new" / "folder").is_file()
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="choose another"):
        write_hand(MEDIAN_HAND, tmp_path / "file")
    with pytest.raises(InputError):
        write_hand(HandSize(2.0), tmp_path / "never")
    assert not (tmp_path / "never").exists()
