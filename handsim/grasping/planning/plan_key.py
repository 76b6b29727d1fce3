"""The key of a plan: what it was made for. The plan is used as long as its key is the same."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass, fields, replace
from functools import lru_cache
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from handsim.digests import content_digest, rounded
from handsim.grasping.conditions import Conditions
from handsim.grasping.gripping.grip import GRIP
from handsim.grasping.gripping.squeeze import SQUEEZE_DEG
from handsim.grasping.plan import schedule_for
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.drivers import CORRECTION
from handsim.grasping.rollout.forearm import FEELING, MOST_FELT
from handsim.grasping.rollout.glove import RATE, DataGlove
from handsim.grasping.rollout.record import JudgedScene
from handsim.grasping.rollout.sensing import NO_SENSORS
from handsim.hand.mjcf import PASSING_PAIRS
from handsim.learning.transport.coupling import WIDEST_AT
from handsim.learning.transport.stored import shipped_transport
from handsim.objects.mjcf import points_of, surface_of
from handsim.objects.object import Collider, GraspObject, Piece
from handsim.tasks.rules import LIMITS
from handsim.tasks.task import Task

Rows = npt.NDArray[Any]

_OPTIONS = (
    "timestep", "impratio", "iterations", "ls_iterations", "tolerance", "ls_tolerance",
    "noslip_iterations", "noslip_tolerance", "ccd_iterations", "ccd_tolerance", "gravity",
    "density", "viscosity", "enableflags", "disableactuator",
)  # fmt: skip
_CHOICES = {
    "integrator": mujoco.mjtIntegrator,
    "solver": mujoco.mjtSolver,
    "cone": mujoco.mjtCone,
}
"""Options that are hashed by name, since their numbers may differ between versions."""
_CONTACT = ("friction", "condim", "priority", "solref", "solimp", "margin", "gap", "solmix")
_ACTUATOR = ("gainprm", "biasprm", "dynprm", "gear", "ctrlrange", "forcerange")
_JOINT = ("type", "axis", "pos", "range", "stiffness", "solref", "solimp", "margin")
_DOF = ("damping", "armature", "frictionloss", "solref", "solimp")
# Poses of meshes and axes of inertia are left out: for round objects they depend on the last bits.
_BODY = ("mass", "inertia", "ipos")
_SHAPE = ("type", "size", "pos", "quat", "contype", "conaffinity")


_LOOP = (CORRECTION, FEELING, MOST_FELT)
REACH = ("outside the subspace", "fades until this share of the transport", WIDEST_AT)
"""How a person's hand leaves its posture at rest; a robot's begins within the subspace."""
_APART = ("own_object", "mirrored", "place")
"""Fields of a task that are not in its digest: those of the object have one of their own, and plans
are relative to the object, wherever that stands."""


@dataclass(frozen=True)
class PlanKey:
    """Digests of all that decides whether a plan fits, apart from the controller.

    They are the same on every machine and under every version of MuJoCo, since all numbers are
    rounded to about six digits (`handsim.digests`). That is some thousand times coarser than the
    differences between compilers and libraries. It is some thousand times finer than what changes a
    grasp: a tenth of a micrometre for the thickness of a finger, a microgram for a pen.

    Attributes
    ----------
    task
        All fields of the task for the hand's side, its rule, and the limits of the pass rules.
    object
        Surfaces, collision pieces, masses, inertias and hinges.
    hand
        Bodies, shapes, joints and marks of the hand in the scene.
    schedule
        Durations of the phases.
    physics
        Options of the solver, contacts, actuators, the weld of the forearm, and two parts outside
        the model: the glove and the grip layer.
    """

    task: str
    object: str
    hand: str
    schedule: str
    physics: str

    def differs_in(self, other: "PlanKey") -> tuple[str, ...]:
        """Return the names of the parts that differ."""
        mine, theirs = asdict(self), asdict(other)
        return tuple(each.name for each in fields(self) if mine[each.name] != theirs[each.name])


def planned_for(conditions: Conditions) -> Conditions:
    """Return the conditions that are planned for: the hand of the given ones, otherwise nominal."""
    return Conditions(hand=conditions.hand, base=conditions.base)


def key_for(task: Task, conditions: Conditions, scene: Scene | None = None) -> PlanKey:
    """Return the key of plans for a task and the hand of the conditions.

    Parameters
    ----------
    task
        For a right hand.
    conditions
    scene
        Of the task under these conditions, if it is built already. Where nothing in it is
        perturbed, it need not be compiled again.
    """
    # Neither seed and shake nor the glove change the scene.
    glove = {"bias": 0.0, "drift": 0.0, "latency": 0.0, "lost": 0.0}
    of_scene = replace(conditions, seed=0, nominal=True, shake=0.0, **glove)
    if scene is not None and of_scene == planned_for(conditions):
        return key_of(scene)
    return _usual_key(task, task.object, planned_for(conditions))


@lru_cache(maxsize=256)
def _usual_key(task: Task, grasp_object: GraspObject, conditions: Conditions) -> PlanKey:
    """Build the scene that is planned for and return its key."""
    return key_of(Scene.build(task, conditions))


def key_of(scene: JudgedScene, beside: tuple[str | float, ...] | None = None) -> PlanKey:
    """Return the key of plans for a nominal scene.

    ``beside`` is what counts beside the settings that are named in `_physics` and here: for a
    person's hand how hand and palm come in.
    """
    if beside is None:
        beside = (*REACH, shipped_transport().digest)
    model, task = scene.model, scene.task
    return PlanKey(
        task=content_digest(task_content(task), LIMITS),
        object=content_digest(object_content(scene.object), _moved(model, "object")),
        hand=content_digest(_moved(model, "forearm"), _places(model, "forearm"), PASSING_PAIRS),
        schedule=content_digest(schedule_for(task)),
        physics=content_digest(
            _physics(model), RATE, DataGlove(), SQUEEZE_DEG, GRIP, _LOOP, *beside
        ),
    )


def task_content(task: Task) -> dict[str, Any]:
    """Return the fields of a task by name that its plans depend on, its object apart."""
    names = (each.name for each in fields(task))
    return {name: getattr(task, name) for name in names if name not in _APART}


def object_content(grasp_object: GraspObject) -> dict[str, Any]:
    """Return all of an object that changes a grasp, with meshes in place of file names."""
    links = [(link.hinge, _shapes(link.pieces, link.colliders)) for link in grasp_object.links]
    return {
        "symmetry": grasp_object.symmetry,
        "shapes": _shapes(grasp_object.pieces, grasp_object.colliders),
        "links": links,
    }


def _shapes(pieces: Iterable[Piece], colliders: Iterable[Collider]) -> list[tuple[Any, ...]]:
    found: list[tuple[Any, ...]] = []
    for piece in pieces:
        mesh = surface_of(piece)
        found.append((mesh.vertices, mesh.faces, piece.mass))
    for each in colliders:
        points = points_of(each) if each.mesh else each.points
        found.append((each.kind, each.size, each.pos, each.quat, points))
    return found


def _moved(model: mujoco.MjModel, root: str) -> dict[str, Rows]:
    """Return masses and joints of a body and all bodies below it."""
    bodies = _of(model, root)
    joints, dofs = bodies[model.jnt_bodyid], bodies[model.dof_bodyid]
    return {
        **_rows(model, "body", _BODY, bodies),
        **_rows(model, "jnt", _JOINT, joints),
        **_rows(model, "dof", _DOF, dofs),
    }


def _places(model: mujoco.MjModel, root: str) -> dict[str, Rows]:
    """Return poses and shapes of the parts of a body, without the pose of the body itself."""
    bodies = _of(model, root)
    inner = bodies.copy()
    if model.body(root).rootid[0] == model.body(root).id:  # where it stands does not count
        inner[model.body(root).id] = False
    geoms = bodies[model.geom_bodyid] & ((model.geom_contype | model.geom_conaffinity) != 0)
    return {
        **_rows(model, "body", ("pos", "quat"), inner),
        **_rows(model, "geom", _SHAPE, geoms),
        **_rows(model, "site", ("pos", "quat"), bodies[model.site_bodyid]),
    }


def _physics(model: mujoco.MjModel) -> dict[str, Any]:
    """Return options, contacts and actuators of a model; each kind of contact counts once."""
    touching = (model.geom_contype | model.geom_conaffinity) != 0
    contact = _rows(model, "geom", _CONTACT, touching).values()
    options = {name: getattr(model.opt, name) for name in _OPTIONS}
    choices = {name: kind(getattr(model.opt, name)).name for name, kind in _CHOICES.items()}
    return {
        **options,
        **choices,
        "disabled": model.opt.disableflags & ~NO_SENSORS,  # a run switches sensors off and on
        "contacts": _kinds(contact),
        "holds": _kinds((model.eq_solref, model.eq_solimp)),
        "forearm": _weld(model),
        **_rows(model, "actuator", _ACTUATOR, np.ones(model.nu, dtype=bool)),
    }


def _weld(model: mujoco.MjModel) -> tuple[Rows, ...]:
    """Return what carries a free hand; nothing where an arm does."""
    names = [model.equality(i).name for i in range(model.neq)]
    if "forearm_weld" not in names:
        return ()
    weld = model.equality("forearm_weld")
    return weld.data, weld.solref


def _of(model: mujoco.MjModel, root: str) -> npt.NDArray[np.bool_]:
    """Return which bodies are the one of that name or below it, (nbody,)."""
    return np.asarray(model.body_rootid == model.body_rootid[model.body(root).id])


def _rows(
    model: mujoco.MjModel, kind: str, names: Iterable[str], rows: npt.NDArray[np.bool_]
) -> dict[str, Rows]:
    """Return chosen rows of arrays of a model, by name; every version has these arrays."""
    return {f"{kind}_{name}": getattr(model, f"{kind}_{name}")[rows] for name in names}


def _kinds(columns: Iterable[Rows]) -> Rows:
    """Return the different rows, each once, regardless of how many objects share one."""
    flat = [column.reshape(len(column), math.prod(column.shape[1:])) for column in columns]
    table = np.column_stack(flat)
    return np.unique(rounded(table), axis=0)
