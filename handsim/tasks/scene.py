"""Hand, object and table as one MuJoCo scene.

World frame: z up, table top at z = 0, origin at the middle of the region in which things are
grasped; the person sits at -x and looks to +x.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Sequence

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from handsim.arm.arm_geometry import ArmGeometry, Seat
from handsim.arm.arm_joints import N_ARM
from handsim.arm.mjcf import attach_arm
from handsim.arm.reaching_arm import ReachingArm
from handsim.errors import InputError
from handsim.hand.mjcf import FRICTION, attach_hand
from handsim.objects.grasp import Grasp
from handsim.objects.mjcf import TABLE_FRICTION, add_object, object_by_name
from handsim.objects.object import GraspObject
from handsim.physics import CONTACT_SOLREF, set_physics
from handsim.tasks.task import Task
from handsim.types import MEDIAN_HAND, Array, Base, HandSize

HAND_FRICTION_RANGE = (0.05, 3.0)
"""Sliding friction of the hand that can be asked for; skin lies between 0.3 and 1.5."""

TABLE_TOP = (0.55, 0.9, 0.03)
"""Far edge, width and thickness of the table's top [m]; it begins before the person's chest. What
stands beside it is caught all the same."""

# Camera positions and what they look at [m]: about 0.5 m of scene from top to bottom, with room
# for what is lifted.
_CAMERAS = {
    "view": ((0.50, 0.50, 0.38), (-0.02, -0.02, 0.13)),
    "front": ((0.84, 0.0, 0.30), (0.0, 0.0, 0.13)),
    "side": ((-0.04, 0.84, 0.26), (-0.04, 0.0, 0.13)),
    "top": ((-0.001, 0.0, 0.80), (0.0, 0.0, 0.05)),
}
_FIELD_OF_VIEW = 36.0


def build_scene(
    task: Task | GraspObject | str,
    hand: HandSize | None = MEDIAN_HAND,
    *,
    base: Base = "arm",
    friction: float | None = None,
    mass_scale: float = 1.0,
    offset: Sequence[float] = (0.0, 0.0),
    turn: float = 0.0,
) -> mujoco.MjSpec:
    """Build table, light, cameras, object and hand.

    The object's free joint is ``object_joint``. A free hand's base follows the mocap body
    ``forearm_target`` and starts where `start_pose` puts it. Site ``grasp`` on the object has x
    along the grasp's opposition and z against its approach.

    Parameters
    ----------
    task
        A task (mirrored here for a left hand), an object without one, or an object's name.
    hand
        Size and side of the hand; None leaves it out.
    base
        What carries the hand.
    friction
        Sliding friction of the hand; torsional friction changes with it. None keeps the model's.
    mass_scale
        Factor on the object's mass and inertia.
    offset, turn
        Displacement (x, y) [m] and turn [rad] of the object from its usual place.

    Returns
    -------
    mujoco.MjSpec
        Ready to compile; complete in itself as XML, meshes included.

    Raises
    ------
    InputError
        If friction, mass or the hand's size cannot be used, or the base is that of robot hands.
    UnknownNameError
        If there is no object of that name.
    """
    if base == "mounted":
        raise InputError("base 'mounted' carries robot hands alone; give 'arm' or 'free'")
    if isinstance(task, Task) and hand is not None:
        task = task.for_side(hand.side)
    target = _target_of(task)
    spec = mujoco.MjSpec()
    spec.modelname = f"handsim {target.name}"
    set_physics(spec)
    _add_surroundings(spec, hand or MEDIAN_HAND)
    place = np.array([*offset, 0.0])
    if isinstance(task, Task):
        yaw = np.deg2rad(task.yaw_deg) + turn
        start = {name: np.deg2rad(angle) for name, angle in task.start_deg}
        place[:2] += task.place
        body = add_object(spec, target, pos=place, yaw=yaw, start=start, mass_scale=mass_scale)
        _add_grasp_site(body, task.grasp)
        pos, quat = start_pose(task, hand or MEDIAN_HAND)
    else:
        add_object(spec, target, pos=place, yaw=turn, mass_scale=mass_scale)
        pos, quat = np.array([-0.30, -0.15, 0.15]), np.array([1.0, 0.0, 0.0, 0.0])
    if hand is not None:
        if base == "arm":
            attach_arm(spec, hand)
            _, hanging = ReachingArm(hand).palm(np.zeros(N_ARM), np.zeros(2))
            quat = Rotation.from_matrix(hanging).as_quat(scalar_first=True)
        else:
            attach_hand(spec, hand, pos, quat)
        _add_palm_camera(spec, quat)
        if friction is not None:
            set_hand_friction(spec, friction)
    return spec


def start_pose(task: Task, size: HandSize, distance: float = 0.14) -> tuple[Array, Array]:
    """Return where the wrist waits: aligned with the grasp, ``distance`` before it.

    Parameters
    ----------
    task
        Already mirrored for the hand's side; its object is taken to stand as the task says.
    size
        Of the hand.
    distance
        From the grasp point to the palm along the approach [m].

    Returns
    -------
    pos, quat
        Wrist position (3,) [m] and orientation (w, x, y, z) in the world.
    """
    to_world = Rotation.from_euler("z", np.deg2rad(task.yaw_deg))
    hand = to_world * Rotation.from_matrix(hand_axes(task.grasp))
    distal, _, dorsal = hand.as_matrix().T
    point = to_world.apply(np.array(task.grasp.point))
    pos = point + distance * dorsal - 0.55 * size.length * distal
    pos[:2] += task.place
    pos[2] = max(pos[2], 0.06)
    return pos, hand.as_quat(scalar_first=True)


def hand_axes(grasp: Grasp) -> Array:
    """Return the hand's axes at a grasp as columns (distal, to the left of it, dorsal), (3, 3).

    The palm faces along ``approach`` exactly; the distal axis is what is left of ``pointing`` (or
    ``opposition``) across it.
    """
    dorsal = -np.array(grasp.approach) / np.linalg.norm(grasp.approach)
    pointing = np.array(grasp.pointing or grasp.opposition)
    distal = pointing - dorsal * (pointing @ dorsal)
    distal /= np.linalg.norm(distal)
    return np.column_stack([distal, np.cross(dorsal, distal), dorsal])


def _target_of(task: Task | GraspObject | str) -> GraspObject:
    if isinstance(task, GraspObject):
        return task
    return task.object if isinstance(task, Task) else object_by_name(task)


def _add_surroundings(spec: mujoco.MjSpec, hand: HandSize) -> None:
    """Add table, lights, background and the cameras that stand still."""
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1920, 1080
    spec.visual.headlight.ambient = [0.38, 0.38, 0.38]
    spec.visual.headlight.diffuse = [0.25, 0.25, 0.25]
    spec.visual.headlight.specular = [0.1, 0.1, 0.1]
    spec.visual.map.znear, spec.visual.map.zfar = 0.02, 20.0
    spec.stat.extent, spec.stat.center = 0.5, [0.0, 0.0, 0.1]
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.94, 0.96],
        rgb2=[0.62, 0.66, 0.72],
        width=256,
        height=256 * 6,
    )
    spec.add_material(name="table_top", rgba=[0.80, 0.76, 0.70, 1.0], specular=0.0, shininess=0.2)
    world = spec.worldbody
    far, y, z = TABLE_TOP
    person = ArmGeometry(hand)
    near = float(person.shoulder()[0] + Seat().edge * person.stature)
    x, middle = far - near, 0.5 * (far + near)
    world.add_geom(
        name="table_top",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[x / 2, y / 2, z / 2],
        pos=[middle, 0.0, -z / 2],
        material="table_top",
        contype=0,
        conaffinity=0,
        group=2,
    )
    world.add_geom(
        name="table",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        pos=[middle, 0.0, 0.0],
        size=[x / 2, y / 2, 0.1],
        rgba=[0.0, 0.0, 0.0, 0.0],
        condim=4,
        friction=TABLE_FRICTION,
        solref=CONTACT_SOLREF,
        group=3,
    )
    world.add_light(
        name="lamp",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=[0.3, 0.5, 1.5],
        dir=[-0.25, -0.35, -1.0],
        diffuse=[0.45, 0.44, 0.43],
        specular=[0.25, 0.25, 0.25],
    )
    for name, (place, target) in _CAMERAS.items():
        world.add_camera(
            name=name, pos=place, quat=_look(np.array(place), np.array(target)), fovy=_FIELD_OF_VIEW
        )


def _add_palm_camera(spec: mujoco.MjSpec, hand_quat: Array) -> None:
    """Add the camera that moves with the palm, without turning, and looks at it from the left.

    ``hand_quat`` is the hand's orientation in the world where all joints are at 0.
    """
    place, target = np.array([0.24, 0.40, 0.22]), np.array([0.05, 0.02, 0.0])
    hand = Rotation.from_quat(hand_quat, scalar_first=True)
    look = Rotation.from_quat(_look(place, target), scalar_first=True)
    spec.body("palm").add_camera(
        name="palm",
        mode=mujoco.mjtCamLight.mjCAMLIGHT_TRACK,
        pos=hand.inv().apply(place),
        quat=(hand.inv() * look).as_quat(scalar_first=True),
        fovy=_FIELD_OF_VIEW,
    )


def _look(place: Array, target: Array) -> Array:
    """Return the orientation of a camera at ``place`` that sees ``target``, world z upwards."""
    back = (place - target) / np.linalg.norm(place - target)
    right = np.cross([0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right)
    axes = np.column_stack([right, np.cross(back, right), back])
    return Rotation.from_matrix(axes).as_quat(scalar_first=True)


def _add_grasp_site(body: mujoco.MjsBody, grasp: Grasp) -> None:
    across = np.cross(-np.array(grasp.approach), grasp.opposition)
    axes = np.column_stack([grasp.opposition, across, np.cross(grasp.opposition, across)])
    body.add_site(
        name="grasp",
        pos=grasp.point,
        quat=Rotation.from_matrix(axes).as_quat(scalar_first=True),
        size=[0.004],
        group=4,
    )


def set_hand_friction(spec: mujoco.MjSpec, friction: float) -> None:
    """Give the hand sliding friction, and torsional in proportion.

    Raises
    ------
    InputError
        If skin cannot be like that (`HAND_FRICTION_RANGE`).
    """
    low, high = HAND_FRICTION_RANGE
    if not low <= friction <= high:
        raise InputError(f"friction {friction:g} of the hand is outside {low:g} to {high:g}")
    for geom in spec.body("forearm").find_all(mujoco.mjtObj.mjOBJ_GEOM):
        geom.friction[:2] = friction, FRICTION[1] * friction / FRICTION[0]
