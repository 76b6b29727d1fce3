"""Hands and scenes for MJX and mujoco_warp: what changes, what does not, and how they move."""

import mujoco
import numpy as np
import pytest

from handsim.errors import UnknownNameError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.plan_store import shipped_plans
from handsim.grasping.planning.planner import run_plan
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.record import Rollout
from handsim.hand.mjcf import build_hand
from handsim.learning.controller import GraspController
from handsim.tasks.scene import build_scene
from handsim.tasks.table_one import task_by_name
from handsim.tasks.variants import (
    CAPSULES,
    NO_NOSLIP,
    NO_SELF_CONTACT,
    capsules_of,
    for_simulator,
)
from handsim.types import HandSize

TASK = task_by_name("cube-raise")
CAPSULE, ELLIPSOID = mujoco.mjtGeom.mjGEOM_CAPSULE, mujoco.mjtGeom.mjGEOM_ELLIPSOID


def variant(simulator: str, **options) -> tuple[mujoco.MjModel, tuple[str, ...]]:
    spec = build_scene(TASK, **options)
    said = for_simulator(spec, simulator)
    return spec.compile(), said


def touching(model: mujoco.MjModel) -> list[int]:
    return np.flatnonzero(model.geom_contype | model.geom_conaffinity).tolist()


def of_hand(model: mujoco.MjModel) -> list[int]:
    root = model.body("forearm").rootid[0]
    return [i for i in touching(model) if model.body_rootid[model.geom_bodyid[i]] == root]


@pytest.mark.parametrize("semi_axes", [(0.03, 0.01, 0.01), (0.012, 0.04, 0.023), (0.01,) * 3])
def test_capsules_are_as_long_as_broad_and_as_thick_as_the_ellipsoid(semi_axes) -> None:
    (radius, half), axis, places = capsules_of(semi_axes)
    ends = np.abs(places[:, None] + np.array([-1, 1])[:, None] * half * axis).reshape(-1, 3)
    assert ends.max(axis=0) + radius == pytest.approx(semi_axes, abs=2e-6)
    assert radius == min(semi_axes)
    assert len(places) == (2 if len(set(semi_axes)) == 3 else 1)
    assert places.sum(axis=0) == pytest.approx(np.zeros(3))


@pytest.mark.parametrize("options", [{}, {"friction": 0.4, "base": "free"}, {"left": True}])
def test_a_scene_for_mjx_has_no_contact_that_mjx_lacks_and_weighs_the_same(options) -> None:
    size = HandSize(side="left" if options.pop("left", False) else "right")
    original = build_scene(TASK, size, **options).compile()
    model, said = variant("mjx", hand=size, **options)
    assert said == (NO_NOSLIP, CAPSULES, NO_SELF_CONTACT)
    assert model.opt.noslip_iterations == 0
    assert ELLIPSOID not in model.geom_type[touching(model)]
    hand = of_hand(model)
    assert len(hand) > len(of_hand(original)) > 20, "the palm is broad"
    assert (model.geom_type[hand] == CAPSULE).all()
    for name in ("geom_friction", "geom_condim", "geom_priority", "geom_solref"):
        expected = getattr(original, name)[original.geom("thumb_distal_geom").id]
        assert (getattr(model, name)[hand] == expected).all(), name
    for name in ("body_mass", "body_inertia", "body_ipos", "jnt_range", "actuator_gainprm"):
        np.testing.assert_allclose(getattr(model, name), getattr(original, name), atol=1e-12)


def test_a_file_of_the_variant_is_the_variant() -> None:
    spec = build_scene(TASK)
    for_simulator(spec, "mjx")
    model = spec.compile()
    read = mujoco.MjModel.from_xml_string(spec.to_xml())
    for name in ("body_mass", "body_inertia", "geom_size", "geom_type", "geom_contype"):
        expected = getattr(model, name)
        np.testing.assert_allclose(getattr(read, name), expected, rtol=1e-4, atol=1e-9)


def test_capsules_lie_where_ellipsoids_were() -> None:
    """Both reach as far along the axes of the ellipsoid's own frame."""
    original = build_scene(TASK).compile()
    model, _ = variant("mjx")
    compared = 0
    for i in of_hand(original):
        name = original.geom(i).name
        frame = np.empty(9)
        mujoco.mju_quat2Mat(frame, original.geom(i).quat)
        reach = np.zeros(3)
        for part in (name, f"{name}_beside"):
            if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_GEOM, part) < 0:
                continue
            axis = np.empty(9)
            mujoco.mju_quat2Mat(axis, model.geom(part).quat)
            radius, half, _ = model.geom(part).size
            offset = frame.reshape(3, 3).T @ (model.geom(part).pos - original.geom(i).pos)
            along = frame.reshape(3, 3).T @ axis.reshape(3, 3)[:, 2]
            reach = np.maximum(reach, np.abs(offset) + half * np.abs(along) + radius)
        assert reach == pytest.approx(original.geom(i).size, abs=5e-6), name
        compared += 1
    assert compared > 20


def test_for_mjx_the_hand_touches_all_but_itself() -> None:
    model, _ = variant("mjx")
    hand = of_hand(model)
    others = [i for i in touching(model) if i not in hand]
    kinds, affinities = model.geom_contype, model.geom_conaffinity

    def touch(a: int, b: int) -> bool:
        return bool(kinds[a] & affinities[b] or kinds[b] & affinities[a])

    assert len(others) >= 2
    assert all(touch(i, j) for i in hand for j in others)
    assert all(touch(i, j) for i in others for j in others)
    assert not any(touch(i, j) for i in hand for j in hand)


def test_a_hand_alone_keeps_its_ellipsoids_for_mjx() -> None:
    spec = build_hand()
    assert for_simulator(spec, "mjx") == (NO_NOSLIP,)
    model = spec.compile()
    assert (model.geom_type[touching(model)] == ELLIPSOID).all()
    assert model.opt.noslip_iterations == 0


def test_mujoco_warp_takes_scenes_as_they_are() -> None:
    spec, same = build_scene(TASK), build_scene(TASK)
    assert for_simulator(spec, "warp") == ()
    spec.compile(), same.compile()
    assert spec.to_xml() == same.to_xml()


def test_another_simulator_is_an_error_that_names_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="did you mean mjx"):
        for_simulator(build_hand(), "mjxx")


# --- how they move: a second of the same controls ------------------------------------------------


@pytest.fixture(scope="module")
def grasp() -> Rollout:
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    nominal = Conditions()
    plan = shipped_plans(controller.digest, nominal).read()[TASK.name]
    run = run_plan(controller, Scene.build(TASK, nominal), plan)
    assert run.outcome.success
    return run


STARTS = (1.5, 4.3)
"""Whence a second is compared [s]: squeeze and lift, and hold."""
DRIFT = {"hand": np.deg2rad(1.0), "object": 0.0015}
"""How far joints [rad] and object [m] of MJX's variant may be from the original."""
NEAR = {"hand": np.deg2rad(0.3), "object": 5e-4}
"""How far another simulator may be from MuJoCo with the same model."""


def first_of(run: Rollout) -> list[int]:
    return [int(np.searchsorted(run.time, start)) for start in STARTS]


def stepped(model: mujoco.MjModel, run: Rollout) -> np.ndarray:
    """A second of MuJoCo with a run's controls from each start, (2, 100, nq)."""
    made = []
    for first in first_of(run):
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = run.qpos[first], run.qvel[first]
        for ctrl in run.ctrl[first : first + 100]:
            data.ctrl[:] = ctrl
            mujoco.mj_step(model, data, 5)
            made.append(data.qpos.copy())
    return np.array(made).reshape(2, 100, -1)


def apart(model: mujoco.MjModel, one: np.ndarray, other: np.ndarray) -> dict[str, float]:
    """How far joints [rad] and object [m] are apart at most."""
    free = int(model.joint("object_joint").qposadr[0])
    difference = np.abs(one - other)
    joints = np.delete(difference, range(free, free + 7), axis=-1)
    return {"hand": joints.max(), "object": difference[..., free : free + 3].max()}


def test_the_variant_for_mjx_grasps_and_holds_nearly_as_the_original(grasp) -> None:
    original, (model, _) = build_scene(TASK).compile(), variant("mjx")
    known, made = stepped(original, grasp), stepped(model, grasp)
    height = int(model.joint("object_joint").qposadr[0]) + 2
    assert made[0, -1, height] > 0.1, "it is lifted"
    for name, distance in apart(model, known, made).items():
        assert 0 < distance < DRIFT[name], name


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_mujoco_warp_moves_as_mujoco_does(grasp) -> None:
    mujoco_warp = pytest.importorskip("mujoco_warp", reason="handsim[warp] is not installed")
    model, _ = variant("warp")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    there = mujoco_warp.put_model(model)
    worlds = mujoco_warp.put_data(model, data, nworld=2, nconmax=100, njmax=400)
    at = first_of(grasp)
    worlds.qpos.assign(grasp.qpos[at].astype(np.float32))
    worlds.qvel.assign(grasp.qvel[at].astype(np.float32))
    made = []
    for tick in range(100):
        worlds.ctrl.assign(grasp.ctrl[[first + tick for first in at]].astype(np.float32))
        for _ in range(5):
            mujoco_warp.step(there, worlds)
        made.append(worlds.qpos.numpy().copy())
    found = apart(model, stepped(model, grasp), np.stack(made, axis=1))
    for name, distance in found.items():
        assert distance < NEAR[name], found


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cube-raise", "jar-unscrew", None])
def test_mjx_takes_scenes_and_the_hand_alone(name) -> None:
    """What a variant is for: MJX refuses the scenes themselves."""
    pytest.importorskip("jax", reason="mujoco-mjx is not installed")
    mjx = pytest.importorskip("mujoco.mjx", reason="mujoco-mjx is not installed")

    def made() -> mujoco.MjSpec:
        return build_hand() if name is None else build_scene(task_by_name(name))

    if name is not None:
        with pytest.raises(NotImplementedError, match="ELLIPSOID"):
            mjx.put_model(made().compile())
    spec = made()
    for_simulator(spec, "mjx")
    assert mjx.put_model(spec.compile()).nv > 20


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_mjx_moves_as_mujoco_does(grasp) -> None:
    """A second of the variant's steps by MJX, from both starts at once, beside MuJoCo's."""
    jax = pytest.importorskip("jax", reason="mujoco-mjx is not installed")
    mjx = pytest.importorskip("mujoco.mjx", reason="mujoco-mjx is not installed")
    model, _ = variant("mjx")
    there, at = mjx.put_model(model), first_of(grasp)

    def second(qpos, qvel, controls):
        data = mjx.make_data(model).replace(qpos=qpos, qvel=qvel)

        def tick(data, ctrl):
            commanded = data.replace(ctrl=ctrl)
            after = jax.lax.fori_loop(0, 5, lambda _, each: mjx.step(there, each), commanded)
            return after, after.qpos

        return jax.lax.scan(tick, data, controls)[1]

    controls = np.array([grasp.ctrl[first : first + 100] for first in at])
    made = jax.jit(jax.vmap(second))(grasp.qpos[at], grasp.qvel[at], controls)
    found = apart(model, stepped(model, grasp), np.asarray(made))
    for name, distance in found.items():
        assert distance < NEAR[name], found
