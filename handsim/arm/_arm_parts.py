"""Parts of the arm model: bodies, what is seen of the person, actuators and sensors.

``mirror`` is 1 for a right arm and -1 for a left one, as in the hand's parts.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from handsim.arm.arm_geometry import SHOULDER_OF_STATURE, ArmGeometry, SegmentInertia
from handsim.arm.arm_joints import ARM_JOINTS
from handsim.arm.arm_strength import (
    ARMATURE,
    PASSIVE_DAMPING,
    arm_damping,
    arm_gains,
    arm_torque_limits,
)
from handsim.hand.mjcf import hand_class
from handsim.types import Array, HandSize

# Axes of the hinges of a right arm in the frame of their body; x ahead, y left, z up.
_AXES = ((0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0), (-1.0, 0.0, 0.0))
FLAT = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [-1.0, 0.0, 0.0]])
"""Axes of the hand in the frame of the hanging forearm of a right arm, as columns."""

# What is seen, / stature: nothing of it weighs or touches.
_SLEEVE = ((0.0325, 0.0315, 0.034), (0.0335, 0.0325, 0.072))  # the shoulder's cap, what hangs of it
_UPPER_ARM = (0.031, 0.027)  # at the middle, at the elbow
_ELBOW = 0.0255
_FOREARM = (0.027, 0.018)  # the belly below the elbow, before the wrist
_TRUNK = (  # height of the centre above the shoulders, semi-axes
    ("chest", -0.105, (0.063, 0.093, 0.120)),
    ("collarbones", -0.022, (0.042, 0.122, 0.046)),
    ("neckline", 0.008, (0.035, 0.066, 0.036)),
    ("waist", -0.22, (0.060, 0.084, 0.12)),
)
_NECK = 0.027  # radius

_Vector = Array | list[float]


def add_arm_defaults(spec: mujoco.MjSpec, size: HandSize, prefix: str) -> str:
    """Add the default classes of an arm and of what is seen of the person; return the arm's name.

    All of the arm is of class ``right_arm``. Of ``right_arm_looks`` is what neither weighs nor
    touches.
    """
    name = f"{prefix}{size.side}_arm"
    arm = spec.add_default(name, spec.default)
    arm.joint.type = mujoco.mjtJoint.mjJNT_HINGE
    arm.joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    looks = spec.add_default(f"{name}_looks", arm).geom
    looks.type = mujoco.mjtGeom.mjGEOM_ELLIPSOID
    looks.material = f"{prefix}skin"
    looks.contype = looks.conaffinity = 0
    looks.density = 0.0
    return name


def add_hinge(
    spec: mujoco.MjSpec, body: mujoco.MjsBody, index: int, mirror: float, prefix: str
) -> None:
    """Add one of the arm's hinges to a body."""
    joint, kind = ARM_JOINTS[index], ARM_JOINTS[index].name.split("_")[0]
    axis = np.array(_AXES[index]) * [1.0, mirror, 1.0] * mirror  # a mirror turns rotations round
    if index == len(ARM_JOINTS) - 1:
        axis = np.array(_AXES[index]) * mirror  # in the hand's frame, x along the forearm
    body.add_joint(
        name=f"{prefix}{joint.name}",
        axis=axis,
        range=np.deg2rad([joint.lower_deg, joint.upper_deg]),
        armature=ARMATURE[kind],
        damping=[PASSIVE_DAMPING[kind], 0, 0],
    )


def set_inertia(body: mujoco.MjsBody, segment: SegmentInertia) -> None:
    """Give a body that hangs along -z its mass."""
    body.explicitinertial = True
    body.mass = segment.mass
    body.ipos = [0.0, 0.0, -segment.centre]
    body.inertia = [segment.across, segment.across, segment.along]


def stub_inertia(stub: mujoco.MjsGeom, forearm: float) -> SegmentInertia:
    """Return the inertia of the hand's own stub of a forearm, seen from the elbow."""
    a, b, c = stub.size
    mass = float(stub.density * 4 / 3 * np.pi * a * b * c)
    across = float(mass / 5 * (a**2 + (b**2 + c**2) / 2))
    return SegmentInertia(mass, forearm + stub.pos[0], across, float(mass / 5 * (b**2 + c**2)))


def add_looks(
    spec: mujoco.MjSpec,
    upper_arm: mujoco.MjsBody,
    lower_arm: mujoco.MjsBody,
    forearm: mujoco.MjsBody,
    geometry: ArmGeometry,
    prefix: str,
) -> None:
    """Add flesh that is seen only: shoulder, upper arm, elbow, forearm."""
    tall, reach, lower = geometry.stature, geometry.upper_arm, geometry.forearm
    middle, elbow = (tall * each for each in _UPPER_ARM)
    belly, wrist = (tall * each for each in _FOREARM)
    looks = spec.find_default(f"{prefix}{geometry.size.side}_arm_looks")
    upper, under = _Flesh(upper_arm, prefix, looks), _Flesh(lower_arm, prefix, looks)
    sleeve = _Flesh(upper_arm, prefix, looks, f"{prefix}shirt")
    cap, hanging = (tall * np.array(each) for each in _SLEEVE)
    sleeve.ellipsoid("deltoid", [0, 0, -0.010 * tall], cap)
    sleeve.ellipsoid("sleeve", [0, 0, -0.046 * tall], hanging)
    upper.ellipsoid("upper_arm_muscle", [0, 0, -0.45 * reach], [middle, middle, 0.52 * reach])
    upper.capsule("upper_arm", [0, 0, -0.15 * reach], [0, 0, -reach], elbow)
    upper.ellipsoid("elbow", [0, 0, -reach], [tall * _ELBOW] * 3)
    under.ellipsoid("forearm_muscle", [0, 0, -0.33 * lower], [belly, belly, 0.42 * lower])
    under.capsule("ulna", [0, 0, -0.05 * lower], [0, 0, -0.75 * lower], wrist)
    # The part that turns: broad to the thumb's side and thin across, as a forearm is at the wrist.
    of_hand = spec.find_default(f"{prefix}{hand_class(geometry.size)}_looks")
    _Flesh(forearm, prefix, of_hand, f"{prefix}skin").ellipsoid(
        "radius", [-0.40 * lower, 0, 0], [0.42 * lower, 1.15 * wrist, wrist]
    )


def add_trunk(
    scene: mujoco.MjSpec,
    shoulder: Array,
    geometry: ArmGeometry,
    mirror: float,
    prefix: str,
    *,
    other_arm: bool = True,
) -> None:
    """Add the rest of a person without a head behind the table, seen only."""
    tall = geometry.stature
    middle = shoulder + np.array([0.0, mirror * SHOULDER_OF_STATURE * tall, 0.0])
    body = scene.worldbody.add_body(name=f"{prefix}trunk", pos=middle)
    looks = scene.find_default(f"{prefix}{geometry.size.side}_arm_looks")
    shirt = _Flesh(body, prefix, looks, f"{prefix}shirt")
    for name, height, size in _TRUNK:
        shirt.ellipsoid(name, [0, 0, height * tall], tall * np.array(size))
    if other_arm:
        _add_other_arm(body, looks, geometry, mirror, prefix)
    neck = mujoco.mjtGeom.mjGEOM_CYLINDER
    top = [0.006 * tall, 0, 0.062 * tall]
    _Flesh(body, prefix, looks).capsule("neck", [0, 0, 0.02 * tall], top, tall * _NECK, neck)


def _add_other_arm(
    trunk: mujoco.MjsBody,
    looks: mujoco.MjsDefault,
    geometry: ArmGeometry,
    mirror: float,
    prefix: str,
) -> None:
    """Add the arm that does nothing, its forearm towards the lap."""
    tall, aside = geometry.stature, mirror * SHOULDER_OF_STATURE * geometry.stature
    elbow = [0.0, 1.08 * aside, -geometry.upper_arm]
    wrist = [elbow[0] + 0.35 * geometry.forearm, 0.75 * aside, elbow[2] - 0.85 * geometry.forearm]
    cap, hanging = (tall * np.array(each) for each in _SLEEVE)
    sleeve = _Flesh(trunk, prefix, looks, f"{prefix}shirt")
    skin = _Flesh(trunk, prefix, looks)
    sleeve.ellipsoid("other_deltoid", [0, aside, -0.010 * tall], cap)
    sleeve.ellipsoid("other_sleeve", [0, aside, -0.046 * tall], hanging)
    skin.capsule("other_upper_arm", [0, aside, -0.05 * tall], elbow, tall * _UPPER_ARM[1])
    skin.capsule("other_forearm", elbow, wrist, tall * _FOREARM[1])


@dataclass(frozen=True)
class _Flesh:
    """Adds to a body what is seen and neither weighs nor touches."""

    body: mujoco.MjsBody
    prefix: str
    looks: mujoco.MjsDefault
    material: str | None = None

    def ellipsoid(self, name: str, pos: _Vector, size: _Vector) -> None:
        """Add an ellipsoid."""
        self._add(name, pos=pos, size=size)

    def capsule(
        self,
        name: str,
        start: list[float],
        end: list[float],
        radius: float,
        kind: mujoco.mjtGeom = mujoco.mjtGeom.mjGEOM_CAPSULE,
    ) -> None:
        """Add a capsule, or a cylinder, from a start to an end."""
        self._add(f"{name}_bone", type=kind, fromto=[*start, *end], size=[radius, 0, 0])

    def _add(self, name: str, **shape: Any) -> None:
        if self.material:
            shape["material"] = self.material
        self.body.add_geom(self.looks, name=f"{self.prefix}{name}_looks", **shape)


def add_arm_actuators(
    scene: mujoco.MjSpec, geometry: ArmGeometry, stiffness: float, prefix: str
) -> None:
    """Add one position actuator a joint, shoulder first, and what is measured of them."""
    gains, limits = arm_gains(geometry, stiffness), arm_torque_limits(geometry)
    damping = arm_damping(geometry, stiffness)
    for i, joint in enumerate(ARM_JOINTS):
        name = f"{prefix}{joint.name}"
        actuator = scene.add_actuator(
            name=name,
            target=name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            forcerange=[-limits[i], limits[i]],
        )
        actuator.set_to_position(kp=gains[i], kv=damping[i])
        for suffix, kind, of in (
            ("position", mujoco.mjtSensor.mjSENS_JOINTPOS, mujoco.mjtObj.mjOBJ_JOINT),
            ("velocity", mujoco.mjtSensor.mjSENS_JOINTVEL, mujoco.mjtObj.mjOBJ_JOINT),
            ("force", mujoco.mjtSensor.mjSENS_ACTUATORFRC, mujoco.mjtObj.mjOBJ_ACTUATOR),
        ):
            scene.add_sensor(name=f"{name}_{suffix}", type=kind, objtype=of, objname=name)
