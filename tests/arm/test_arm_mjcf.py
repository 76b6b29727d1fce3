import mujoco
import numpy as np
import pytest

from handsim.arm.arm_geometry import ArmGeometry
from handsim.arm.arm_joints import ARM_JOINT_NAMES, CHAIN_LOWER, CHAIN_NAMES, CHAIN_UPPER
from handsim.arm.arm_strength import arm_gains, arm_torque_limits, leading_targets
from handsim.arm.mjcf import attach_arm, build_arm
from handsim.arm.reaching_arm import ReachingArm
from handsim.errors import InputError
from handsim.hand.anthropometry import HandGeometry
from handsim.joints import JOINT_NAMES
from handsim.physics import TIMESTEP, set_physics
from handsim.types import SIDES, HandSize


@pytest.fixture(scope="module", params=SIDES)
def size(request) -> HandSize:
    return HandSize(side=request.param)


@pytest.fixture(scope="module")
def model(size) -> mujoco.MjModel:
    return build_arm(size).compile()


def put(model, data, q) -> None:
    for name, angle in zip(CHAIN_NAMES, q, strict=True):
        data.joint(name).qpos[0] = angle
    mujoco.mj_forward(model, data)


def test_arm_first_then_the_hand(model) -> None:
    assert model.nq == model.nv == model.nu == 27
    assert [model.joint(i).name for i in range(5)] == list(ARM_JOINT_NAMES)
    actuators = [model.actuator(i).name for i in range(27)]
    assert actuators == [*ARM_JOINT_NAMES, *JOINT_NAMES]


def test_the_model_is_where_the_mathematics_says(model, size) -> None:
    data, arm = mujoco.MjData(model), ReachingArm(size)
    q = np.random.default_rng(0).uniform(CHAIN_LOWER, CHAIN_UPPER, (20, 7))
    pos, rotation = arm.palm(q[:, :5], q[:, 5:])
    for k in range(20):
        put(model, data, q[k])
        assert data.body("palm").xpos == pytest.approx(pos[k], abs=1e-12)
        assert data.body("palm").xmat.reshape(3, 3) == pytest.approx(rotation[k], abs=1e-12)
        shoulder = arm.geometry.shoulder()
        assert data.body("upper_arm").xpos == pytest.approx(shoulder)


def test_it_weighs_what_arms_weigh(model, size) -> None:
    geometry = ArmGeometry(size)
    mass = float(model.body_subtreemass[model.body("upper_arm").id])
    parts = geometry.upper_arm_inertia.mass + geometry.forearm_inertia.mass
    assert mass == pytest.approx(parts + HandGeometry(size).mass, rel=1e-6)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    elbow, stub = model.body("lower_arm").id, model.body("forearm").id
    depth = data.body("lower_arm").xpos[2] - data.xipos[[elbow, stub], 2]
    masses = model.body_mass[[elbow, stub]]
    assert masses @ depth / masses.sum() == pytest.approx(geometry.forearm_inertia.centre)
    about = model.body_inertia[[elbow, stub]].min(axis=1)
    assert (about > 1e-5).all()


def test_flesh_that_is_seen_neither_weighs_nor_touches(model) -> None:
    looks = [i for i in range(model.ngeom) if model.geom(i).name.endswith("_looks")]
    assert len(looks) > 15
    for i in looks:
        assert model.geom_contype[i] == model.geom_conaffinity[i] == 0
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.ncon == 0
    assert model.body_mass[model.body("trunk").id] == 0


def test_a_person_carries_the_arm_without_thought(model) -> None:
    data = mujoco.MjData(model)
    q = np.deg2rad([70.0, 50.0, -40.0, 80.0, 20.0, 0.0, 0.0])
    put(model, data, q)
    data.ctrl[:5] = q[:5]
    mujoco.mj_step(model, data, 500)
    held = [data.joint(name).qpos[0] for name in CHAIN_NAMES]
    assert held == pytest.approx(q, abs=1e-6)
    assert np.abs(data.actuator_force[:5]).max() < 1e-3


def test_torques_end_where_peoples_do(model, size) -> None:
    data = mujoco.MjData(model)
    data.ctrl[:5] = 20.0
    mujoco.mj_forward(model, data)
    assert data.actuator_force[:5] == pytest.approx(arm_torque_limits(ArmGeometry(size)))
    assert model.actuator_gainprm[:5, 0] == pytest.approx(arm_gains(ArmGeometry(size)), rel=1e-6)


def test_it_follows_a_reach_within_4_mm(size) -> None:
    arm = ReachingArm(size)
    flip = np.array([1, 1 if size.side == "right" else -1, 1])
    time = np.arange(0.0, 1.3, TIMESTEP)
    x = np.clip(time, 0, 1)[:, None]
    s = x**3 * (10 - 15 * x + 6 * x**2)
    pos = (np.array([-0.25, -0.22, 0.10]) + s * [0.14, 0.16, 0.05]) * flip
    quat = np.tile([0.9659, 0.0, 0.0, 0.2588 * flip[1]], (len(pos), 1))
    found = arm.posture(pos, quat)
    targets = leading_targets(found.arm, TIMESTEP, arm.geometry)
    model = build_arm(size).compile()
    data = mujoco.MjData(model)
    put(model, data, [*found.arm[0], *found.wrist[0]])
    wrist = [model.actuator(name).id for name in CHAIN_NAMES[5:]]
    off = []
    for k in range(len(pos)):
        data.ctrl[:5], data.ctrl[wrist] = targets[k], found.wrist[k]
        off.append(np.linalg.norm(data.body("palm").xpos - pos[k]))
        mujoco.mj_step(model, data)
    assert max(off) < 0.004
    assert off[-1] < 0.001


def test_two_arms_stand_in_one_scene() -> None:
    scene = mujoco.MjSpec()
    set_physics(scene)
    for side in SIDES:
        attach_arm(scene, HandSize(side=side), trunk=False, prefix=f"{side}_")
    model = scene.compile()
    assert model.nu == 54
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    right, left = (data.body(f"{side}_palm").xpos for side in SIDES)
    assert left == pytest.approx(right * [1, -1, 1])
    with pytest.raises(InputError, match="prefix"):
        attach_arm(scene, prefix="left_")


@pytest.mark.parametrize("stiffness", [0.01, 100.0, float("nan")])
def test_a_stiffness_no_arm_has_is_refused(stiffness) -> None:
    with pytest.raises(InputError, match="stiffness"):
        attach_arm(mujoco.MjSpec(), stiffness=stiffness)


def test_without_a_trunk_only_the_arm_is_there() -> None:
    scene = mujoco.MjSpec()
    attach_arm(scene, trunk=False)
    assert scene.body("trunk") is None
    assert scene.body("lower_arm") is not None
