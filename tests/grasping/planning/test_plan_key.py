"""Keys of plans: equal for the same thing, other where something that matters is another."""
# pyright: reportAttributeAccessIssue=false

from dataclasses import replace

import numpy as np
import pytest

from handsim import physics
from handsim.arm import _arm_parts, arm_strength
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions, perturb
from handsim.grasping.planning import plan_key
from handsim.grasping.planning.plan_key import PlanKey, key_for, key_of
from handsim.grasping.planning.plan_store import plan_store
from handsim.grasping.rollout import drivers, forearm
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.glove import DataGlove
from handsim.hand import mjcf as hand_model
from handsim.learning.controller import GraspController
from handsim.objects import mjcf as hand_objects
from handsim.objects.object import Collider, Piece, TriangleMesh
from handsim.tasks import task as grasp_task
from handsim.tasks.table_one import TASKS, task_by_name
from handsim.types import HandSize

TASK = task_by_name("cube-raise")
FREE = Conditions(base="free")
PHYSICS, HAND = ("physics",), ("hand",)


def key(task=TASK, conditions=Conditions()):  # noqa: B008
    return key_of(Scene.build(task, conditions))


@pytest.fixture(scope="module")
def usual() -> PlanKey:
    return key()


@pytest.fixture(scope="module")
def free() -> PlanKey:
    return key(conditions=FREE)


def other_object(**changes):
    """The task with an object of its own, a little changed; its pieces made of their meshes."""
    grasp_object = TASK.object
    pieces = tuple(
        replace(p, mesh=hand_objects.read_mesh(str(p.mesh))) for p in grasp_object.pieces
    )
    return replace(TASK, own_object=replace(grasp_object, **({"pieces": pieces} | changes)))


def moved_vertex(by: float) -> Piece:
    (piece,) = TASK.object.pieces
    mesh = hand_objects.read_mesh(str(piece.mesh))
    vertices = mesh.vertices.copy()
    vertices[0, 2] += by
    return replace(piece, mesh=TriangleMesh(vertices, mesh.faces))


def moved_collider(by: float) -> Collider:
    (collider, *_) = TASK.object.colliders
    if collider.points:
        (x, y, z), *rest = collider.points
        return replace(collider, points=((x, y, z + by), *rest))
    return replace(collider, pos=(*collider.pos[:2], collider.pos[2] + by))


def heavier(factor: float) -> Piece:
    (piece,) = TASK.object.pieces
    return replace(piece, mass=piece.mass * factor)


def test_the_same_scene_has_the_same_key(usual):
    assert key() == usual
    assert usual.differs_in(key()) == ()
    assert key(other_object()) == usual  # the very meshes, but not by name


@pytest.mark.parametrize(
    ("changed", "parts"),
    [
        (replace(TASK, rule=replace(TASK.rule, slip=0.0201)), ("task",)),
        (replace(TASK, rule=replace(TASK.rule, hold=3.1)), ("task", "schedule")),
        (replace(TASK, grasp=replace(TASK.grasp, width=0.0551)), ("task",)),
        (replace(TASK, yaw_deg=31.0), ("task",)),
        (replace(TASK, name="cube-lift"), ("task",)),
        (replace(TASK, steps=(replace(TASK.steps[0], seconds=1.01),)), ("task", "schedule")),
        (replace(TASK, steps=(replace(TASK.steps[0], shift=(0, 0, 0.151)),)), ("task",)),
        (other_object(pieces=(moved_vertex(1e-4),)), ("object",)),
        (other_object(colliders=(moved_collider(1e-5), *TASK.object.colliders[1:])), ("object",)),
        (other_object(pieces=(heavier(1.001),)), ("object",)),
        (other_object(symmetry="z"), ("object",)),
    ],
)  # fmt: skip
def test_another_task_or_object_is_told(usual, changed, parts):
    assert usual.differs_in(key(changed)) == parts


def test_where_an_object_stands_does_not_count_since_plans_are_relative_to_it(usual):
    assert key(replace(TASK, place=(0.05, -0.1))) == usual


def test_looks_and_names_of_objects_do_not_count(usual):
    (piece,) = TASK.object.pieces
    red = replace(piece, rgba=(1.0, 0.0, 0.0, 1.0), shine=0.9)
    assert key(other_object(pieces=(red,), source="measured", front="another side")) == usual


@pytest.mark.parametrize(
    "conditions",
    [
        Conditions(hand=HandSize(0.180)),
        Conditions(hand=HandSize(breadth=0.0851)),
        Conditions(hand=HandSize(side="left")),
    ],
)
def test_another_hand_is_told(usual, conditions):
    assert "hand" in usual.differs_in(key(TASK, conditions))
    assert "object" not in usual.differs_in(key(TASK, conditions))


@pytest.mark.parametrize(
    ("module", "name", "value", "parts"),
    [
        (physics, "TIMESTEP", 0.0021, PHYSICS),
        (hand_model, "FRICTION", (0.8, 0.006, 1e-4), PHYSICS),
        (hand_model, "CONTACT_SOLREF", (0.0061, 1.0), PHYSICS),
        (hand_model, "JOINT_DAMPING", 0.0123, HAND),
        (hand_model, "DENSITY", 1101.0, (*HAND, *PHYSICS)),  # actuators are damped by inertia
        (hand_objects, "TABLE_FRICTION", (0.51, 0.005, 1e-4), PHYSICS),
        (hand_objects, "CONTACT_SOLREF", (0.0061, 1.0), PHYSICS),
        (plan_key, "PASSING_PAIRS", (), HAND),
        (plan_key, "RATE", 101.0, PHYSICS),
        (plan_key, "DataGlove", lambda: DataGlove(noise=0.005), PHYSICS),
        (plan_key, "SQUEEZE_DEG", {"thumb_mcp": 11}, PHYSICS),
        (plan_key, "GRIP", (*plan_key.GRIP[:-1], 2.9), PHYSICS),
        (plan_key, "_LOOP", (0.021, *plan_key._LOOP[1:]), PHYSICS),
        (plan_key, "_LOOP", (plan_key._LOOP[0], 0.26, plan_key._LOOP[2]), PHYSICS),
        (plan_key, "_LOOP", (*plan_key._LOOP[:2], 0.31), PHYSICS),
        (plan_key, "LIMITS", (*plan_key.LIMITS[:-1], 0.016), ("task",)),
        (arm_strength, "SATURATION", 0.61, PHYSICS),
        (
            _arm_parts,
            "ARMATURE",
            {"shoulder": 0.03, "elbow": 0.01, "forearm": 0.003},
            (*HAND, *PHYSICS),
        ),
    ],
)
def test_another_physics_is_told(usual, monkeypatch, module, name, value, parts):
    assert getattr(module, name) != value
    monkeypatch.setattr(module, name, value)
    assert usual.differs_in(key()) == parts


def test_gains_of_the_loop_are_of_the_fingers_and_the_arm():
    assert plan_key._LOOP == (drivers.CORRECTION, forearm.FEELING, forearm.MOST_FELT)


def test_what_carries_the_hand_is_told(usual, free, monkeypatch):
    assert usual.differs_in(free) == (*HAND, *PHYSICS)
    monkeypatch.setattr(hand_model, "WELD_SOLREF", (0.0201, 1.0))
    assert free.differs_in(key(conditions=FREE)) == PHYSICS
    assert key() == usual  # an arm is welded to nothing


def test_limits_are_those_that_rules_share():
    assert set(plan_key.LIMITS) == {
        *(0.010, 10.0, 0.002, 60.0, 4.0, 0.2, -0.5, 0.95, 0.1),  # of every grasp
        *(0.003, 20.0, 0.015),  # of lines and ways
    }


@pytest.mark.parametrize(
    ("array", "part"),
    [
        ("opt.gravity", "physics"), ("opt.impratio", "physics"), ("opt.tolerance", "physics"),
        ("opt.disableflags", "physics"), ("opt.cone", "physics"), ("actuator_gainprm", "physics"),
        ("actuator_biasprm", "physics"), ("actuator_forcerange", "physics"),
        ("geom_solimp", "physics"), ("geom_margin", "physics"), ("geom_condim", "physics"),
        ("eq_solref", "physics"), ("jnt_range", "hand"), ("dof_armature", "hand"),
        ("geom_size", "hand"), ("body_mass", "hand"), ("body_inertia", "object"),
    ],
)  # fmt: skip
def test_whatever_changes_in_the_compiled_scene_is_told(usual, free, array, part):
    welded = array == "eq_solref"
    scene = Scene.build(TASK, FREE if welded else Conditions())
    owner, _, name = f"model.{array}".rpartition(".")
    place = scene.hand.model.opt if "opt" in owner else scene.hand.model
    old = getattr(place, name)
    if isinstance(old, np.ndarray):
        old[...] = old + (1 if old.dtype == np.int32 else 0.001 + 0.01 * old)
    elif name == "cone":
        place.cone = 1 - old
    elif name == "disableflags":
        place.disableflags |= 1 << 7  # gravity
    else:
        setattr(place, name, old + 1)
    assert part in (free if welded else usual).differs_in(key_of(scene))


def test_the_last_bits_of_a_compiled_scene_do_not_count(usual):
    """As another compiler, or another version of MuJoCo, would make them."""
    scene = Scene.build(TASK, Conditions())
    model, generator = scene.hand.model, np.random.default_rng(0)
    names = (*(f"body_{n}" for n in ("mass", "inertia", "ipos", "pos", "quat")), "site_pos",
             "jnt_axis", "jnt_range", "dof_damping", "geom_size", "geom_pos", "geom_quat",
             "actuator_gainprm", "actuator_biasprm", "actuator_ctrlrange",
             "geom_friction", "geom_solref", "geom_solimp")  # fmt: skip
    changed = 0
    for name in names:
        array = getattr(model, name)
        before = array.copy()
        array *= 1 + 1e-13 * generator.uniform(-1, 1, array.shape)
        changed += np.count_nonzero(array != before)
    assert changed > 500
    assert key_of(scene) == usual


def test_how_hand_and_palm_come_in_counts_for_a_persons_hand(usual, monkeypatch):
    scene = Scene.build(TASK, Conditions())
    robots = key_of(scene, beside=())
    assert robots.differs_in(usual) == ("physics",)
    monkeypatch.setattr(plan_key, "REACH", (*plan_key.REACH[:2], 0.5))
    assert key_of(scene).differs_in(usual) == ("physics",)
    assert key_of(scene, beside=()) == robots
    monkeypatch.undo()
    assert key_of(scene) == usual
    other = replace(plan_key.shipped_transport(), duration=2.0)
    monkeypatch.setattr(plan_key, "shipped_transport", lambda: other)
    assert key_of(scene).differs_in(usual) == ("physics",)


def test_what_runs_switch_off_and_on_does_not_count(usual):
    scene = Scene.build(TASK, Conditions())
    scene.hand.model.opt.disableflags |= plan_key.NO_SENSORS
    assert key_of(scene) == usual


@pytest.mark.parametrize(("side", "base"), [("right", "arm"), ("left", "arm"), ("right", "free")])
def test_a_perturbed_run_goes_by_the_plan_of_the_usual_one(side, base, monkeypatch):
    conditions = Conditions(hand=HandSize(side=side), base=base)
    perturbed = perturb(conditions, 5)
    scene = Scene.build(TASK, perturbed)
    expected = key(TASK, conditions)
    assert key_of(scene) != expected
    plan_key._usual_key.cache_clear()
    assert key_for(TASK, perturbed, scene) == expected
    assert key_for(TASK, replace(conditions, friction=0.5)) == expected
    # One more scene is compiled for a task at most, and none where nothing is perturbed.
    monkeypatch.setattr(plan_key, "Scene", None)
    assert key_for(TASK, perturb(conditions, 6), scene) == expected
    plan_key._usual_key.cache_clear()
    usual = Scene.build(TASK, replace(conditions, seed=9))
    assert key_for(TASK, replace(conditions, seed=9), usual) == expected
    off = replace(conditions, bias=0.05, drift=0.01, latency=0.05, lost=0.1, shake=2.0)
    assert key_for(TASK, off, usual) == expected


def test_an_object_that_changes_under_its_name_is_not_the_one_looked_up_before(monkeypatch):
    before = key_for(TASK, Conditions())
    assert before == key_for(TASK, Conditions())
    heavy = replace(TASK.object, pieces=(heavier(1.5),))
    monkeypatch.setattr(grasp_task, "OBJECTS", {**grasp_task.OBJECTS, TASK.object_name: heavy})
    assert before.differs_in(key_for(TASK, Conditions())) == ("object",)


def test_keys_tell_all_tasks_apart_and_fit_the_plans_that_are_shipped():
    """They were made by another version of MuJoCo too: whatever the last digits, keys are these."""
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    store = plan_store(data_folder("assets") / "plans", controller.digest, Conditions())
    entries = store.entries()
    keys = {task.name: key(task) for task in TASKS}
    assert len({each.task for each in keys.values()}) == len(TASKS)
    assert len({each.object for each in keys.values()}) == len({t.object_name for t in TASKS})
    assert len({each.hand for each in keys.values()}) == 1
    assert {name: entries[name].key for name in keys} == keys


def test_the_scissors_of_a_left_hand_are_other_scissors_and_its_cube_is_the_same():
    """What is mirrored is an object, not a task: no plan of the others has to be made again."""
    scissors, left = task_by_name("scissors-move"), Conditions(hand=HandSize(side="left"))
    parts = key(scissors).differs_in(key(scissors, left))
    assert {"object", "task", "hand"} <= set(parts)
    assert plan_key.task_content(replace(scissors, mirrored=True)) == plan_key.task_content(
        scissors
    )
    assert key(TASK, left).object == key(TASK).object


def test_where_a_free_hand_begins_does_not_count(free):
    elsewhere = key(task_by_name("cup-drink"), FREE)
    assert elsewhere.hand == free.hand
