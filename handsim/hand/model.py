"""The hand as a MuJoCo model: 22 hinges, 22 position actuators, ellipsoid segments.

Frame: as in `handsim.hand.anthropometry`; origin of body ``forearm`` and ``palm`` at the wrist
centre, +x distal, +y to the thumb's side of a right hand, +z dorsal. The left hand is the mirror
image y -> -y, with joint axes such that the same q gives the mirrored posture.

Order of rotations: flexion turns about an axis fixed in the proximal bone, spreading about one
that moves with it (the ISB's order, Wu et al. 2005, J. Biomech. 38:981-992), so that the glove's
abduction stays the angle between fingers when they are flexed.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import sys
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Literal

import mujoco
import numpy as np
import numpy.typing as npt

from handsim.errors import UnknownNameError
from handsim.files import write_text
from handsim.hand.anthropometry import (
    HAND_BREADTH,
    HAND_LENGTH,
    LENGTHS,
    Ellipsoid,
    HandGeometry,
    hand_geometry,
    segment_names,
)
from handsim.joints import FINGERS, JOINT_NAMES, JOINTS, Array, Joint

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

FINGERTIP_FORCE = 30.0
"""What each fingertip can push with [N]: about 40 % of a man's maximal tip pinch (Mathiowetz et
al. 1985, Arch. Phys. Med. Rehabil. 66:69-74), which he can keep up. All torque limits follow."""
SATURATION = 0.4
"""Position error at which an actuator reaches its limit [rad]; gain = limit / saturation. All
flexors of a finger offset by the same angle then push with about the same fingertip force."""
SPREADING_STRENGTH = 0.5
"""Torque of the interossei that spread, relative to that of the flexors."""
DAMPING_RATIO = 1.0
JOINT_DAMPING = 0.01
"""Passive damping [N m s/rad]."""
ARMATURE = MappingProxyType({"finger": 2e-4, "proximal": 4e-4, "wrist": 2e-3})
"""Inertia added to each hinge [kg m2] by class of joint; several times that of a fingertip, for
stability at the gains above with steps of 2 ms."""

PASSING_PAIRS: tuple[tuple[str, str], ...] = (
    ("forearm", "palm"),
    ("forearm", "palm_ulnar"),
    ("forearm", "thumb_metacarpal"),
    ("palm", "thumb_proximal"),
    ("palm", "ring_proximal"),
    ("palm", "little_proximal"),
    ("palm_ulnar", "index_proximal"),
    ("palm_ulnar", "middle_proximal"),
    ("palm_ulnar", "thumb_metacarpal"),
    ("palm_ulnar", "thumb_proximal"),
    ("thumb_metacarpal", "index_proximal"),
    ("index_proximal", "middle_proximal"),
    ("middle_proximal", "ring_proximal"),
    ("ring_proximal", "little_proximal"),
)
"""Bodies whose flesh is continuous or folds, and which do not collide. Bodies that share a joint
never do, except where the forearm is part of the world."""


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
    _add_hand(spec, hand_length, hand_breadth, side)
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
    scene.worldbody.add_body(name="forearm_target", pos=pos, quat=quat, mocap=True)
    forearm = _add_hand(scene, hand_length, hand_breadth, side)
    forearm.pos, forearm.quat = pos, quat
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


@dataclass(frozen=True)
class HandModel:
    """A compiled model with a hand in it, and where the hand's parts are.

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

    def fingertips(self) -> Array:
        """Positions of the fingertips in the world, (5, 3) [m], thumb first."""
        return self.data.site_xpos[self.tip_site]

    def pads(self) -> tuple[Array, Array]:
        """Positions of the finger pads and their outward unit normals, each (5, 3)."""
        normals = -self.data.site_xmat[self.pad_site].reshape(-1, 3, 3)[:, :, 2]
        return self.data.site_xpos[self.pad_site], normals


def torque_limits(geometry: HandGeometry) -> Array:
    """Return the torque at which each joint can push its fingertip with `FINGERTIP_FORCE`.

    Lever: from the joint to the fingertip of the straight finger. The arch carries two fingers at
    up to a hand breadth from its axis, the wrist four at the middle finger's PIP joint.

    Returns
    -------
    (22,) [N m]
    """
    levers = []
    for joint in JOINTS:
        if joint.name == "palm_arch":
            lever = 2 * geometry.hand_breadth
        elif joint.finger is None:
            lever = 4 * (geometry.mcp("middle")[0] + LENGTHS["middle"][0] * geometry.hand_length)
        else:
            distal = LENGTHS[joint.finger][_segment_of(joint) :]
            lever = sum(distal) * geometry.hand_length
            if joint.motion == "abduction" and joint.finger != "thumb":
                lever *= SPREADING_STRENGTH
        levers.append(lever)
    return FINGERTIP_FORCE * np.array(levers)


def _segment_of(joint: Joint) -> int:
    """Which of its finger's three segments the joint moves first."""
    part = joint.name.rsplit("_", 1)[1]
    if joint.finger == "thumb":
        return {"mcp": 1, "ip": 2}.get(part, 0)
    return {"pip": 1, "dip": 2}.get(part, 0)


def _body_of(joint: Joint) -> str:
    if joint.finger is not None:
        return segment_names(joint.finger)[_segment_of(joint)]
    return "palm_ulnar" if joint.name == "palm_arch" else "palm"


def _axis_of(joint: Joint, geometry: HandGeometry) -> Array:
    """Axis of a joint of the right hand in the zero posture of its own body, (3,)."""
    if joint.name == "palm_arch":
        return geometry.arch_axis
    if joint.finger == "thumb" and joint.motion != "flexion":
        axes = geometry.link("thumb_metacarpal").axes
        turning = np.array([-1.0, 0.0, 0.0])  # from radial to palmar
        opening = np.cross(-turning, axes[:, 0])
        axis = turning if joint.motion == "rotation" else opening / np.linalg.norm(opening)
        return axes.T @ axis
    if joint.motion == "flexion":
        return np.array([0.0, 1.0, 0.0])
    return np.array([0.0, 0.0, -1.0 if joint.finger in ("ring", "little") else 1.0])


def _add_hand(
    spec: mujoco.MjSpec, hand_length: float, hand_breadth: float, side: Side
) -> mujoco.MjsBody:
    if side not in SIDES:
        raise UnknownNameError("side", side, SIDES)
    geometry = hand_geometry(hand_length, hand_breadth)
    set_physics(spec)
    _add_defaults(spec)
    forearm = _add_bodies(spec, geometry, mirror=1.0 if side == "right" else -1.0)
    _add_actuators(spec, geometry)
    _add_sensors(spec)
    for first, second in PASSING_PAIRS:
        spec.add_exclude(name=f"{first}-{second}", bodyname1=first, bodyname2=second)
    return forearm


def _add_defaults(spec: mujoco.MjSpec) -> None:
    hand = spec.add_default("hand", spec.default)
    geom = hand.geom
    geom.type = mujoco.mjtGeom.mjGEOM_ELLIPSOID
    geom.material = "skin"
    geom.density = 1100.0
    geom.priority = 1
    geom.condim = 4  # an ellipsoid touches in one point: without torsion, things would spin
    geom.friction = FRICTION
    geom.solref = CONTACT_SOLREF
    hand.joint.type = mujoco.mjtJoint.mjJNT_HINGE
    hand.joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    hand.joint.damping = [JOINT_DAMPING, 0, 0]
    hand.joint.armature = ARMATURE["finger"]
    hand.site.group = 4
    hand.site.size = [0.002, 0.002, 0.002]
    for name in ("proximal", "wrist"):
        spec.add_default(f"hand_{name}", hand).joint.armature = ARMATURE[name]
    nail = spec.add_default("hand_nail", hand).geom
    nail.contype = nail.conaffinity = 0
    nail.density = 0.0
    nail.material = "nail"
    spec.add_material(name="skin", rgba=[0.86, 0.66, 0.55, 1], specular=0.2, shininess=0.2)
    spec.add_material(name="nail", rgba=[0.94, 0.80, 0.74, 1], specular=0.5, shininess=0.5)


def _add_bodies(spec: mujoco.MjSpec, geometry: HandGeometry, mirror: float) -> mujoco.MjsBody:
    hand, nails = spec.find_default("hand"), spec.find_default("hand_nail")
    forearm = spec.worldbody.add_body(name="forearm", gravcomp=1.0, childclass="hand")
    length, breadth = geometry.hand_length, geometry.hand_breadth
    forearm.add_geom(
        hand,
        name="forearm_geom",
        pos=[-0.36 * length, 0.0, -0.03 * breadth],
        size=[0.5 * length, 0.37 * breadth, 0.28 * breadth],
    )
    bodies = {"forearm": forearm}
    flip = np.array([1.0, mirror, 1.0])
    for link in geometry.links:
        body = bodies[link.parent].add_body(
            name=link.name,
            pos=flip * link.origin,
            quat=_quaternion(flip[:, None] * link.axes * flip),
            gravcomp=1.0,
        )
        bodies[link.name] = body
        for joint in JOINTS_BY_BODY.get(link.name, ()):
            name = "wrist" if joint.name.startswith("wrist") else "proximal"
            small = joint.finger is not None and _segment_of(joint) > 0
            body.add_joint(
                hand if small else spec.find_default(f"hand_{name}"),
                name=joint.name,
                axis=mirror * flip * _axis_of(joint, geometry),
                range=np.deg2rad([joint.lower_deg, joint.upper_deg]),
            )
    for ellipsoid in geometry.ellipsoids:
        body = bodies[ellipsoid.body]
        centre, direction = flip * ellipsoid.centre, flip * ellipsoid.direction
        turn = np.arctan2(direction[1], direction[0]) / 2
        body.add_geom(
            hand,
            name=f"{ellipsoid.name}_geom",
            pos=centre,
            quat=[np.cos(turn), 0, 0, np.sin(turn)],
            size=ellipsoid.semi_axes,
        )
    for finger in FINGERS:
        name = segment_names(finger)[2]
        _add_fingertip(bodies[name], finger, geometry.ellipsoid(name), hand, nails)
    palm = geometry.ellipsoid("palm_centre")
    bodies["palm"].add_site(
        hand, name="palm_centre", pos=flip * (palm.centre - [0, 0, palm.semi_axes[2]])
    )
    return forearm


def _add_fingertip(
    body: mujoco.MjsBody,
    finger: str,
    shape: Ellipsoid,
    hand: mujoco.MjsDefault,
    nails: mujoco.MjsDefault,
) -> None:
    middle, (along, across, thick) = shape.centre[0], shape.semi_axes
    body.add_site(hand, name=f"{finger}_tip", pos=[middle + along, 0, 0])
    body.add_site(hand, name=f"{finger}_pad", pos=[middle, 0, -thick])
    body.add_site(
        hand,
        name=f"{finger}_touch",
        type=mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        pos=shape.centre,
        size=1.1 * shape.semi_axes,
    )
    body.add_geom(
        nails,
        name=f"{finger}_nail",
        pos=[middle + 0.35 * along, 0, 0.62 * thick],
        quat=[np.cos(0.15), 0, np.sin(0.15), 0],
        size=[0.45 * along, 0.62 * across, 0.28 * thick],
    )


def _add_actuators(spec: mujoco.MjSpec, geometry: HandGeometry) -> None:
    for joint, limit in zip(JOINTS, torque_limits(geometry), strict=True):
        actuator = spec.add_actuator(
            name=joint.name,
            target=joint.name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            ctrlrange=np.deg2rad([joint.lower_deg, joint.upper_deg]),
            forcerange=[-limit, limit],
        )
        actuator.set_to_position(kp=limit / SATURATION, dampratio=DAMPING_RATIO)


def _add_sensors(spec: mujoco.MjSpec) -> None:
    joint, actuator = mujoco.mjtObj.mjOBJ_JOINT, mujoco.mjtObj.mjOBJ_ACTUATOR
    for suffix, kind, of in (
        ("position", mujoco.mjtSensor.mjSENS_JOINTPOS, joint),
        ("velocity", mujoco.mjtSensor.mjSENS_JOINTVEL, joint),
        ("force", mujoco.mjtSensor.mjSENS_ACTUATORFRC, actuator),
    ):
        for name in JOINT_NAMES:
            spec.add_sensor(name=f"{name}_{suffix}", type=kind, objtype=of, objname=name)
    for finger in FINGERS:
        spec.add_sensor(
            name=f"{finger}_touch",
            type=mujoco.mjtSensor.mjSENS_TOUCH,
            objtype=mujoco.mjtObj.mjOBJ_SITE,
            objname=f"{finger}_touch",
        )


def _quaternion(rotation: Array) -> Array:
    quat = np.empty(4)
    mujoco.mju_mat2Quat(quat, rotation.ravel())
    return quat


def _joints_by_body() -> dict[str, tuple[Joint, ...]]:
    """Joints of each body, the proximal one first: flexion, then spreading; rotation first."""
    order = {"rotation": 0, "flexion": 1, "arch": 1, "deviation": 2, "abduction": 2}
    names = dict.fromkeys(_body_of(joint) for joint in JOINTS)
    return {
        name: tuple(
            sorted((j for j in JOINTS if _body_of(j) == name), key=lambda j: order[j.motion])
        )
        for name in names
    }


JOINTS_BY_BODY = MappingProxyType(_joints_by_body())


def write_hand(
    folder: Path,
    hand_length: float = HAND_LENGTH,
    hand_breadth: float = HAND_BREADTH,
    sides: tuple[Side, ...] = SIDES,
) -> list[Path]:
    """Write ``right_hand.xml`` and ``left_hand.xml``; plain MuJoCo loads them.

    Returns
    -------
    The files written.

    Raises
    ------
    InputError
        If the size is outside what can be built.
    FileError
        If the folder does not exist or cannot be written.
    """
    written = []
    for side in sides:
        spec = build_hand(hand_length, hand_breadth, side)
        spec.compile()
        path = Path(folder) / f"{side}_hand.xml"
        write_text(path, spec.to_xml())
        written.append(path)
    return written


def main() -> None:
    """Regenerate the model folder given as the only argument."""
    write_hand(Path(sys.argv[1]))


if __name__ == "__main__":
    main()
