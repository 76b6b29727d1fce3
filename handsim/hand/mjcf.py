"""The hand as a MuJoCo model: 22 hinges, 22 position actuators, ellipsoid segments.

Frame: as in `handsim.hand.anthropometry`; origin of body ``forearm`` and ``palm`` at the wrist
centre, +x distal, +y to the thumb's side of a right hand, +z dorsal. The left hand is the mirror
image y -> -y, with joint axes such that the same q gives the mirrored posture.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from types import MappingProxyType

import mujoco
import numpy.typing as npt

from handsim.errors import InputError, UnknownNameError
from handsim.hand._parts import (
    add_actuators,
    add_bodies,
    add_ellipsoids,
    add_fingertips,
    add_sensors,
)
from handsim.hand.anthropometry import DENSITY, HandGeometry
from handsim.physics import CONTACT_SOLREF, set_physics
from handsim.types import MEDIAN_HAND, HandSize

FRICTION = (0.8, 0.01, 2e-4)
"""Sliding [-], torsional and rolling [m] friction of skin; on glass or plastic 0.5 to 1."""
WELD_SOLREF = (0.005, 1.0)
"""Time constant [s] and damping ratio of the weld that carries the base."""

JOINT_DAMPING = 0.01
"""Passive damping [N m s/rad]."""
ARMATURE = MappingProxyType({"phalanx": 2e-4, "knuckle": 4e-4, "wrist": 2e-3})
"""Inertia added to each hinge [kg m2] by class of joint; several times that of a fingertip, for
stability at the gains above with steps of 2 ms."""

PASSING_PAIRS: tuple[tuple[str, str], ...] = (
    ("forearm", "palm"),
    ("forearm", "palm_ulnar"),
    ("forearm", "thumb_metacarpal"),
    ("palm", "thumb_proximal"),
    ("palm", "ring_proximal"),
    ("middle_proximal", "ring_proximal"),
)
"""Bodies whose flesh is continuous or folds where they meet, and which therefore do not collide.

Bodies that share a joint never do, except where the forearm is part of the world. The middle and
ring fingers are closest, and the palm arch turns the one into the other.
"""


def build_hand(size: HandSize = MEDIAN_HAND) -> mujoco.MjSpec:
    """Build the hand alone: its forearm fixed to the world, nq = nv = nu = 22.

    Parameters
    ----------
    size
        Size and side; by default the right hand of a man of median size.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    """
    spec = mujoco.MjSpec()
    spec.modelname = f"{size.side}_hand"
    set_physics(spec)
    mount_hand(spec, size)
    return spec


def attach_hand(
    scene: mujoco.MjSpec,
    size: HandSize = MEDIAN_HAND,
    pos: npt.ArrayLike = (0.0, 0.0, 0.0),
    quat: npt.ArrayLike = (1.0, 0.0, 0.0, 0.0),
    *,
    prefix: str = "",
) -> None:
    """Add the hand to a scene on a free base that follows the mocap body ``forearm_target``.

    The free joint is called ``forearm``; its 7 coordinates come before the hand's 22 and after
    those of all bodies that were in the scene before. The options of `set_physics` are set.

    Parameters
    ----------
    scene
        Changed in place; compile it afterwards.
    size
        As in `build_hand`.
    pos, quat
        Pose of the forearm, and of its target, in the world: (3,) [m], (4,) w, x, y, z.
    prefix
        Put before all names of the hand. A scene with two hands needs one for the second.

    Raises
    ------
    InputError
        As `mount_hand`.
    """
    _check_free(scene, size, prefix)
    set_physics(scene)
    target = f"{prefix}forearm_target"
    scene.worldbody.add_body(name=target, pos=pos, quat=quat, mocap=True)
    forearm = mount_hand(scene, size, "world", pos, quat, prefix=prefix)
    forearm.add_freejoint(name=f"{prefix}forearm")
    weld_to_mocap(scene, f"{prefix}forearm_weld", target, f"{prefix}forearm")


def mount_hand(
    scene: mujoco.MjSpec,
    size: HandSize = MEDIAN_HAND,
    body: str = "world",
    pos: npt.ArrayLike = (0.0, 0.0, 0.0),
    quat: npt.ArrayLike = (1.0, 0.0, 0.0, 0.0),
    *,
    prefix: str = "",
) -> mujoco.MjsBody:
    """Add the hand to a scene, its forearm fixed to a body: the world or the end of an arm.

    Parameters
    ----------
    scene
        Changed in place; its options are left alone (`set_physics` sets those that suit).
    size
        As in `build_hand`.
    body
        Name of the body that carries the forearm.
    pos, quat
        Pose of the forearm in that body: (3,) [m], (4,) w, x, y, z.
    prefix
        Put before all names of the hand. A scene with two hands needs one for the second.

    Returns
    -------
    The forearm, to which joints may be added.

    Raises
    ------
    InputError
        If the size is outside what can be built, or the scene has a hand of these names already.
    UnknownNameError
        If the scene has no such body.
    """
    carrier = scene.body(body)
    if carrier is None:
        raise UnknownNameError("body", body, tuple(other.name for other in scene.bodies))
    _check_free(scene, size, prefix)
    if prefix:
        alone = mujoco.MjSpec()
        alone.compiler.degree = scene.compiler.degree
        mount_hand(alone, size)
        scene.attach(alone, prefix=prefix, frame=carrier.add_frame())
        forearm = scene.body(f"{prefix}forearm")
    else:
        forearm = _add_hand(scene, carrier, size)
    forearm.pos, forearm.quat = pos, quat
    return forearm


def _check_free(scene: mujoco.MjSpec, size: HandSize, prefix: str) -> None:
    if scene.body(f"{prefix}forearm") is not None:
        raise InputError(
            f"the scene has a body '{prefix}forearm' already; give a prefix such as '{size.side}_'"
        )


def _add_hand(scene: mujoco.MjSpec, carrier: mujoco.MjsBody, size: HandSize) -> mujoco.MjsBody:
    """Add all parts of the hand under their own names."""
    geometry = HandGeometry(size)
    mirror = 1.0 if size.side == "right" else -1.0
    kind = hand_class(size)
    _add_defaults(scene, kind)
    bodies = add_bodies(scene, kind, carrier, geometry, mirror)
    add_ellipsoids(scene, kind, bodies, geometry, mirror)
    add_fingertips(scene, kind, bodies, geometry)
    add_actuators(scene, geometry)
    add_sensors(scene)
    for first, second in PASSING_PAIRS:
        scene.add_exclude(name=f"{first}-{second}", bodyname1=first, bodyname2=second)
    return bodies["forearm"]


def hand_class(size: HandSize) -> str:
    """Return the name of the default class of a hand, ``right_hand``; those of parts begin so."""
    return f"{size.side}_hand"


def give_skin(geom: mujoco.MjsGeom) -> None:
    """Let a geom touch things as the hand does, with `FRICTION`."""
    geom.priority = 1
    geom.condim = 4  # an ellipsoid touches in one point: without torsion, things would spin
    geom.friction = FRICTION
    geom.solref = CONTACT_SOLREF


def add_skin_material(scene: mujoco.MjSpec) -> None:
    """Add the material ``skin`` to a scene."""
    scene.add_material(name="skin", rgba=[0.86, 0.66, 0.55, 1], specular=0.2, shininess=0.2)


def weld_to_mocap(scene: mujoco.MjSpec, name: str, target: str, body: str) -> None:
    """Let a free body follow a mocap body, as what carries a free hand does."""
    scene.add_equality(
        name=name,
        type=mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=target,
        name2=body,
        solref=WELD_SOLREF,
        data=[0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0],  # same place, torque scale 1
    )


def _add_defaults(spec: mujoco.MjSpec, kind: str) -> None:
    hand = spec.add_default(kind, spec.default)
    geom = hand.geom
    geom.type = mujoco.mjtGeom.mjGEOM_ELLIPSOID
    geom.material = "skin"
    geom.density = DENSITY
    give_skin(geom)
    hand.joint.type = mujoco.mjtJoint.mjJNT_HINGE
    hand.joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    hand.joint.damping = [JOINT_DAMPING, 0, 0]
    hand.site.group = 4
    hand.site.size = [0.002, 0.002, 0.002]
    for name, armature in ARMATURE.items():
        spec.add_default(f"{kind}_{name}", hand).joint.armature = armature
    looks = spec.add_default(f"{kind}_looks", hand)
    looks.geom.contype = looks.geom.conaffinity = 0
    looks.geom.density = 0.0
    spec.add_default(f"{kind}_nail", looks).geom.material = "nail"
    add_skin_material(spec)
    spec.add_material(name="nail", rgba=[0.95, 0.78, 0.72, 1], specular=0.5, shininess=0.5)
