"""Run rivals over sets of movements: in training, and on trials left out."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import process_time

import numpy as np
from threadpoolctl import threadpool_limits

from handsim.navigation.workspace import lay_basis
from handsim.types import Array

from .data import TrialSet
from .protocol import Movement, Query, Rival
from .scoring import Score, arrives, score

N_RANDOM = 200
"""Random starts for each set."""


@dataclass(frozen=True)
class Fold:
    """Trials that are learned from and trials that are scored, by their number."""

    learned: tuple[int, ...]
    scored: tuple[int, ...]


@dataclass(frozen=True)
class Outcome:
    """Scores of one rival on one set in one setting.

    Attributes
    ----------
    scores
        One a trial.
    learning, query : [s]
        CPU time of one fit and of one answer, means.
    """

    scores: tuple[Score, ...]
    learning: float
    query: float

    @property
    def ratio(self) -> float:
        """Mean path error over that of straight segments."""
        return sum(s.error for s in self.scores) / sum(s.straight for s in self.scores)

    @property
    def arrived(self) -> int:
        """How many arrived."""
        return sum(s.arrived for s in self.scores)

    @property
    def proven(self) -> int:
        """How many were proven to."""
        return sum(s.proven for s in self.scores)

    def mean(self, name: str) -> float:
        """Return the mean of a score over the trials that have it, NaN where none has."""
        values = np.array([getattr(each, name) for each in self.scores])
        known = values[np.isfinite(values)]
        return float(known.mean()) if known.size else float("nan")


SETTINGS = ("training", "left out", "folds")
"""All trials learned and scored; every trial left out by itself; even folds left out."""


@dataclass(frozen=True)
class Measured:
    """A rival on one set.

    Attributes
    ----------
    argument
        Why its movements arrive; empty where nothing is known.
    outcomes
        By setting.
    random
        Arrivals from random starts.
    """

    argument: str
    outcomes: Mapping[str, Outcome]
    random: int


def in_training(n: int) -> list[Fold]:
    """Learn from all of n trials and score all."""
    return [Fold(tuple(range(n)), tuple(range(n)))]


def left_out(n: int, n_folds: int) -> list[Fold]:
    """Leave every ``n_folds``-th trial out, at most each trial by itself."""
    folds = min(n, n_folds)
    return [
        Fold(tuple(i for i in range(n) if i % folds != first), tuple(range(first, n, folds)))
        for first in range(folds)
    ]


def measure(make: Callable[[], Rival], trials: TrialSet, n_folds: int) -> Measured:
    """Try a rival on a set in all settings."""
    n = len(trials.trials)
    with threadpool_limits(1):  # threads that wait for each other count as CPU time
        training = run(make, trials, in_training(n))
        each = run(make, trials, left_out(n, n))
        folds = run(make, trials, left_out(n, n_folds)) if n_folds < n else each
        arrivals = random_arrivals(make, trials)
    outcomes: dict[str, Outcome] = dict(zip(SETTINGS, (training, each, folds), strict=True))
    return Measured(make().argument, outcomes, arrivals)


def run(make: Callable[[], Rival], trials: TrialSet, folds: Sequence[Fold]) -> Outcome:
    """Fit a rival in each fold, in the coordinates of what is learned from, and score it."""
    scores: dict[int, Score] = {}
    learning: list[float] = []
    answering: list[float] = []
    for fold in folds:
        space = trials.space(fold.learned)
        began = process_time()
        rival = make().fit([space.movement(trials.trials[i]) for i in fold.learned])
        learning.append(process_time() - began + rival.saved)
        for i in fold.scored:
            movement = space.movement(trials.trials[i])
            query = _query(movement)
            began = process_time()
            motion = rival.predict(query)
            answering.append(process_time() - began)
            proven = rival.proves(query)
            scores[i] = score(motion, trials.trials[i], movement, space, trials.per_rad, proven)
    every = tuple(scores[i] for i in sorted(scores))
    return Outcome(every, float(np.mean(learning)), float(np.mean(answering)))


def random_arrivals(make: Callable[[], Rival], trials: TrialSet, n: int = N_RANDOM) -> int:
    """Learn from all trials, and count arrivals from random starts in the workspace.

    Starts are uniform in the box in which navigation functions are learned, which reaches beyond
    the recordings; destinations are recorded ones, each with its object.
    """
    every = range(len(trials.trials))
    space = trials.space(every)
    movements = [space.movement(trial) for trial in trials.trials]
    rival = make().fit(movements)
    basis, _ = lay_basis([each.path for each in movements])
    rng = np.random.default_rng(0)
    starts = rng.uniform(basis.lower, basis.upper, (n, len(basis.lower)))
    chosen = rng.integers(len(movements), size=n)
    queries = [_query(movements[i], start) for i, start in zip(chosen, starts, strict=True)]
    motions = rival.predict_all(queries)
    return sum(arrives(m, q.goal) for m, q in zip(motions, queries, strict=True))


def _query(movement: Movement, start: Array | None = None) -> Query:
    first = movement.path[0] if start is None else start
    return Query(first, movement.path[-1], movement.object, movement.duration)
