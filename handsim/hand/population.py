"""How large people's hands are: percentiles and joint sampling, ANSUR II (2012), US Army."""

from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

import numpy as np

from handsim.errors import InputError, UnknownNameError
from handsim.hand.anthropometry import HAND_BREADTH_RANGE, HAND_LENGTH_RANGE
from handsim.types import MEDIAN_HAND, HandSize

Sex = Literal["woman", "man"]


@dataclass(frozen=True)
class Population:
    """Joint normal distribution of the hand sizes of one sex.

    Attributes
    ----------
    hand_length, hand_breadth
        Mean and standard deviation [m].
    correlation
        Of the two, -1 to 1.
    """

    hand_length: tuple[float, float]
    hand_breadth: tuple[float, float]
    correlation: float


POPULATIONS: MappingProxyType[Sex, Population] = MappingProxyType(
    {
        "woman": Population((0.1811, 0.0101), (0.0782, 0.0038), 0.57),
        "man": Population((0.1933, 0.0099), (0.0883, 0.0044), 0.58),
    }
)

PRESETS: MappingProxyType[str, HandSize] = MappingProxyType(
    {
        "woman-5": HandSize(0.165, 0.072),
        "woman-50": HandSize(0.1811, 0.0782),
        "woman-95": HandSize(0.199, 0.085),
        "man-5": HandSize(0.177, 0.081),
        "man-50": MEDIAN_HAND,
        "man-95": HandSize(0.210, 0.096),
    }
)
"""Right hands with length and breadth both at the 5th, 50th or 95th percentile.

Fewer than 5 % of people are as small, or as large, in both at once.
"""


def preset(name: str) -> HandSize:
    """Return the right hand of a preset, ``woman-5`` to ``man-95``.

    Raises
    ------
    UnknownNameError
        If there is no such preset.
    """
    if name not in PRESETS:
        raise UnknownNameError("hand size", name, tuple(PRESETS))
    return PRESETS[name]


def sample_sizes(n: int, sex: Sex, seed: int) -> tuple[HandSize, ...]:
    """Draw right hands of a population, length and breadth jointly.

    Returns
    -------
    n sizes
        Clipped to what can be built (six standard deviations away).

    Raises
    ------
    UnknownNameError
        If ``sex`` is neither ``woman`` nor ``man``.
    InputError
        If ``n`` is negative.
    """
    if sex not in POPULATIONS:
        raise UnknownNameError("population", sex, tuple(POPULATIONS))
    if n < 0:
        raise InputError(f"cannot draw {n} hands; ask for 0 or more")
    people = POPULATIONS[sex]
    means, deviations = np.array([people.hand_length, people.hand_breadth]).T
    correlation = np.array([[1.0, people.correlation], [people.correlation, 1.0]])
    covariance = correlation * np.outer(deviations, deviations)
    sizes = np.random.default_rng(seed).multivariate_normal(means, covariance, size=n)
    clipped = np.clip(sizes, *np.array([HAND_LENGTH_RANGE, HAND_BREADTH_RANGE]).T)
    return tuple(HandSize(*size) for size in clipped.tolist())
