"""The hand as a MuJoCo model: 22 hinges, 22 position actuators, ellipsoid segments.

Frame: as in `handsim.hand.anthropometry`; origin of body ``forearm`` and ``palm`` at the wrist
centre, +x distal, +y to the thumb's side of a right hand, +z dorsal. The left hand is the mirror
image y -> -y, with joint axes such that the same q gives the mirrored posture.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Literal

import mujoco
import numpy as np
import numpy.typing as npt

from handsim.disk import naming
from handsim.errors import UnknownNameError
from handsim.files import write_text
from handsim.hand.anthropometry import DENSITY, HAND_BREADTH, HAND_LENGTH, hand_geometry
from handsim.hand.eigengrasps import eigengrasp_postures
from handsim.hand.parts import (
    add_actuators,
    add_bodies,
    add_ellipsoids,
    add_fingertips,
    add_sensors,
)
from handsim.hand.postures import POSTURES
from handsim.joints import FINGERS, JOINT_INDEX, JOINT_NAMES, Array

Side = Literal["right", "left"]
SIDES: tuple[Side, ...] = ("right", "left")

TIMESTEP = 0.002
"""[s]"""
FRICTION = (0.8, 0.01, 2e-4)
"""Sliding [-], torsional and rolling [m] friction of skin; on glass or plastic 0.5 to 1."""
CONTACT_SOLREF = (0.006, 1.0)
"""Time constant [s], three steps, and damping ratio of contacts."""
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


def build_hand(
    hand_length: float = HAND_LENGTH,
    hand_breadth: float = HAND_BREADTH,
    side: Side = "right",
) -> mujoco.MjSpec:
    """Build the hand alone: its forearm fixed to the world, nq = nv = nu = 22.

    Parameters
    ----------
    hand_length, hand_breadth
        [m]; defaults: a man of median size.
    side
        ``right`` or ``left``.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    UnknownNameError
        If ``side`` is neither.
    """
    spec = mujoco.MjSpec()
    spec.modelname = f"{side}_hand"
    set_physics(spec)
    mount_hand(spec, hand_length=hand_length, hand_breadth=hand_breadth, side=side)
    return spec


def set_physics(spec: mujoco.MjSpec) -> None:
    """Set the solver options under which the hand was tried; a scene needs them too."""
    spec.compiler.degree = False
    spec.option.timestep = TIMESTEP
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    spec.option.iterations = 50
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    spec.option.noslip_iterations = 2  # a pinched 100 g box creeps by 0.004, without 0.2 mm/s


def attach_hand(
    scene: mujoco.MjSpec,
    pos: npt.ArrayLike = (0.0, 0.0, 0.0),
    quat: npt.ArrayLike = (1.0, 0.0, 0.0, 0.0),
    *,
    hand_length: float = HAND_LENGTH,
    hand_breadth: float = HAND_BREADTH,
    side: Side = "right",
) -> None:
    """Add the hand to a scene on a free base that follows the mocap body ``forearm_target``.

    The free joint is called ``forearm``; its 7 coordinates come before the hand's 22 and after
    those of all bodies that were in the scene before. The options of `set_physics` are set.

    Parameters
    ----------
    scene
        Changed in place; compile it afterwards.
    pos, quat
        Pose of the forearm, and of its target, in the world: (3,) [m], (4,) w, x, y, z.
    hand_length, hand_breadth, side
        As in `build_hand`.
    """
    set_physics(scene)
    scene.worldbody.add_body(name="forearm_target", pos=pos, quat=quat, mocap=True)
    size = {"hand_length": hand_length, "hand_breadth": hand_breadth}
    forearm = mount_hand(scene, "world", pos, quat, side=side, **size)
    forearm.add_freejoint(name="forearm")
    scene.add_equality(
        name="forearm_weld",
        type=mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1="forearm_target",
        name2="forearm",
        solref=WELD_SOLREF,
        data=[0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0],  # same place, torque scale 1
    )


@dataclass(frozen=True, eq=False)
class HandModel:
    """A compiled model with a hand in it, and where the hand's parts are.

    As its state changes while it is simulated, it is equal to itself alone.

    Attributes
    ----------
    model, data
        The compiled model and one state of it.
    qpos_index, qvel_index, ctrl_index
        Indices of the 22 joints, in glove order, in ``qpos``, ``qvel`` and ``ctrl``.
    tip_site, pad_site
        Site ids, thumb to little finger.
    """

    model: mujoco.MjModel
    data: mujoco.MjData
    qpos_index: npt.NDArray[np.intp]
    qvel_index: npt.NDArray[np.intp]
    ctrl_index: npt.NDArray[np.intp]
    tip_site: npt.NDArray[np.intp]
    pad_site: npt.NDArray[np.intp]

    @classmethod
    def from_spec(cls, spec: mujoco.MjSpec) -> "HandModel":
        """Compile a spec that holds a hand and find its parts."""
        model = spec.compile()
        joints = [model.joint(name) for name in JOINT_NAMES]
        return cls(
            model,
            mujoco.MjData(model),
            np.array([joint.qposadr[0] for joint in joints]),
            np.array([joint.dofadr[0] for joint in joints]),
            np.array([model.actuator(name).id for name in JOINT_NAMES]),
            np.array([model.site(f"{finger}_tip").id for finger in FINGERS]),
            np.array([model.site(f"{finger}_pad").id for finger in FINGERS]),
        )

    @property
    def q(self) -> Array:
        """The posture in ``data``, (22,) [rad], glove order."""
        return self.data.qpos[self.qpos_index]

    def set_posture(self, q: Array) -> None:
        """Put joints and actuator targets at q, (22,) [rad], at rest, and update positions."""
        self.data.qpos[self.qpos_index] = q
        self.data.qvel[self.qvel_index] = 0.0
        self.data.ctrl[self.ctrl_index] = np.clip(
            q, *self.model.actuator_ctrlrange[self.ctrl_index].T
        )
        mujoco.mj_forward(self.model, self.data)

    def penetration(self, q: Array) -> float:
        """Return how deep anything penetrates in posture q, (22,) [rad], which is set [m]."""
        self.set_posture(q)
        return -min((contact.dist for contact in self.data.contact), default=0.0)

    def fingertips(self) -> Array:
        """Positions of the fingertips in the world, (5, 3) [m], thumb first."""
        return self.data.site_xpos[self.tip_site]

    def pads(self) -> tuple[Array, Array]:
        """Positions of the finger pads and their outward unit normals, each (5, 3)."""
        normals = -self.data.site_xmat[self.pad_site].reshape(-1, 3, 3)[:, :, 2]
        return self.data.site_xpos[self.pad_site], normals


def mount_hand(
    scene: mujoco.MjSpec,
    body: str = "world",
    pos: npt.ArrayLike = (0.0, 0.0, 0.0),
    quat: npt.ArrayLike = (1.0, 0.0, 0.0, 0.0),
    *,
    hand_length: float = HAND_LENGTH,
    hand_breadth: float = HAND_BREADTH,
    side: Side = "right",
) -> mujoco.MjsBody:
    """Add the hand to a scene, its forearm fixed to a body: the world or the end of an arm.

    Parameters
    ----------
    scene
        Changed in place; its options are left alone (`set_physics` sets those that suit).
    body
        Name of the body that carries the forearm.
    pos, quat
        Pose of the forearm in that body: (3,) [m], (4,) w, x, y, z.
    hand_length, hand_breadth, side
        As in `build_hand`.

    Returns
    -------
    The forearm, to which joints may be added.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    UnknownNameError
        If ``side`` is neither, or the scene has no such body.
    """
    if side not in SIDES:
        raise UnknownNameError("side", side, SIDES)
    carrier = scene.body(body)
    if carrier is None:
        raise UnknownNameError("body", body, tuple(other.name for other in scene.bodies))
    geometry = hand_geometry(hand_length, hand_breadth)
    mirror = 1.0 if side == "right" else -1.0
    _add_defaults(scene)
    bodies = add_bodies(scene, carrier, geometry, mirror)
    bodies["forearm"].pos, bodies["forearm"].quat = pos, quat
    add_ellipsoids(scene, bodies, geometry, mirror)
    add_fingertips(scene, bodies, geometry)
    add_actuators(scene, geometry)
    add_sensors(scene)
    for first, second in PASSING_PAIRS:
        scene.add_exclude(name=f"{first}-{second}", bodyname1=first, bodyname2=second)
    return bodies["forearm"]


def _add_defaults(spec: mujoco.MjSpec) -> None:
    hand = spec.add_default("hand", spec.default)
    geom = hand.geom
    geom.type = mujoco.mjtGeom.mjGEOM_ELLIPSOID
    geom.material = "skin"
    geom.density = DENSITY
    geom.priority = 1
    geom.condim = 4  # an ellipsoid touches in one point: without torsion, things would spin
    geom.friction = FRICTION
    geom.solref = CONTACT_SOLREF
    hand.joint.type = mujoco.mjtJoint.mjJNT_HINGE
    hand.joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    hand.joint.damping = [JOINT_DAMPING, 0, 0]
    hand.site.group = 4
    hand.site.size = [0.002, 0.002, 0.002]
    for name, armature in ARMATURE.items():
        spec.add_default(f"hand_{name}", hand).joint.armature = armature
    looks = spec.add_default("hand_looks", hand)
    looks.geom.contype = looks.geom.conaffinity = 0
    looks.geom.density = 0.0
    spec.add_default("hand_nail", looks).geom.material = "nail"
    spec.add_material(name="skin", rgba=[0.86, 0.66, 0.55, 1], specular=0.2, shininess=0.2)
    spec.add_material(name="nail", rgba=[0.95, 0.78, 0.72, 1], specular=0.5, shininess=0.5)


def add_keyframes(spec: mujoco.MjSpec, postures: Mapping[str, Array]) -> None:
    """Add postures, (22,) [rad] each, as keyframes to a hand that stands alone.

    Their joint positions and the actuators' targets are the posture.
    """
    order = [JOINT_INDEX[joint.name] for joint in spec.joints]
    for name, q in postures.items():
        spec.add_key(name=name, qpos=q[order], ctrl=q)


def write_hand(
    folder: Path,
    hand_length: float = HAND_LENGTH,
    hand_breadth: float = HAND_BREADTH,
    side: Side = "right",
) -> Path:
    """Write ``right_hand.xml`` or ``left_hand.xml``, with `POSTURES` and eigengrasps as keyframes.

    Plain MuJoCo loads it. The folder is made if it is not there.

    Returns
    -------
    The file written.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    FileError
        If the folder cannot be made or written.
    """
    spec = build_hand(hand_length, hand_breadth, side)
    add_keyframes(spec, {**POSTURES, **eigengrasp_postures(HandModel.from_spec(spec).penetration)})
    spec.compile()
    path = Path(folder) / f"{side}_hand.xml"
    with naming(Path(folder), "made"):
        path.parent.mkdir(parents=True, exist_ok=True)
    write_text(path, _with_position_actuators(spec.to_xml()))
    return path


def _with_position_actuators(xml: str) -> str:
    """Write actuators as MuJoCo's shortcut: easier to read, and understood by older versions."""
    general = re.compile(
        r'<general (.*?)(?: input="pos")? biastype="affine"'
        r' gainprm="(\S+)" biasprm="0 -\2 -(\S+)"/>'
    )
    return general.sub(r'<position \1 kp="\2" kv="\3"/>', xml)


def main() -> None:
    """Regenerate the models in the folder given as the only argument."""
    folder = Path(sys.argv[1])
    for side in SIDES:
        write_hand(folder, side=side)


if __name__ == "__main__":
    main()
