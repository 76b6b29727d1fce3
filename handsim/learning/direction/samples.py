"""Points, and the directions in which a flow should point there.

Samples of the direction learner are the tangents of the recordings; a corridor of displaced points
that lead back to them, without which paths would not attract; and points of the roll-outs of
the fit so far, led to the recording a little ahead.
"""

from dataclasses import dataclass
from math import ceil

import numpy as np
import numpy.typing as npt

from handsim.navigation.flow import FlowPath
from handsim.navigation.paths import at_arc_length
from handsim.reproducible import dots, norms, units
from handsim.types import Array

_N_PER_PATH = 30  # samples along a recording, equally spaced in arc length
_MOST_SAMPLED = 6000  # of those in all: of many recordings every few are taken
_LAST_FRACTION = 0.97  # of the arc length: beyond, the direction to the destination is noise
_CORRIDOR = np.deg2rad(15.0)  # farthest displaced sample
_RETURN = 1.5 / np.deg2rad(100.0)  # pull back to the recording, per displacement
_N_PER_SAMPLE = 1  # displaced samples for each sample
_AHEAD = 0.07  # fraction of the recording by which a roll-out is led ahead


@dataclass(frozen=True)
class Samples:
    """Points and the directions in which the flow should point there.

    Attributes
    ----------
    points, wanted, goals : (N, n)
        Points [rad], unit vectors, destinations [rad].
    """

    points: Array
    wanted: Array
    goals: Array

    def __add__(self, other: "Samples") -> "Samples":
        """Return both sets of samples together."""
        return Samples(
            np.vstack([self.points, other.points]),
            np.vstack([self.wanted, other.wanted]),
            np.vstack([self.goals, other.goals]),
        )


def recorded_samples(paths: list[Array], rng: np.random.Generator) -> Samples:
    """Return the tangents of the recordings and a corridor of points that lead back to them."""
    fractions = np.linspace(0.0, 1.0, _N_PER_PATH)
    points, wanted, goals = [], [], []
    for i, path in enumerate(paths):
        use = _sampled(i, paths)
        even = at_arc_length(path, fractions)
        tangent = units(np.gradient(even, axis=0))[use]
        even = even[use]
        goal = np.broadcast_to(path[-1], even.shape)
        points.append(even)
        wanted.append(tangent)
        goals.append(goal)
        if path.shape[1] == 1:  # on a line there is no side to be displaced to
            continue
        for _ in range(_N_PER_SAMPLE):
            aside = random_normals(tangent, rng) * _CORRIDOR * rng.random((len(even), 1))
            points.append(even + aside)
            wanted.append(units(tangent - _RETURN * aside))
            goals.append(goal)
    return Samples(np.vstack(points), np.vstack(wanted), np.vstack(goals))


def rolled_out_samples(rollouts: list[FlowPath], paths: list[Array]) -> Samples:
    """Return points of roll-outs, led to the recording a little (`_AHEAD`) farther on."""
    even = np.linspace(0.0, 1.0, _N_PER_PATH)
    points, wanted, goals = [], [], []
    for i, (rollout, path) in enumerate(zip(rollouts, paths, strict=True)):
        fractions = even[_sampled(i, paths)]
        here = at_arc_length(rollout.points, fractions)
        ahead = at_arc_length(path, np.minimum(fractions + _AHEAD, 1.0)) - here
        # Nearer than this the direction ahead is noise.
        use = norms(ahead)[:, 0] > np.deg2rad(3.0)
        points.append(here[use])
        wanted.append(units(ahead[use]))
        goals.append(np.broadcast_to(path[-1], here[use].shape))
    return Samples(np.vstack(points), np.vstack(wanted), np.vstack(goals))


def random_normals(tangents: Array, rng: np.random.Generator) -> Array:
    """Return unit vectors (N, n), each normal to a unit vector (N, n) and random otherwise."""
    # Rounded: in the tails of the distribution the last bit is the processor's.
    normal = np.round(rng.normal(size=tangents.shape), 12)
    return units(normal - dots(normal, tangents)[:, None] * tangents)


def _sampled(i: int, paths: list[Array]) -> npt.NDArray[np.int64]:
    """Which of the points along recording ``i`` are samples.

    Of many recordings every few points, other ones of each: what a fit costs stays bounded
    however many there are, and the coefficients are as well determined.
    """
    n = paths[0].shape[1]
    most = min(_MOST_SAMPLED, 6_000_000 // (n * 4**n))  # fewer where each touches more coefficients
    every = ceil(len(paths) * _N_PER_PATH / most)
    usable = np.flatnonzero(np.linspace(0.0, 1.0, _N_PER_PATH) <= _LAST_FRACTION)
    return usable[(usable + i) % every == 0]
