"""How a hand closes after the reach, until its fingers touch and on, to press.

Measured joint angles are those of a hand that rests on the object. As targets of position
actuators they hardly press. So, after the reach, fingers that grasp flex in all their joints, as
fingers curl together; it is the same for every task, and is not learned. The thumb moves its pad
towards the fingers instead: beside a mouse it is not flexion that brings it there.
"""

from collections.abc import Iterable

import numpy as np

from handsim.hand.anthropometry import LENGTHS, segment_names
from handsim.hand.kinematics import Kinematics
from handsim.joints import FINGERS, JOINT_INDEX, JOINTS, N_JOINTS, Finger
from handsim.types import Array

SQUEEZE_DEG: dict[str, float] = {
    "thumb_mcp": 10,
    "thumb_ip": 12,
    **{f"{finger}_mcp": 12 for finger in ("index", "middle", "ring", "little")},
    **{f"{finger}_pip": 10 for finger in ("index", "middle", "ring", "little")},
    **{f"{finger}_dip": 5 for finger in ("index", "middle", "ring", "little")},
}
"""Flexion added to the targets [deg]. Squeezes of this order held 88 % of replayed glove postures;
without a squeeze 35 % held."""


THUMB_DEG = 12.0
"""How far that joint of the thumb moves which moves most [deg]."""
PAD = 0.6
"""Where the middle of a pad is along its segment."""
_THUMB_TIP = segment_names("thumb")[2]
_THUMB = [i for i, joint in enumerate(JOINTS) if joint.finger == "thumb"]
_NOT_THUMB = [i for i, joint in enumerate(JOINTS) if joint.finger != "thumb"]


def squeeze_offset(strength: float = 1.0, fingers: Iterable[Finger] = FINGERS) -> Array:
    """Return the flexion added to the joint targets, (22,) [rad].

    Parameters
    ----------
    strength
        Factor on the offsets of `SQUEEZE_DEG`.
    fingers
        Which fingers squeeze, beside the thumb.
    """
    offset, squeezing = np.zeros(N_JOINTS), {"thumb", *fingers}
    for name, degrees in SQUEEZE_DEG.items():
        if name.split("_")[0] not in squeezing:
            continue
        offset[JOINT_INDEX[name]] = np.deg2rad(degrees) * strength
    return offset


def closing(
    q: Array, towards: Array, fingers: Iterable[Finger], strength: float, hand: Kinematics
) -> Array:
    """Return how the joints move to close a hand on what is between thumb and fingers, (22,) [rad].

    Parameters
    ----------
    q : (22,) [rad]
        Posture from which the hand closes.
    towards : (3,)
        From the thumb to the fingers, in the palm's frame.
    fingers
        Which fingers close, beside the thumb.
    strength
        Factor on `SQUEEZE_DEG`, and on `THUMB_DEG`.
    hand
    """
    offset = squeeze_offset(strength, fingers)
    frames = hand.frames(q[None], last=_THUMB_TIP)
    way = frames.rotation[0, hand.names.index("palm")] @ towards
    pad = hand.at([_THUMB_TIP], [[PAD * LENGTHS["thumb"][2] * hand.size.length, 0.0, 0.0]])
    pull = hand.jacobian(frames, pad)[0, 0].T @ way  # of a force on the pad, as torques
    pull[_NOT_THUMB] = 0.0
    greatest = np.abs(pull).max()
    if greatest > 0.0:
        offset[_THUMB] = np.deg2rad(THUMB_DEG) * strength * pull[_THUMB] / greatest
    return offset
