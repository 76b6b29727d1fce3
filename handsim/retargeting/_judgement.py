"""Whether postures match, and if not, of which hand it is the limit."""

from collections.abc import Callable

import numpy as np

from handsim.joints import Finger
from handsim.types import Array, Mask

TIP_TOLERANCE = 0.25
"""How far a fingertip may be from its target, / mean length of the robot's fingers, to match."""
OPENING_TOLERANCE = 0.10
"""How far an opening may be off, / mean length of the robot's fingers and the opening together."""
_SLACK = 0.001
"""An opening within this of the least or greatest is at the robot's limit [m]."""


def judge(
    wanted: Array,
    reached: Array,
    tip: Array,
    unit: float,
    fingers: tuple[Finger, ...],
    limits: Callable[[], tuple[Array, Array]],
) -> tuple[Mask, str]:
    """Return which of n postures match, (n,), and why the others do not.

    Where there is a thumb, openings decide: it may stand elsewhere than the person's. Without one,
    fingertips do.

    Parameters
    ----------
    wanted, reached : (n, k) [m]
        Openings from the thumb, those asked for and those of the robot.
    tip : (n, k) [m]
        Distance of fingertips from their targets.
    unit
        Mean length of the robot's fingers [m].
    fingers
    limits
        Returns the robot's least and greatest openings, (k,) each [m].
    """
    off = np.abs(reached - wanted)
    with_thumb = "thumb" in fingers and len(fingers) > 1
    if with_thumb:
        excess = off / (OPENING_TOLERANCE * (unit + wanted))
    else:
        excess = tip / (TIP_TOLERANCE * unit)
    matched = np.all(excess <= 1.0, axis=1)
    if matched.all():
        return matched, ""
    i, j = (int(k) for k in np.unravel_index(np.argmax(excess), excess.shape))
    head = f"{np.sum(~matched)} of {len(matched)} postures do not match; worst is "
    if not with_thumb:
        return matched, (
            f"{head}the {fingers[j]} in posture {i}, {1e3 * tip[i, j]:.0f} mm from its target, "
            f"{excess[i, j]:.1f} times the tolerance"
        )
    least, greatest = limits()
    return matched, (
        f"{head}thumb to {fingers[j]} in posture {i}: {1e3 * reached[i, j]:.0f} mm apart where the "
        f"person's are {1e3 * wanted[i, j]:.0f} mm (to the robot's scale); "
        + _whose_limit(wanted[i, j], least[j], greatest[j], fingers[j])
    )


def _whose_limit(wanted: float, least: float, greatest: float, finger: Finger) -> str:
    """Return which hand it is that cannot."""
    if wanted > greatest + _SLACK:
        return (
            f"the robot's {finger} opens to {1e3 * greatest:.0f} mm at most: "
            "choose a smaller opening_scale"
        )
    if wanted < least - _SLACK:
        return (
            f"the robot's {finger} comes no closer than {1e3 * least:.0f} mm: "
            "correct the frames of its fingertips, or leave that finger out"
        )
    return (
        f"the robot's {finger} alone reaches it ({1e3 * least:.0f} to {1e3 * greatest:.0f} mm), "
        "but not together with the other fingers, its speed and free of collisions"
    )
