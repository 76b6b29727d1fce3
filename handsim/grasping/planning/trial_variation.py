"""How a person's reach differs from trial to trial: its first posture and its duration."""

from dataclasses import dataclass

import numpy as np

from handsim.grasping.planning.preshapes import REST
from handsim.joints import JOINT_INDEX, JOINTS, clip_to_range
from handsim.types import Array

SPREAD_REST_DEG = {"curl": 6.0, "thumb_rotation": 7.0, "thumb_abduction": 4.0, "wrist_flexion": 5.0}
"""Standard deviations of the relaxed posture [deg].

``curl`` moves all MCP and PIP flexions together, as fingers at rest curl together. The values are
chosen, of the order of what hands at rest show."""
REACH_RANGE = (1.0, 1.45)
"""Durations of reaches to graspable objects [s] (Jeannerod 1984: about 0.8 to 1.2 s until contact;
here closing is included)."""
PEAK_APERTURE_RANGE = (0.56, 0.68)
"""Fraction of the reach at which people's hands are most open (Jeannerod 1984: two thirds)."""


@dataclass(frozen=True)
class TrialVariation:
    """Posture and timing of one trial.

    Attributes
    ----------
    rest : (22,) [rad]
        Posture before the reach.
    reach
        Duration of the reach [s].
    peak_aperture_at
        Fraction of the reach at which the hand is most open.
    """

    rest: Array
    reach: float = 1.2
    peak_aperture_at: float = 0.62


USUAL = TrialVariation(REST)
"""The variation of nominal runs."""


def trial_variation(seed: int) -> TrialVariation:
    """Return the variation of a trial; the same seed gives the same."""
    generator = np.random.default_rng([seed, 22])
    off: dict[str, float] = {
        name: generator.normal(0.0, np.deg2rad(s)) for name, s in SPREAD_REST_DEG.items()
    }
    rest = REST.copy()
    for index, joint in enumerate(JOINTS):
        curls = joint.finger not in (None, "thumb") and joint.name.endswith(("mcp", "pip"))
        rest[index] += off["curl"] if curls else 0.0
    for name in ("thumb_rotation", "thumb_abduction", "wrist_flexion"):
        rest[JOINT_INDEX[name]] += off[name]
    reach, peak = generator.uniform(*REACH_RANGE), generator.uniform(*PEAK_APERTURE_RANGE)
    return TrialVariation(clip_to_range(rest), round(float(reach), 2), float(peak))
