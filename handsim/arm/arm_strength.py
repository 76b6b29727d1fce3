"""Torque limits, stiffness and damping of the arm's joints, and what makes an arm follow a path.

Sources, and how sure they are
------------------------------
[1] Stobbe (1982), as in Chaffin, Andersson & Martin (2006), Occupational Biomechanics, 4th ed.,
    joint strengths of workers, median of men (women): elbow flexion 77 (41) and extension 46 (27),
    shoulder rotation inwards 52 (21) and outwards 33 (19), shoulder abduction 71 (37), horizontal
    flexion 92 (40) and extension 67 (33) N m. Medium confidence: from the table as commonly cited.
[2] O'Sullivan & Gallwey (2002), J. Electromyogr. Kinesiol. 12(4):275-285, 24 men: pronation 13.1,
    supination 16.2 N m. High confidence.
[3] Gomi & Osu (1998), J. Neurosci. 18(21):8965-8978: the stiffness of a joint grows in
    proportion to its torque, and with co-contraction. Mussa-Ivaldi, Hogan & Bizzi (1985),
    J. Neurosci. 5(10):2732-2743: stiffness of a resting hand some 200 to 500 N/m.
[4] Gomi & Kawato (1997), Biol. Cybern. 76:163-171: arms so compliant follow their paths because the
    forces needed are sent ahead (internal models), not because stiffness pulls them along.
"""

from functools import cache
from types import MappingProxyType

import numpy as np

from handsim.arm.arm_geometry import ArmGeometry
from handsim.arm.arm_joints import ARM_JOINT_NAMES
from handsim.hand.anthropometry import HandGeometry
from handsim.types import MEDIAN_HAND, Array

# Maximal voluntary torque of the median man [1, 2] [N m], of the weaker direction where a hinge has
# two; turning the plane of elevation is horizontal extension, lifting is abduction.
_STRONGEST: MappingProxyType[str, float] = MappingProxyType(
    {
        "shoulder_plane": 67.0,
        "shoulder_elevation": 71.0,
        "shoulder_rotation": 33.0,
        "elbow_flexion": 46.0,
        "forearm_rotation": 13.1,
    }
)
SATURATION = 0.6
"""Position error at which a joint has reached its greatest torque [rad].

Gain = torque / saturation: 112 N m/rad at the elevation of the shoulder, 77 at the elbow. At the
hand of a bent arm this is 400 to 1000 N/m (`endpoint_stiffness`): a person who holds the arm
stiffly [3]."""
DAMPING_RATIO = 1.0
"""Of each joint with the inertia that it moves in the arm at work. People's is 0.2 to 0.7 without,
and more with, reflexes; it is 1 because nothing else damps here."""
PASSIVE_DAMPING = MappingProxyType({"shoulder": 0.3, "elbow": 0.2, "forearm": 0.05})
"""Of tissue [N m s/rad]. Low confidence: a tenth of what active arms have."""
ARMATURE = MappingProxyType({"shoulder": 0.02, "elbow": 0.01, "forearm": 0.003})
"""Inertia added to the hinges [kg m2]: 5 to 15 % of what they move, for stability where the axes
of plane and rotation fall into one in the hanging arm."""


def arm_torque_limits(geometry: ArmGeometry) -> Array:
    """Return the greatest voluntary torque of the 5 joints, (5,) [N m].

    The median man's [1, 2], with the cube of stature: forces grow with the section of muscles,
    levers with length. Women's are lower than that: 0.55 of the median man's where the cube
    gives 0.82.
    """
    scale = (geometry.stature / ArmGeometry(MEDIAN_HAND).stature) ** 3
    return scale * np.array([_STRONGEST[name] for name in ARM_JOINT_NAMES])


def arm_gains(geometry: ArmGeometry, stiffness: float = 1.0) -> Array:
    """Return the gains of the position actuators, (5,) [N m/rad].

    Parameters
    ----------
    geometry
    stiffness
        Factor: 0.3 is a relaxed arm, 1 one that is held stiffly.
    """
    return stiffness * arm_torque_limits(geometry) / SATURATION


@cache
def moved_inertia(geometry: ArmGeometry) -> Array:
    """Return the inertia that each joint moves in an arm at work, (5,) [kg m2].

    Elbow at a right angle, upper arm lifted by 45 deg, the hand a mass at its palm.
    """
    upper, fore = geometry.upper_arm_inertia, geometry.forearm_inertia
    hand, palm = HandGeometry(geometry.size).mass, geometry.forearm + 0.4 * geometry.size.length
    beyond = fore.across + fore.mass * fore.centre**2 + hand * palm**2
    carried = upper.across + upper.mass * upper.centre**2
    carried += (fore.mass + hand) * geometry.upper_arm**2
    turning = fore.along + hand * (0.3 * geometry.size.breadth) ** 2
    kinds = [name.split("_")[0] for name in ARM_JOINT_NAMES]
    shoulder = carried + beyond
    made = np.array(
        [shoulder * np.sin(np.pi / 4) ** 2 + 0.5 * beyond, shoulder, beyond, beyond, turning]
    )
    made += [ARMATURE[kind] for kind in kinds]
    made.flags.writeable = False
    return made


def arm_damping(geometry: ArmGeometry, stiffness: float = 1.0) -> Array:
    """Return the damping of the position actuators, (5,) [N m s/rad]."""
    return 2 * DAMPING_RATIO * np.sqrt(arm_gains(geometry, stiffness) * moved_inertia(geometry))


def leading_targets(
    arm: Array, step: float, geometry: ArmGeometry, stiffness: float = 1.0
) -> Array:
    """Return targets with which compliant joints follow a path instead of lagging behind it [4].

    A position actuator gives gain (target - q) - damping velocity. The target therefore leads by
    damping / gain times the velocity and by inertia / gain times the acceleration, each joint for
    itself.

    Parameters
    ----------
    arm : (n, 5) [rad]
        The path, at equal steps.
    step
        Between its rows [s].
    geometry, stiffness
        As the arm was built with.
    """
    if len(arm) < 3:
        return arm.copy()
    gains = arm_gains(geometry, stiffness)
    damping = arm_damping(geometry, stiffness) + [
        PASSIVE_DAMPING[name.split("_")[0]] for name in ARM_JOINT_NAMES
    ]
    velocity = np.gradient(arm, step, axis=0)
    acceleration = np.gradient(velocity, step, axis=0)
    return arm + (damping * velocity + moved_inertia(geometry) * acceleration) / gains
