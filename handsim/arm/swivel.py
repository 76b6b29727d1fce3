"""Where a person puts the elbow: the swivel by where the hand is.

Two laws of the literature, and one fitted to a recorded person:

- the constant `USUAL`;
- `towards_mouth`: shoulder, elbow, wrist and mouth lie in one plane, so that the hand could be
  brought to the mouth by the least turn of the arm (Kim, Miller, Rosen et al. 2012, IEEE Trans.
  Biomed. Eng. 59(9):2539-2547);
- `fit_swivel`: linear in where the wrist is, drawn to a constant.

Places are seen from the shoulder, of a right arm, as in `handsim.arm.chain`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.arm.arm_geometry import SHOULDER_OF_STATURE, ArmGeometry
from handsim.arm.chain import swivel_of
from handsim.types import Array

MOUTH_OF_STATURE = (0.06, SHOULDER_OF_STATURE, 0.085)
"""The mouth from the right shoulder: ahead, to the left, up; / stature. Shoulder joint at 0.80 of
stature standing, mouth at 0.89 (Drillis & Contini: chin 0.870)."""
USUAL = float(np.deg2rad(20.0))
"""Swivel without any other reason [rad]: an upper arm lifted about as far to the side as ahead, as
at a desk. Low confidence: one recorded person has -12 to 24 deg by how the joint of the shoulder is
found from its marker (`tests/benchmarks/reach.py`)."""
SPREAD = float(np.deg2rad(15.0))
"""How far people are from any law [rad]: 25 deg over targets at one height (Kang, Shimansky & He
2002, Proc. 24th IEEE EMBS)."""
_RIDGE = 5.0  # reaches' worth of constancy in a fit


@dataclass(frozen=True)
class SwivelLaw:
    """Swivel by the place of the wrist: a constant, and what each part of it adds.

    Attributes
    ----------
    constant
        [rad]
    slope : 3 numbers [rad]
        By the wrist's place in parts of the arm's reach, from ``middle``: ahead, left, up.
    middle : 3 numbers
    spread
        Deviation from the law that costs as much as anything else that costs 1 [rad].
    """

    constant: float = USUAL
    slope: tuple[float, float, float] = (0.0, 0.0, 0.0)
    middle: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spread: float = SPREAD

    def swivel(self, wrist: Array, geometry: ArmGeometry) -> Array:
        """Return the swivel for places of the wrist (..., 3) [m], (...) [rad]."""
        return self.constant + (wrist / geometry.reach - np.array(self.middle)) @ self.slope


def fit_swivel(wrists: Sequence[Array], swivels: Sequence[Array]) -> SwivelLaw:
    """Return the law of a person's reaches.

    Parameters
    ----------
    wrists
        (n_i, 3), one a reach, in parts of the arm's reach.
    swivels
        (n_i,) [rad]
    """
    weights = np.concatenate([np.full(len(each), 1.0 / len(each)) for each in swivels])
    places, angles = np.vstack(wrists), np.concatenate(swivels)
    middle, mean = np.average(places, axis=0, weights=weights), np.average(angles, weights=weights)
    apart = places - middle
    scale = float(np.average((apart**2).sum(axis=1), weights=weights))
    normal = (apart * weights[:, None]).T @ apart + _RIDGE * scale / 3 * np.eye(3)
    slope = np.linalg.solve(normal, (apart * weights[:, None]).T @ (angles - mean))
    x, y, z = (float(value) for value in slope)
    a, b, c = (float(value) for value in middle)
    return SwivelLaw(float(mean), (x, y, z), (a, b, c))


def towards_mouth(wrist: Array, stature: float) -> Array:
    """Return the swivel at which shoulder, elbow, wrist and mouth lie in one plane, (...) [rad].

    Parameters
    ----------
    wrist : (..., 3) [m]
    stature
        [m]
    """
    mouth = np.broadcast_to(stature * np.array(MOUTH_OF_STATURE), wrist.shape)
    return swivel_of(-mouth, wrist)
