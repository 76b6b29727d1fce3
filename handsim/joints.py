"""The 22 joints of the hand in the order of the data glove's sensors.

Signs: flexion and spreading are positive. ``q`` is always (22,) or (n, 22) in rad, in this order.

The joints are those of the paper's Sec. VI-A: 14 flexions, 5 ab/adductions (the thumb's rotation
among them), the palm arch and 2 at the wrist. The middle finger is the reference for spreading
and has no abduction of its own.

Ranges: Buchholz & Armstrong (1992), J. Biomech. 25(2):149-162, and three published hand models
that differ by up to 20 deg; the widest plausible value is kept, because real glove angles
leave narrower ranges.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from handsim.types import Array

Finger = Literal["thumb", "index", "middle", "ring", "little"]
Motion = Literal["flexion", "abduction", "rotation", "arch", "deviation"]

FINGERS: tuple[Finger, ...] = ("thumb", "index", "middle", "ring", "little")
CONTACT_PARTS: tuple[str, ...] = (*FINGERS, "palm")
"""Parts of the hand whose contact load on the object is kept, in column order."""


@dataclass(frozen=True)
class Joint:
    """One hinge of the hand and the glove sensor that measures it.

    Attributes
    ----------
    name
        Name in files, in the MJCF model and of its actuator.
    sensor
        The glove maker's name of the sensor.
    finger
        The finger the joint belongs to; None for the palm arch and the wrist.
    motion
        What a positive angle does: ``flexion`` closes, ``abduction`` spreads away from the middle
        finger (the thumb: opens the web, in the plane its rotation has reached), ``rotation``
        opposes the thumb, ``arch`` cups the palm, ``deviation`` turns the hand to the thumb's side.
    lower_deg, upper_deg
        Range of motion [deg].
    """

    name: str
    sensor: str
    finger: Finger | None
    motion: Motion
    lower_deg: float
    upper_deg: float


JOINTS: tuple[Joint, ...] = (
    Joint("thumb_rotation", "thumb roll", "thumb", "rotation", -10, 120),
    Joint("thumb_mcp", "thumb inner", "thumb", "flexion", -10, 75),
    Joint("thumb_ip", "thumb outer", "thumb", "flexion", -20, 80),
    Joint("thumb_abduction", "thumb abduction", "thumb", "abduction", -5, 65),
    Joint("index_mcp", "index inner", "index", "flexion", -20, 90),
    Joint("index_pip", "index middle", "index", "flexion", 0, 110),
    Joint("index_dip", "index outer", "index", "flexion", -5, 80),
    Joint("middle_mcp", "middle inner", "middle", "flexion", -20, 90),
    Joint("middle_pip", "middle middle", "middle", "flexion", 0, 110),
    Joint("middle_dip", "middle outer", "middle", "flexion", -5, 80),
    Joint("index_abduction", "index-middle abduction", "index", "abduction", -10, 25),
    Joint("ring_mcp", "ring inner", "ring", "flexion", -20, 90),
    Joint("ring_pip", "ring middle", "ring", "flexion", 0, 110),
    Joint("ring_dip", "ring outer", "ring", "flexion", -5, 80),
    Joint("ring_abduction", "ring-middle abduction", "ring", "abduction", -10, 20),
    Joint("little_mcp", "little inner", "little", "flexion", -20, 90),
    Joint("little_pip", "little middle", "little", "flexion", 0, 110),
    Joint("little_dip", "little outer", "little", "flexion", -5, 80),
    Joint("little_abduction", "little-ring abduction", "little", "abduction", -10, 30),
    Joint("palm_arch", "palm arch", None, "arch", 0, 20),
    Joint("wrist_flexion", "wrist pitch", None, "flexion", -70, 80),
    Joint("wrist_deviation", "wrist yaw", None, "deviation", -30, 20),
)
"""The 22 joints in glove order."""

JOINT_NAMES: tuple[str, ...] = tuple(joint.name for joint in JOINTS)
"""Names of the 22 joints in glove order."""
N_JOINTS = len(JOINTS)
JOINT_INDEX: dict[str, int] = {name: i for i, name in enumerate(JOINT_NAMES)}


def _read_only(values: list[float]) -> Array:
    array = np.deg2rad(np.array(values, dtype=float))
    array.flags.writeable = False
    return array


LOWER: Array = _read_only([joint.lower_deg for joint in JOINTS])
"""Lower ends of the ranges of motion, (22,) [rad]."""
UPPER: Array = _read_only([joint.upper_deg for joint in JOINTS])
"""Upper ends of the ranges of motion, (22,) [rad]."""


def clip_to_range(q: Array) -> Array:
    """Clip postures to the ranges of motion, as is done only where they drive the hand.

    Parameters
    ----------
    q : (..., 22) [rad]
    """
    return np.minimum(np.maximum(q, LOWER), UPPER)  # faster than np.clip
