"""Samples of the direction learner: points and the unit vectors that the flow should have there.

There are three kinds: tangents of the recordings; a corridor of displaced points with vectors that
lead back to the recording; and points of the roll-outs of the fit so far, with vectors towards
the recording a little ahead.
"""

from collections.abc import Sequence
from math import ceil

import numpy as np

from handsim.learning.fit.field_samples import FieldSamples, random_normals
from handsim.navigation.flow import FlowPath
from handsim.navigation.paths import at_arc_length
from handsim.reproducible import norms, units
from handsim.types import Array, Index

_N_PER_PATH = 30  # samples along a recording, equally spaced in arc length
_MOST_SAMPLED = 6000  # of those in all: of many recordings every few are taken
_LAST_FRACTION = 0.97  # of the arc length: beyond, the direction to the destination is noise
_CORRIDOR = np.deg2rad(15.0)  # farthest displaced sample
_PULL = 1.5 / np.deg2rad(100.0)  # back to the recording, per displacement
_N_PER_SAMPLE = 1  # displaced samples for each sample
_AHEAD = 0.07  # fraction of the recording between a point of a roll-out and where it is led


def recorded_samples(paths: Sequence[Array], rng: np.random.Generator) -> FieldSamples:
    """Return the tangents of the recordings and a corridor of points that lead back to them."""
    fractions = np.linspace(0.0, 1.0, _N_PER_PATH)
    parts: list[FieldSamples] = []
    for i, path in enumerate(paths):
        use = _sampled(i, paths)
        even = at_arc_length(path, fractions)
        tangent = units(np.gradient(even, axis=0))[use]
        even = even[use]
        on_path = FieldSamples(even, tangent, np.broadcast_to(path[-1], even.shape))
        parts.append(on_path)
        if path.shape[1] == 1:  # on a line there is no side to be displaced to
            continue
        for _ in range(_N_PER_SAMPLE):
            aside = random_normals(tangent, rng) * _CORRIDOR * rng.random((len(even), 1))
            parts.append(on_path.displaced(tangent, aside, _PULL))
    return FieldSamples.together(parts)


def rolled_out_samples(rollouts: Sequence[FlowPath], paths: Sequence[Array]) -> FieldSamples:
    """Return points of roll-outs, with vectors towards the recording 7 % of its length ahead."""
    even = np.linspace(0.0, 1.0, _N_PER_PATH)
    parts: list[FieldSamples] = []
    for i, (rollout, path) in enumerate(zip(rollouts, paths, strict=True)):
        fractions = even[_sampled(i, paths)]
        here = at_arc_length(rollout.points, fractions)
        ahead = at_arc_length(path, np.minimum(fractions + _AHEAD, 1.0)) - here
        # Nearer than this the direction ahead is noise.
        use = norms(ahead)[:, 0] > np.deg2rad(3.0)
        goals = np.broadcast_to(path[-1], here[use].shape)
        parts.append(FieldSamples(here[use], units(ahead[use]), goals))
    return FieldSamples.together(parts)


def _sampled(i: int, paths: Sequence[Array]) -> Index:
    """Return which of the 30 points along recording ``i`` are samples.

    Of many recordings only every second, third ... point is taken, other ones of each recording:
    the cost of a fit stays bounded, and the coefficients are determined as well.
    """
    n = paths[0].shape[1]
    most = min(_MOST_SAMPLED, 6_000_000 // (n * 4**n))  # fewer where each touches more coefficients
    every = ceil(len(paths) * _N_PER_PATH / most)
    usable = np.flatnonzero(np.linspace(0.0, 1.0, _N_PER_PATH) <= _LAST_FRACTION)
    return usable[(usable + i) % every == 0]
