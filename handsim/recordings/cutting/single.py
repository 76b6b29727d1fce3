"""Recordings that hold one reach and nothing else, cut before by others."""

import numpy as np

from handsim.recordings.cutting.motion import Motion
from handsim.recordings.cutting.reach import CutOptions
from handsim.recordings.cutting.stops import NOISE_FACTOR, Course
from handsim.recordings.phases import RATE

CUT_ALREADY_S = 0.3
"""A recording that stands still no longer than this at its ends has been cut before [s]."""
ENDS_AWAY = 0.5
"""and it ends no nearer than this share of its largest distance from its start."""


def is_single_reach(motion: Motion, course: Course, options: CutOptions) -> bool:
    """Whether a recording holds one reach and next to nothing before and after it."""
    longest = max((stop.duration for stop in course.stops[1:-1]), default=0.0)
    way = np.linalg.norm(motion.place - motion.place[0], axis=1)
    # Hands creep at the ends of what others have cut, at more than half the speed of a stop.
    share = options.rest_share(palm=motion.palm)
    creep = max(0.5 * share * course.peak, NOISE_FACTOR * motion.floor)
    moving = np.flatnonzero(motion.speed > creep)
    still = max(moving[0], len(motion.speed) - 1 - moving[-1]) / RATE
    return (
        still <= CUT_ALREADY_S
        and longest < options.longest_pause_s
        and float(way[-1]) >= ENDS_AWAY * float(way.max())
    )
