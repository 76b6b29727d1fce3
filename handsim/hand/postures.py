"""Named postures of the whole hand, which are also the keyframes of the model.

Pinch, tripod and fist were found by letting the median man's hand close in simulation until the
parts named touched; they hold for other sizes too, since all lengths grow together.
"""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from handsim.errors import UnknownNameError
from handsim.joints import JOINT_INDEX, N_JOINTS, Finger
from handsim.types import Array

Flexions = tuple[float, float, float]


def posture_of_degrees(fingers: Mapping[Finger, Flexions], **others: float) -> Array:
    """Return a posture (22,) [rad], read-only, from angles in degrees.

    Parameters
    ----------
    fingers
        Flexion of MCP, PIP and DIP by finger [deg].
    **others
        Single joints by name [deg]; they override ``fingers``.
    """
    q = np.zeros(N_JOINTS)
    for finger, flexions in fingers.items():
        for place, angle in zip(("mcp", "pip", "dip"), flexions, strict=True):
            q[JOINT_INDEX[f"{finger}_{place}"]] = np.deg2rad(angle)
    for name, angle in others.items():
        q[JOINT_INDEX[name]] = np.deg2rad(angle)
    q.flags.writeable = False
    return q


POSTURES: MappingProxyType[str, Array] = MappingProxyType(
    {
        "flat": posture_of_degrees({}),
        "rest": posture_of_degrees(
            {
                "index": (28, 32, 14),
                "middle": (32, 36, 16),
                "ring": (34, 38, 17),
                "little": (36, 38, 17),
            },
            thumb_rotation=45,
            thumb_abduction=12,
            thumb_mcp=12,
            thumb_ip=15,
            index_abduction=3,
            ring_abduction=2,
            little_abduction=5,
            palm_arch=4,
            wrist_flexion=-15,
        ),
        "fist": posture_of_degrees(
            {
                "index": (88, 107, 72),
                "middle": (89, 107, 72),
                "ring": (88, 107, 72),
                "little": (87, 105, 70),
            },
            thumb_rotation=82,
            thumb_abduction=37,
            thumb_mcp=50,
            thumb_ip=38,
        ),
        "pinch": posture_of_degrees(
            {
                "index": (66, 37, -4),
                "middle": (35, 35, 15),
                "ring": (30, 35, 15),
                "little": (25, 30, 15),
            },
            thumb_rotation=87,
            thumb_abduction=16,
            thumb_ip=-13,
            index_abduction=-2,
        ),
        "tripod": posture_of_degrees(
            {
                "index": (71, 31, -4),
                "middle": (60, 55, 1),
                "ring": (55, 60, 25),
                "little": (55, 60, 25),
            },
            thumb_rotation=96,
            thumb_abduction=13,
            thumb_mcp=-6,
            thumb_ip=-20,
            index_abduction=-2,
        ),
    }
)
"""Each (22,) [rad], read-only. ``rest``: the relaxed hand, wrist a little extended."""


def posture(name: str) -> Array:
    """Return a named posture, (22,) [rad].

    Raises
    ------
    UnknownNameError
        If there is none of that name.
    """
    if name not in POSTURES:
        raise UnknownNameError("posture", name, tuple(POSTURES))
    return POSTURES[name]
