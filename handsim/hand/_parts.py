"""Parts of the hand model: bodies, ellipsoids, fingertips, actuators and sensors.

``mirror`` is 1 for a right hand and -1 for a left one: positions and axes are those of the right
hand mirrored at the plane y = 0, hinges turned round, so that the same q is the mirrored posture.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from itertools import pairwise

import mujoco
import numpy as np

from handsim.hand.anthropometry import HandGeometry, first_segment, segment_names
from handsim.hand.skeleton import segments
from handsim.hand.strength import DAMPING_RATIO, position_gains, torque_limits
from handsim.joints import FINGERS, JOINT_NAMES, JOINTS, Joint
from handsim.types import Array

KNUCKLE = 0.93
"""Radius of the balls that fill the necks between segments, relative to the segments' mean; they
are seen and neither weigh nor touch anything."""


def add_bodies(
    spec: mujoco.MjSpec, kind: str, carrier: mujoco.MjsBody, geometry: HandGeometry, mirror: float
) -> dict[str, mujoco.MjsBody]:
    """Add forearm, palm, segments and their hinges, of class ``kind``; return bodies by name."""
    bodies = {"forearm": carrier.add_body(name="forearm", gravcomp=1.0, childclass=kind)}
    flip = np.array([1.0, mirror, 1.0])
    for segment in segments(geometry):
        quat = np.empty(4)
        mujoco.mju_mat2Quat(quat, segment.axes.ravel())
        body = bodies[segment.parent].add_body(
            name=segment.name,
            pos=flip * segment.origin,
            quat=quat * [1.0, mirror, 1.0, mirror],
            gravcomp=1.0,
        )
        for hinge in segment.hinges:
            joint = hinge.joint
            body.add_joint(
                spec.find_default(f"{kind}_{_joint_class(joint)}"),
                name=joint.name,
                axis=mirror * flip * hinge.axis,  # a mirror turns rotations round
                range=_range(joint),
            )
        bodies[segment.name] = body
    return bodies


def _joint_class(joint: Joint) -> str:
    if joint.finger is None:
        return "knuckle" if joint.motion == "arch" else "wrist"
    return "phalanx" if first_segment(joint) else "knuckle"


def _range(joint: Joint) -> Array:
    return np.deg2rad([joint.lower_deg, joint.upper_deg])


def add_ellipsoids(
    spec: mujoco.MjSpec,
    kind: str,
    bodies: dict[str, mujoco.MjsBody],
    geometry: HandGeometry,
    mirror: float,
) -> None:
    """Add what has mass and touches, and the site on the palm."""
    hand = spec.find_default(kind)
    length, breadth = geometry.size.length, geometry.size.breadth
    bodies["forearm"].add_geom(  # a stub, so that the hand is not cut off at the wrist
        hand,
        name="forearm_geom",
        pos=[-0.36 * length, 0.0, -0.03 * breadth],
        size=[0.5 * length, 0.37 * breadth, 0.28 * breadth],
    )
    for ellipsoid in geometry.ellipsoids:
        turn = mirror * np.arctan2(ellipsoid.direction[1], ellipsoid.direction[0]) / 2
        bodies[ellipsoid.body].add_geom(
            hand,
            name=f"{ellipsoid.name}_geom",
            pos=ellipsoid.centre * [1.0, mirror, 1.0],
            quat=[np.cos(turn), 0, 0, np.sin(turn)],
            size=ellipsoid.semi_axes,
        )
    palm = geometry.ellipsoid("palm_centre")
    place = (palm.centre - [0.0, 0.0, palm.semi_axes[2]]) * [1.0, mirror, 1.0]
    bodies["palm"].add_site(hand, name="palm_centre", pos=place)


def add_fingertips(
    spec: mujoco.MjSpec, kind: str, bodies: dict[str, mujoco.MjsBody], geometry: HandGeometry
) -> None:
    """Add the sites at tips and pads, and what is only seen: nails and finger joints."""
    hand, looks, nails = (spec.find_default(kind + part) for part in ("", "_looks", "_nail"))
    for finger in FINGERS:
        names = segment_names(finger)
        shape = geometry.ellipsoid(names[2])
        middle, (along, across, thick) = shape.centre[0], shape.semi_axes
        body = bodies[names[2]]
        body.add_site(hand, name=f"{finger}_tip", pos=[middle + along, 0, 0])
        body.add_site(hand, name=f"{finger}_pad", pos=[middle, 0, -thick])
        body.add_site(  # encloses the segment, so that the touch sensor feels all of it
            hand,
            name=f"{finger}_touch",
            type=mujoco.mjtGeom.mjGEOM_ELLIPSOID,
            pos=shape.centre,
            size=1.1 * shape.semi_axes,
        )
        body.add_geom(
            nails,
            name=f"{finger}_nail",
            pos=[middle + 0.40 * along, 0, 0.60 * thick],
            quat=[np.cos(0.16), 0, np.sin(0.16), 0],
            size=[0.48 * along, 0.70 * across, 0.36 * thick],
        )
        for inner, outer in pairwise(names):
            radii = [geometry.ellipsoid(name).semi_axes[2] for name in (inner, outer)]
            size = np.full(3, KNUCKLE * np.mean(radii))
            bodies[outer].add_geom(looks, name=f"{outer}_knuckle", size=size)


def add_actuators(spec: mujoco.MjSpec, geometry: HandGeometry) -> None:
    """Add one position actuator a joint, in glove order."""
    gains, limits = position_gains(geometry), torque_limits(geometry)
    for joint, gain, limit in zip(JOINTS, gains, limits, strict=True):
        actuator = spec.add_actuator(
            name=joint.name,
            target=joint.name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            ctrlrange=_range(joint),
            forcerange=[-limit, limit],
        )
        actuator.set_to_position(kp=gain, dampratio=DAMPING_RATIO)


def add_sensors(spec: mujoco.MjSpec) -> None:
    """Add position, velocity and actuator force of every joint, and touch of every fingertip."""
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
