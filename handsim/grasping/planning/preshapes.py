"""Open and shut postures of each kind of grasp, between which the hand closes to an object's width.

The angles were chosen and tried on the objects. Their signs and sizes follow what people do: the
thumb is opposed, MCP joints lead in a grasp from above, and PIP joints lead in a wrap.
"""

from dataclasses import dataclass, replace

from handsim.hand.postures import Flexions, posture_of_degrees
from handsim.joints import FINGERS
from handsim.objects.grasp import Grasp
from handsim.types import Array

PINCHED = 0.015
"""Width below which an object is pinched between fingertips [m]."""
LONG_FINGERS = FINGERS[1:]


def posture(fingers: Flexions = (0, 0, 0), **others: float) -> Array:
    """Return a posture (22,) [rad] from angles in degrees, all long fingers alike.

    Parameters
    ----------
    fingers
        Flexion of MCP, PIP and DIP of the four long fingers [deg].
    **others
        Single joints by name [deg]; they override ``fingers``.
    """
    return posture_of_degrees(dict.fromkeys(LONG_FINGERS, fingers), **others)


REST = posture(
    (15, 25, 12),
    thumb_rotation=25,
    thumb_abduction=20,
    thumb_mcp=12,
    thumb_ip=10,
    palm_arch=3,
    wrist_flexion=5,
)
"""A relaxed hand, from which every reach begins."""


@dataclass(frozen=True)
class Preshape:
    """Open and shut postures between which a kind of grasp closes.

    Attributes
    ----------
    open, shut : (22,) [rad]
    beyond
        How much farther than to the object's width the fingers are commanded to close, as a
        fraction of the way from open to shut. The object stops them; below 0 they stop before it
        and touch by the squeeze.
    sink
        How far beyond its aligned pose the palm is moved along the approach [m], so that the
        fingers close behind the middle of the object.
    squeeze
        Factor on how the hand closes further after the reach.
    grip
        What thumb and fingers press on their sides [N]; None for what the object's weight and its
        torque need.
    """

    open: Array
    shut: Array
    beyond: float = 0.0
    sink: float = 0.0
    squeeze: float = 1.0
    grip: float | None = None


_EXTENDED = {"wrist_flexion": -20.0}
_LEVEL = {"wrist_flexion": -5.0}

_TOP = Preshape(
    open=posture((40, 15, 8), thumb_rotation=80, thumb_abduction=45, thumb_ip=5, **_LEVEL),
    shut=posture(
        (72, 28, 14),
        thumb_rotation=95,
        thumb_abduction=35,
        thumb_mcp=20,
        thumb_ip=22,
        palm_arch=6,
        **_LEVEL,
    ),
    beyond=0.08,
    sink=0.006,
)

_CURLED = {
    "ring_mcp": 55.0, "ring_pip": 55.0, "ring_dip": 20.0,
    "little_mcp": 55.0, "little_pip": 60.0, "little_dip": 20.0,
}  # fmt: skip

PINCH = Preshape(
    open=posture(
        (0, 0, 0),
        index_mcp=37, index_pip=31.5, index_dip=40, index_abduction=-4.2,
        middle_mcp=24.5, middle_pip=62, middle_dip=23.4,
        ring_mcp=32.5, ring_pip=31.3, ring_dip=42,
        little_mcp=45, little_pip=40, little_dip=20,
        thumb_rotation=96, thumb_abduction=34, thumb_mcp=-7.5, thumb_ip=72, **_LEVEL,
    ),
    shut=posture(
        (0, 0, 0),
        index_mcp=60.7, index_pip=31, index_dip=33.5, index_abduction=-3,
        middle_mcp=48, middle_pip=61, middle_dip=19.4,
        ring_mcp=53.2, ring_pip=34.6, ring_dip=38.8,
        little_mcp=45, little_pip=40, little_dip=20,
        thumb_rotation=104.4, thumb_abduction=7, thumb_mcp=-1.6, thumb_ip=-10, **_LEVEL,
    ),
    beyond=0.1,
)  # fmt: skip
"""A grasp from above of an object thinner than a finger.

The angles, like those of the tripod, come from inverse kinematics: thumb and fingertips face each
other with their distal segments at 45 deg, and meet on a straight line."""

PRESHAPES: dict[str, Preshape] = {
    "side": Preshape(
        open=posture((20, 20, 10), thumb_rotation=90, thumb_abduction=50, **_EXTENDED),
        shut=posture(
            (62, 68, 38),
            thumb_rotation=102,  # brings the thumb's pad to the height of the fingers' mean
            thumb_abduction=40,
            thumb_mcp=32,
            thumb_ip=32,
            palm_arch=8,
            **_EXTENDED,
        ),
        beyond=0.12,
        sink=0.02,
        squeeze=0.8,
    ),
    "top": _TOP,
    "edge": replace(_TOP, sink=0.0),
    "handle": Preshape(
        open=posture(
            (40, 30, 10),
            ring_mcp=60, ring_pip=70, little_mcp=65, little_pip=75,
            thumb_rotation=80, thumb_abduction=40, **_LEVEL,
        ),
        shut=posture(
            (75, 45, 20),
            ring_mcp=80, ring_pip=85, little_mcp=82, little_pip=88,
            thumb_rotation=95, thumb_abduction=25, thumb_mcp=15, thumb_ip=15, **_LEVEL,
        ),
        beyond=0.1,
    ),
    "tripod": Preshape(
        open=posture(
            (0, 0, 0),
            index_mcp=34.5, index_pip=23, index_dip=46, index_abduction=-4.4,
            middle_mcp=24, middle_pip=51, middle_dip=33,
            **_CURLED,
            thumb_rotation=94.5, thumb_abduction=16, thumb_mcp=-10, thumb_ip=57, **_LEVEL,
        ),
        shut=posture(
            (0, 0, 0),
            index_mcp=54.5, index_pip=31, index_dip=46.7, index_abduction=-3.1,
            middle_mcp=43.7, middle_pip=57.6, middle_dip=33,
            **_CURLED,
            thumb_rotation=97.7, thumb_abduction=2.8, thumb_mcp=-1.4, thumb_ip=-12.2, **_LEVEL,
        ),
        beyond=0.1,
    ),
    "rest": Preshape(
        open=posture(
            (8, 22, 10),
            ring_mcp=15, ring_pip=25, little_mcp=20, little_pip=25,
            index_abduction=2, ring_abduction=12, little_abduction=18,
            thumb_rotation=30, thumb_abduction=35, thumb_mcp=5, wrist_flexion=-20,
        ),
        shut=posture(
            (8, 22, 10),
            ring_mcp=28, ring_pip=32, ring_dip=15, little_mcp=30, little_pip=32, little_dip=15,
            ring_abduction=-8, little_abduction=-8,
            thumb_rotation=35, thumb_abduction=0, thumb_mcp=15, thumb_ip=20, wrist_flexion=-20,
        ),
        beyond=0.15,
        grip=2.0,  # enough to move a mouse, too little to turn it
    ),
    "loops": Preshape(
        open=posture(
            (50, 12, 5),
            ring_mcp=60, ring_pip=70, little_mcp=65, little_pip=75,
            thumb_rotation=85, thumb_abduction=45, **_LEVEL,
        ),
        shut=posture(
            (75, 20, 10),
            ring_mcp=75, ring_pip=80, little_mcp=78, little_pip=85,
            thumb_rotation=95, thumb_abduction=30, thumb_mcp=15, thumb_ip=15, **_LEVEL,
        ),
        squeeze=0.3,
        grip=0.4,  # scissors shut as soon as they are pressed harder
    ),
}  # fmt: skip
"""Preshapes by kind of grasp."""


def preshape_for(grasp: Grasp) -> Preshape:
    """Return the preshape of a grasp, by its kind and width."""
    if grasp.kind == "top" and grasp.width < PINCHED:
        return PINCH
    return PRESHAPES[grasp.kind]
