"""Torque limits and gains of the hand's position actuators, derived from one fingertip force."""

import numpy as np

from handsim.hand.anthropometry import LENGTHS, HandGeometry, first_segment
from handsim.joints import JOINTS, Joint
from handsim.types import Array

FINGERTIP_FORCE = 30.0
"""What each fingertip can push with [N]: about 40 % of a man's maximal tip pinch (Mathiowetz et
al. 1985, Arch. Phys. Med. Rehabil. 66:69-74), a force that can be kept up."""
SATURATION = 0.4
"""Position error at which an actuator reaches its torque limit [rad].

Gain = limit / saturation, so that all flexors of a finger offset by the same angle push with
about the same force at the fingertip: 1.3 N per degree."""
SPREADING_STRENGTH = 0.5
"""Torque of the interossei that spread the fingers, relative to that of the flexors."""
DAMPING_RATIO = 1.0
"""Of each actuator with the inertia it moves in the zero posture: no overshoot."""


def torque_limits(geometry: HandGeometry) -> Array:
    """Return the torque with which each joint makes its fingertip push with `FINGERTIP_FORCE`.

    The lever reaches from the joint to the tip of the straight finger. The palm arch carries two
    fingers at up to a hand breadth from its axis, the wrist four at the middle finger's PIP joint.

    Returns
    -------
    (22,) [N m]
    """
    return FINGERTIP_FORCE * np.array([_lever(joint, geometry) for joint in JOINTS])


def position_gains(geometry: HandGeometry) -> Array:
    """Return the gains of the position actuators, (22,) [N m/rad]."""
    return torque_limits(geometry) / SATURATION


def _lever(joint: Joint, geometry: HandGeometry) -> float:
    """Sum of the levers of the fingertip forces about a joint [m]."""
    if joint.name == "palm_arch":
        return 2 * geometry.size.breadth
    if joint.finger is None:
        return 4 * (geometry.mcp("middle")[0] + LENGTHS["middle"][0] * geometry.size.length)
    lever = sum(LENGTHS[joint.finger][first_segment(joint) :]) * geometry.size.length
    spreads = joint.motion == "abduction" and joint.finger != "thumb"
    return lever * (SPREADING_STRENGTH if spreads else 1.0)
