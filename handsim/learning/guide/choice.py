"""Whether progress pays as a coordinate of the field, for the recordings of a person.

With it a movement can go back over the way that it came. Without it there is less to be learned:
where the hand is along the chord tells what comes next, and a detour that is made at times does not
shift what comes after it, one recording against another. Which is nearer to a person is found by
leaving out each recording: its path is predicted from all others, both ways.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from handsim.learning.demonstration import Demonstration
from handsim.learning.guide.predictor import GuideSettings, PathPredictor
from handsim.navigation.paths import at_arc_length
from handsim.reproducible import dots, mean, total
from handsim.types import Array

_MOST = 200  # recordings left out; of more, every second, third ... is


@dataclass(frozen=True)
class LeftOut:
    """Errors of guides to recordings left out, object known, over those of straight lines.

    Attributes
    ----------
    with_progress, without_progress
        Ratio of the mean path errors.
    """

    with_progress: float
    without_progress: float

    @property
    def progress_pays(self) -> bool:
        """Whether the guide is at least as near with progress as a coordinate."""
        return self.with_progress <= self.without_progress

    @classmethod
    def of(cls, demonstrations: Sequence[Demonstration], settings: GuideSettings) -> "LeftOut":
        """Leave out each demonstration in turn; they must hold their paths."""
        asked = demonstrations[:: -(-len(demonstrations) // _MOST)]
        with_progress, without = (
            PathPredictor.of(asked, replace(settings, progress=by_progress))
            for by_progress in (True, False)
        )
        paths = with_progress.paths
        scale = max(_total_error(paths[:, [0, -1]], paths), np.finfo(float).tiny)
        return cls(
            *(_total_error(each.left_out(), paths) / scale for each in (with_progress, without))
        )


def asked_of_progress(guide: GuideSettings, left_out: LeftOut | None) -> bool | None:
    """Return what was asked of progress when a controller was learned; None if it was chosen.

    Controllers of earlier versions have progress, as if asked for.
    """
    chosen = left_out is not None and guide.progress == left_out.progress_pays
    return None if chosen else guide.progress


def _total_error(found: Array, paths: Array) -> float:
    """Return the sum of path errors, as of `navigation.paths.path_error` with whole recordings.

    The paths of demonstrations are at equal steps of the recordings' length already.
    """
    fractions = np.linspace(0.0, 1.0, paths.shape[1])
    apart = np.array([at_arc_length(path, fractions) for path in found]) - paths
    return float(total(np.sqrt(mean(dots(apart, apart), -1))))
