"""Short gaps in recordings, bridged and said so; long ones are left."""

import numpy as np

from handsim.joints import JOINT_NAMES
from handsim.types import Array, Mask
from handsim.wording import number_of


def bridge(time: Array, values: Array, longest: float) -> tuple[Array, Mask]:
    """Bridge gaps no longer than a stated time.

    A monotone cubic through the frames beside the gap, so that no value leaves what lies between
    them. Gaps at either end are filled with the nearest value, if they are as short.

    Parameters
    ----------
    time : (n,) [s], increasing
    values : (n, d)
        NaN where missing.
    longest
        Longest time without a value that is bridged, from the frame before the gap to the frame
        after it [s].

    Returns
    -------
    values : (n, d)
        NaN where a gap is left.
    bridged : (n, d)
        Which were filled.
    """
    filled = np.array(values, dtype=float)
    longest *= 1 + 1e-9  # times are differences of rounded numbers
    for column in filled.T:
        known = np.flatnonzero(np.isfinite(column))
        if known.size < 2 or known.size == len(column):
            continue
        from scipy.interpolate import PchipInterpolator  # takes long, and gaps are rare

        curve = PchipInterpolator(time[known], column[known], extrapolate=False)
        for start, stop in _gaps(~np.isfinite(column)):
            before, after = start - 1, stop
            if before < 0 or after >= len(time):
                inside = after if before < 0 else before
                end = time[0] if before < 0 else time[-1]
                if abs(time[inside] - end) <= longest:
                    column[start:stop] = column[inside]
            elif time[after] - time[before] <= longest:
                column[start:stop] = curve(time[start:stop])
    return filled, np.isfinite(filled) & ~np.isfinite(values)


def bridge_joints(time: Array, angles: Array, longest: float) -> tuple[Array, list[str]]:
    """Bridge gaps of the 22 joints, and say which.

    Parameters
    ----------
    time : (n,) [s], increasing
    angles : (n, 22)
        NaN where missing.
    longest
        As in `bridge`; 0 leaves all gaps.

    Returns
    -------
    angles : (n, 22)
    notes
        How many frames of which joints were filled.
    """
    if longest <= 0:
        return angles, []
    filled, bridged = bridge(time, angles, longest)
    counts = zip(JOINT_NAMES, bridged.sum(axis=0), strict=True)
    return filled, [
        f"bridged {number_of(count, 'frame')} of {name}" for name, count in counts if count
    ]


def _gaps(missing: Mask) -> list[tuple[int, int]]:
    """First frames of the gaps and the first frames after them."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], missing, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
