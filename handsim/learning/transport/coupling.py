"""Hand and arm as one movement: the hand is widest at about two thirds of the transport.

People open the hand while the arm moves and begin to close it well before the arm has arrived: the
largest aperture comes at 60 to 70 % of the movement whatever its speed (Jeannerod 1984, J. Mot.
Behav. 16(3):235-254), as if both were timed by one clock (Hoff & Arbib 1993, J. Mot. Behav.
25(3):175-192).
"""

import numpy as np

from handsim.errors import InputError
from handsim.learning.movement.progress import ProgressLaw, minimum_jerk
from handsim.types import Array

WIDEST_AT = 0.67
"""When the hand is widest, as a share of the transport's duration."""
_N_CONTROL = 16
_EARLIEST, _LATEST = 0.02, 0.95
"""Shares between which there is something to be timed. A hand that is widest at its start waits
with closing all the same; one that is widest at its end does not close."""


def widest_of(aperture: Array) -> float:
    """Return the share of a path of the hand, equally spaced, at which its aperture is largest.

    Parameters
    ----------
    aperture : (n,) [m]
    """
    return float(np.argmax(aperture)) / max(len(aperture) - 1, 1)


def hand_law(
    transport: ProgressLaw, widest: float, duration: float | None = None, at: float = WIDEST_AT
) -> ProgressLaw:
    """Return when the hand is where on its own path, so that it is widest in time.

    A minimum-jerk law over a power of time, which passes ``widest`` then. For a hand that is widest
    at the end of its path it is minimum jerk.

    Parameters
    ----------
    transport
        Of the palm.
    widest
        Share of the hand's path at which it is widest, 0 to 1 (`widest_of`).
    duration
        Of the hand's movement [s]: as long as the transport, or longer where the fingers close
        after the palm has arrived.
    at
        When, as a share of the transport's duration.

    Raises
    ------
    InputError
        If ``at`` is not between 0 and 1 or the movement ends before it.
    """
    whole = transport.duration if duration is None else duration
    moment = at * transport.duration / whole
    if not (0.0 < at < 1.0 and 0.0 < moment < 1.0):
        raise InputError(
            f"the hand cannot be widest at {at:g} of {transport.duration:g} s in a movement of "
            f"{whole:g} s; give a share between 0 and 1 and a duration beyond it"
        )
    if widest > _LATEST:
        return ProgressLaw(whole)
    grid = np.linspace(0.0, 1.0, 2001)
    when = float(np.interp(max(widest, _EARLIEST), minimum_jerk(grid, 1.0), grid))
    power = np.log(when) / np.log(moment)
    steps = np.linspace(0.0, 1.0, _N_CONTROL)
    return ProgressLaw(whole, minimum_jerk(steps**power, 1.0))
