from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from handsim.errors import InputError
from handsim.objects.mesh_import import object_from_mesh
from handsim.objects.mjcf import OBJECTS
from handsim.objects.object import (
    Collider,
    GraspObject,
    Piece,
    TriangleMesh,
    box,
    drum,
    ring,
)
from handsim.objects.proposals import (
    MOST_TRIED,
    REACH,
    WIDTH_RANGE,
    Proposal,
    propose_grasps,
    short_list,
)
from handsim.tasks.lift import lift_task
from handsim.tasks.scene import build_scene, hand_axes
from handsim.types import HandSize


def own(mesh: trimesh.Trimesh, folder: Path) -> GraspObject:
    mesh.export(folder / "own.stl")
    return object_from_mesh(folder / "own.stl", 0.1)


def test_a_box_is_taken_across_its_narrow_sides_at_its_middle(tmp_path: Path) -> None:
    best = propose_grasps(own(trimesh.creation.box((0.12, 0.04, 0.06)), tmp_path))[0]
    assert abs(best.grasp.opposition[1]) == pytest.approx(1.0)
    assert best.grasp.width == pytest.approx(0.04, abs=1e-6)
    np.testing.assert_allclose(best.grasp.point, [0.0, 0.0, 0.03], atol=1e-6)
    assert best.facing_deg < 0.1
    assert best.lever < 1e-6


@pytest.mark.parametrize("name", sorted(OBJECTS))
def test_proposals_lie_on_opposed_surfaces_within_reach(name: str) -> None:
    proposals = propose_grasps(OBJECTS[name])
    assert [p.cost for p in proposals] == sorted(p.cost for p in proposals)
    model = build_scene(name, None).compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    groups = np.array([0, 0, 0, 1, 0, 0], np.uint8)
    for proposal in proposals[:5]:
        grasp = proposal.grasp
        point, axis = np.array(grasp.point), np.array(grasp.opposition)
        assert WIDTH_RANGE[0] <= grasp.width <= WIDTH_RANGE[1]
        assert axis @ grasp.approach == pytest.approx(0.0, abs=1e-6)
        hit, out = np.zeros(1, np.int32), grasp.width / 2 + 0.005
        for side in (-axis, axis):
            depth = mujoco.mj_ray(model, data, point + out * side, -side, groups, 1, -1, hit)
            assert depth == pytest.approx(0.005, abs=2e-4)  # round pieces are polygons here
        start = point - np.array(grasp.approach)
        distance = mujoco.mj_ray(model, data, start, np.array(grasp.approach), groups, 1, -1, hit)
        assert distance < 0 or 1.0 - distance < REACH + 1e-6


def test_a_ring_too_wide_to_span_is_taken_by_its_rim() -> None:
    best = propose_grasps(of_pieces(*ring((0.06, 0.06), (0.07, 0.07), (0.0, 0.04), 32)))[0].grasp
    assert best.kind in ("top", "tripod")
    assert best.width == pytest.approx(0.01, abs=0.002)
    assert np.linalg.norm(best.point[:2]) == pytest.approx(0.065, abs=0.002)


def test_surfaces_that_slope_away_are_not_proposed(tmp_path: Path) -> None:
    """A flat cone's sides lie at 55 deg to any level line."""
    with pytest.raises(InputError, match="'own' has no two opposed surfaces"):
        propose_grasps(own(trimesh.creation.cone(0.049, 0.034, sections=64), tmp_path))


def test_what_is_too_wide_to_grasp_is_said_so(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="up to 100 mm apart"):
        propose_grasps(own(trimesh.creation.box((0.15, 0.15, 0.15)), tmp_path))


@pytest.mark.parametrize("name", ["book", "cube", "screwdriver"])
def test_the_lift_task_brings_the_forearm_from_where_it_comes_in_the_table(name: str) -> None:
    task = lift_task(OBJECTS[name])
    model = build_scene(task, base="free").compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    distal = data.body("forearm").xmat.reshape(3, 3)[:, 0]
    np.testing.assert_allclose(distal, [np.cos(np.pi / 6), 0.5, 0.0], atol=1e-6)
    dorsal = data.body("forearm").xmat.reshape(3, 3)[:, 2]
    np.testing.assert_allclose(
        data.body("object").xmat.reshape(3, 3) @ hand_axes(task.grasp)[:, 2], dorsal, atol=1e-6
    )


def test_a_task_with_an_object_of_ones_own_builds_its_scene(tmp_path: Path) -> None:
    grasp_object = own(trimesh.creation.box((0.05, 0.04, 0.06)), tmp_path)
    task = lift_task(grasp_object)
    assert task.object is grasp_object
    assert (task.name, task.number, task.rule.kind) == ("own-lift", 0, "carry")
    model = build_scene(task.for_side("left"), HandSize(side="left")).compile()
    assert model.body("object").mass[0] == pytest.approx(0.1)


def of_pieces(*colliders: Collider) -> GraspObject:
    """An object of given contact pieces whose mass is that of a drum."""
    mesh = trimesh.creation.cylinder(0.04, 0.09).apply_translation((0, 0, 0.045))
    surface = TriangleMesh(np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int32))
    pieces = (Piece(surface, 0.2, (0.5, 0.5, 0.5, 1.0)),)
    return GraspObject("made-up", "handle", pieces, colliders, source="made up")


@pytest.fixture(scope="module")
def vessel() -> GraspObject:
    """A cup without decomposition: a wall of 16 staves, a bottom, and a handle at +x."""
    staves = ring((0.036, 0.036), (0.040, 0.040), (0.0, 0.09), 16)
    arms = [box((0.026, 0.010, 0.010), (0.052, 0, z)) for z in (0.02, 0.07)]
    bar = (*arms, box((0.010, 0.010, 0.060), (0.065, 0, 0.045)))
    return of_pieces(*staves, drum(0.036, 0.0, 0.004), *bar)


@pytest.fixture(scope="module")
def proposals(vessel: GraspObject) -> tuple[Proposal, ...]:
    return propose_grasps(vessel)


def families(proposals: tuple[Proposal, ...]) -> set[tuple[str, int]]:
    return {(each.grasp.kind, len(each.grasp.fingers)) for each in proposals}


def test_a_vessel_is_taken_across_by_its_rim_and_by_its_handle(
    proposals: tuple[Proposal, ...],
) -> None:
    assert {("side", 4), ("top", 4), ("top", 3), ("top", 2), ("handle", 2)} <= families(proposals)
    best = proposals[0].grasp
    assert best.width == pytest.approx(0.08, abs=0.001)
    across = [each.grasp for each in proposals if each.grasp.kind == "side"]
    assert all(abs(grasp.width - 0.08) < 0.006 for grasp in across)
    by_handle = [each.grasp for each in proposals if each.grasp.kind == "handle"]
    assert any(grasp.point[0] == pytest.approx(0.065, abs=0.003) for grasp in by_handle)
    rim = [each.grasp for each in proposals if each.grasp.width < 0.006]
    assert rim and all(grasp.approach[2] == -1 for grasp in rim)
    assert all(np.hypot(*grasp.point[:2]) == pytest.approx(0.038, abs=0.003) for grasp in rim)


def test_no_finger_passes_through_what_is_grasped(proposals: tuple[Proposal, ...]) -> None:
    """From the side a hand does not come through the handle."""
    for each in proposals:
        if each.grasp.kind == "side":
            assert not (each.grasp.approach[0] < -0.9 and abs(each.grasp.point[1]) < 0.01)


def test_low_things_are_taken_from_above(tmp_path: Path) -> None:
    bar = own(trimesh.creation.box((0.15, 0.012, 0.004)), tmp_path)
    proposals = propose_grasps(bar)
    assert all(each.grasp.approach == (0, 0, -1) for each in proposals)
    best = proposals[0]
    assert (best.grasp.kind, best.grasp.point[2]) == ("top", pytest.approx(0.002, abs=5e-4))
    assert best.lever < 0.004
    assert families(proposals) >= {("top", 2), ("top", 3), ("tripod", 2)}


def test_the_short_list_has_grasps_of_every_kind(proposals: tuple[Proposal, ...]) -> None:
    few = short_list(proposals)
    assert len(few) == MOST_TRIED
    assert few[0] == proposals[0]
    assert len({_cell(each) for each in few}) >= 12
    assert families(few) == families(proposals)
    assert set(short_list(proposals[:5])) == set(proposals[:5])


def _cell(proposal: Proposal) -> tuple:
    grasp = proposal.grasp
    return (grasp.kind, len(grasp.fingers), *np.round(np.array(grasp.point) / 0.015).tolist())


def test_the_same_object_gives_the_same_proposals(
    vessel: GraspObject, proposals: tuple[Proposal, ...]
) -> None:
    assert propose_grasps(vessel) == proposals
