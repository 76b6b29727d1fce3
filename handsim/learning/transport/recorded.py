"""Learn the palm's transport from recordings in which the palm was seen."""

from collections.abc import Iterable

import numpy as np

from handsim.errors import InputError
from handsim.learning.transport.transport import MIRROR, Transport, learn_transport
from handsim.recordings.points.palm_path import has_palm, wrist_path
from handsim.recordings.recording import Recording
from handsim.types import Progress

LEAST_REACHES = 3
"""Fewest recordings from which something that they share can be told."""
LEAST_WAY = 0.03
"""Shortest way of a palm that is a reach [m]."""


def recorded_transport(
    recordings: Iterable[Recording], *, seed: int = 0, progress: Progress | None = None
) -> Transport:
    """Learn from the wrist's ways of all recordings that hold a reach of a palm.

    Those of left hands count as their mirror images, as their postures do.

    Parameters
    ----------
    recordings
        Others than reaches with the palm's pose are left out.
    seed, progress
        As of `learn_transport`.

    Raises
    ------
    InputError
        If fewer than `LEAST_REACHES` hold one, or a path has gaps.
    """
    seen = [each for each in recordings if has_palm(each)]
    ways = [(each, wrist_path(each)[0]) for each in seen]
    reaches = [(each, way) for each, way in ways if not _is_short(way)]
    if len(reaches) < LEAST_REACHES:
        raise InputError(
            f"{len(reaches)} recordings in which the palm's pose was seen to move by more than "
            f"{1000 * LEAST_WAY:g} mm, fewer than {LEAST_REACHES}; give some with the channels "
            "palm_x_m to palm_z_m and palm_qw to palm_qz"
        )
    return learn_transport(
        [way * MIRROR if each.hand.side == "left" else way for each, way in reaches],
        [each.time for each, _ in reaches],
        seed=seed,
        progress=progress,
    )


def _is_short(way: np.ndarray) -> bool:
    return bool(np.linalg.norm(way[-1] - way[0]) < LEAST_WAY)
