"""In what unit a mesh file is, by the size of what hands grasp."""

from dataclasses import dataclass

import numpy as np

UNITS = {
    "m": (1.0, 1.0),
    "mm": (0.001, 4.0),
    "cm": (0.01, 0.4),
    "inch": (0.0254, 0.6),
    "dm": (0.1, 0.15),
}
"""Metres in each, and how often files are in it, roughly: CAD writes mm, robotics m."""
USUAL_SIZE, SIZE_SPREAD = 0.12, 0.70
"""Longest side of things grasped by one hand [m], and the spread of its logarithm, chosen: two
thirds lie between 60 and 240 mm, from a cube to a bottle."""
USUAL_DENSITY, DENSITY_SPREAD = 900.0, 1.2
"""Mass over volume of a mesh [kg/m^3]; hollow things are often modelled as solid."""


@dataclass(frozen=True)
class UnitGuess:
    """A unit, and what speaks against it.

    Attributes
    ----------
    name, scale
        The unit, and metres in it.
    other
        The next likely.
    share
        How likely it is, 0 to 1.
    """

    name: str
    scale: float
    other: str
    share: float


def guess_unit(longest: float, volume: float, mass: float | None = None) -> UnitGuess:
    """Guess the unit of a file from the longest side and the volume in it.

    Parameters
    ----------
    longest, volume
        In the file's unit, and that cubed.
    mass
        [kg], if known; the density then counts.
    """
    chances: dict[str, float] = {}
    for name, (metres, often) in UNITS.items():
        off = np.log(longest * metres / USUAL_SIZE) / SIZE_SPREAD
        chance = np.log(often) - off**2 / 2
        if mass is not None:
            density = mass / (volume * metres**3)
            chance -= (np.log(density / USUAL_DENSITY) / DENSITY_SPREAD) ** 2 / 2
        chances[name] = float(chance)
    first, second = sorted(chances, key=lambda name: -chances[name])[:2]
    total = sum(np.exp(each - chances[first]) for each in chances.values())
    return UnitGuess(first, UNITS[first][0], second, float(1 / total))
