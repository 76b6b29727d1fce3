"""How people's movements differ from trial to trial: where they begin and how long they take."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from handsim.joints import JOINT_INDEX, JOINTS, clip_to_range
from handsim.simulation.closings import REST

Array = npt.NDArray[np.float64]

SPREAD_REST_DEG = {"curl": 6.0, "thumb_rotation": 7.0, "thumb_abduction": 4.0, "wrist_flexion": 5.0}
"""Standard deviations of the relaxed hand; ``curl`` is that of all MCP and PIP flexions together,
as fingers at rest curl together. Choices of the order of what hands at rest show."""
REACH_RANGE = (1.0, 1.45)
"""Durations of reaches to graspable objects [s] (Jeannerod 1984: about 0.8 to 1.2 s until contact;
here closing is included)."""
OPENED_RANGE = (0.56, 0.68)
"""Fraction of the reach at which people's hands are most open (Jeannerod 1984: two thirds)."""


@dataclass(frozen=True)
class Manner:
    """What one trial has of its own.

    Attributes
    ----------
    rest : (22,) [rad]
        Posture before the reach.
    reach
        Duration of the reach [s].
    opened
        Fraction of the reach at which the hand is most open.
    """

    rest: Array
    reach: float = 1.2
    opened: float = 0.62


USUAL = Manner(REST)
"""The manner of nominal runs."""


def manner_of(seed: int) -> Manner:
    """Return the manner of a trial; the same seed gives the same."""
    generator = np.random.default_rng([seed, 22])
    off = {name: generator.normal(0.0, np.deg2rad(s)) for name, s in SPREAD_REST_DEG.items()}
    rest = REST.copy()
    for index, joint in enumerate(JOINTS):
        curls = joint.finger not in (None, "thumb") and joint.name.endswith(("mcp", "pip"))
        rest[index] += off["curl"] if curls else 0.0
    for name in ("thumb_rotation", "thumb_abduction", "wrist_flexion"):
        rest[JOINT_INDEX[name]] += off[name]
    reach, opened = generator.uniform(*REACH_RANGE), generator.uniform(*OPENED_RANGE)
    return Manner(clip_to_range(rest), round(float(reach), 2), float(opened))
