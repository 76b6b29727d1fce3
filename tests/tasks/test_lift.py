"""Left hands grasp own objects as they are, by the mirror image of a right hand's grasp."""

from pathlib import Path

import mujoco
import numpy as np
import numpy.typing as npt
import pytest
import trimesh

from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.plan_key import key_for, object_content
from handsim.grasping.planning.trials.laying import lay_out
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.objects.grasp import Grasp
from handsim.objects.mesh_import import object_from_mesh
from handsim.objects.mirror import mirrored, mirrored_grasp
from handsim.objects.object import GraspObject
from handsim.objects.proposals import Proposal, propose_grasps
from handsim.tasks.lift import lift_task
from handsim.types import Array, HandSize

LEFT = Conditions(hand=HandSize(side="left"), base="free")
MIRROR = np.array([1.0, -1.0, 1.0])
DRAWN, TOUCHED = np.eye(6, dtype=np.uint8)[2:4]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A block with a peg that points forwards and to the left, and both as ready pieces."""
    folder = tmp_path_factory.mktemp("pegged")
    block = trimesh.creation.box((0.04, 0.05, 0.08)).apply_translation((0.0, 0.0, 0.04))
    peg = trimesh.creation.box((0.012, 0.040, 0.012)).apply_translation((0.012, 0.044, 0.06))
    (folder / "pieces").mkdir()
    for name, each in (("block", block), ("peg", peg)):
        each.export(folder / "pieces" / f"{name}.stl")
    trimesh.util.concatenate([block, peg]).export(folder / "pegged.stl")
    return folder


@pytest.fixture(scope="module")
def pegged(folder: Path) -> GraspObject:
    return object_from_mesh(folder / "pegged.stl", 0.1, pieces=folder / "pieces")


@pytest.fixture(scope="module")
def proposals(pegged: GraspObject) -> tuple[Proposal, ...]:
    return propose_grasps(pegged, "left")


@pytest.fixture(scope="module")
def scene(pegged: GraspObject, proposals: tuple[Proposal, ...]) -> Scene:
    return Scene.build(lift_task(pegged, proposals[0].grasp, side="left"), LEFT)


def test_a_left_hand_meets_the_object_as_it_is(pegged: GraspObject, scene: Scene) -> None:
    """In what is drawn, in what is touched, and in where its mass is."""
    as_it_is = Scene.build(lift_task(pegged), Conditions(base="free"))
    for group in (DRAWN, TOUCHED):
        expected = silhouette(as_it_is, group)
        assert np.abs(expected - silhouette(as_it_is, group, MIRROR)).max() > 0.01
        np.testing.assert_allclose(silhouette(scene, group), expected, atol=1e-6)
    np.testing.assert_allclose(
        scene.model.body("object").ipos, as_it_is.model.body("object").ipos, atol=1e-9
    )
    assert scene.model.body("object").ipos[1] != pytest.approx(0.0, abs=1e-4)
    np.testing.assert_array_equal(scene.front, as_it_is.front)
    assert object_content(scene.object)["shapes"][1:] == object_content(pegged)["shapes"][1:]


def silhouette(scene: Scene, group: npt.NDArray[np.uint8], seen: Array | float = 1.0) -> Array:
    """Return how far level rays in the object's frame get to it, 1 where they miss it [m]."""
    model, data = scene.model, mujoco.MjData(scene.model)
    mujoco.mj_forward(model, data)
    body, hit = data.body("object"), np.zeros(1, np.int32)
    turn = body.xmat.reshape(3, 3)
    depths: list[float] = []
    for along in np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]]):
        for aside in np.linspace(-0.06, 0.06, 25) + 0.0007:
            across = np.array([-along[1], along[0], 0.0])
            start = (aside * across - 0.5 * along + [0, 0, 0.0607]) * seen
            depth = mujoco.mj_ray(
                model, data, body.xpos + turn @ start, turn @ (along * seen), group, 1, -1, hit
            )
            of_object = depth >= 0 and model.geom_bodyid[hit[0]] == body.id
            depths.append(depth if of_object else 1.0)
    return np.array(depths)


def test_its_grasps_are_the_right_hands_on_the_mirror_image(
    pegged: GraspObject, proposals: tuple[Proposal, ...]
) -> None:
    of_image = propose_grasps(mirrored(pegged))
    assert [each.grasp for each in proposals] == [mirrored_grasp(each.grasp) for each in of_image]
    assert [each.cost for each in proposals] == [each.cost for each in of_image]
    of_right = propose_grasps(pegged)
    assert {palm(each.grasp) for each in of_right if each.grasp.kind == "side"} == {1.0}
    assert {palm(each.grasp) for each in proposals if each.grasp.kind == "side"} == {-1.0}


def palm(grasp: Grasp) -> float:
    """Return 1 where the palm of a hand whose fingers point along the opposition faces left."""
    leftward = np.cross([0.0, 0.0, 1.0], grasp.opposition)
    return float(np.round(leftward @ grasp.approach, 6))


def test_the_grasps_lie_on_what_is_on_the_table(
    pegged: GraspObject, proposals: tuple[Proposal, ...]
) -> None:
    """Of a right hand's grasps, mirrored on the same object, some would not."""
    assert lift_task(pegged, side="left").for_side("left").grasp == proposals[0].grasp
    for proposal in proposals[:8]:
        task = lift_task(pegged, proposal.grasp, side="left")
        assert task.for_side("left").grasp == proposal.grasp
        np.testing.assert_allclose(depths_of_pads(Scene.build(task, LEFT)), 0.005, atol=2e-4)
    wrong = (lift_task(pegged, each.grasp) for each in propose_grasps(pegged)[:8])
    off = [np.abs(depths_of_pads(Scene.build(task, LEFT)) - 0.005).max() for task in wrong]
    assert max(off) > 0.002


def depths_of_pads(scene: Scene) -> Array:
    """Return how far from 5 mm outside of each pad the object is, in the scene of a grasp [m]."""
    model, data, grasp = scene.model, mujoco.MjData(scene.model), scene.task.grasp
    mujoco.mj_forward(model, data)
    body, hit = data.body("object"), np.zeros(1, np.int32)
    turn = body.xmat.reshape(3, 3)
    axis = np.array(grasp.opposition)
    out = grasp.width / 2 + 0.005
    return np.array(
        [
            mujoco.mj_ray(
                model, data, body.xpos + turn @ (grasp.point + out * side), turn @ -side,
                TOUCHED, 1, -1, hit,
            )
            for side in (-axis, axis)
        ]
    )  # fmt: skip


def test_what_is_laid_out_is_told_in_the_frame_of_the_object(pegged: GraspObject) -> None:
    laid = lay_out(pegged, LEFT, 3)
    best = propose_grasps(pegged, "left")
    for each in laid:
        assert each.proposal in best
        assert each.task.for_side("left").grasp == each.proposal.grasp


def test_plans_of_the_two_hands_are_told_apart_and_found_again(pegged: GraspObject) -> None:
    key = key_for(lift_task(pegged, side="left"), LEFT)
    assert key_for(lift_task(pegged, side="left"), LEFT) == key
    right = Conditions(base="free")
    assert key_for(lift_task(pegged), right).object == key.object  # the one object
    assert key_for(lift_task(pegged), right).task != key.task
    assert key_for(lift_task(mirrored(pegged)), right).object != key.object
