"""Which map a signal has, found from the recordings that hold it.

Whether it rises or falls is what explains more of progress in recordings left out: monotone
regression of progress on the signal, pooled over the others. A falling signal counts as it is, or
as a share of what it was at the start, whichever drives recordings left out nearer to what the
person did.
"""

from collections.abc import Sequence

import numpy as np

from handsim.driving.driver import DriverRule, SignalDriver
from handsim.driving.monotone import isotonic_fit
from handsim.driving.signal_map import SignalMap, fitted_map, levels_of, times_at_progress
from handsim.errors import InputError, UnknownNameError
from handsim.learning.demonstration import SIGNAL_PROGRESS, Demonstration
from handsim.types import Array, Index

LEAST_EXPLAINED = 0.1
"""Share of the variance of progress that a signal has to explain in recordings left out."""
_MOST_FOLDS = 10
_MOST_DRIVEN = 60  # recordings that are driven to compare two maps


def calibrate_signal(demonstrations: Sequence[Demonstration], channel: str) -> SignalMap:
    """Find what a signal says about progress.

    Parameters
    ----------
    demonstrations
        Those that hold the channel are used.
    channel

    Raises
    ------
    UnknownNameError
        If none holds the channel.
    InputError
        If the signal tells nothing about progress.
    """
    used = [d for d in demonstrations if channel in d.signals]
    if not used:
        raise _no_channel(channel, demonstrations)
    ways = [(False, False), (True, False)]
    if all(d.signals[channel][0] > 0 for d in used):
        ways.append((False, True))
    explained = [_explained(levels_of(used, channel, rising=r, relative=s)) for r, s in ways]
    best = int(np.argmax(explained))
    if explained[best] < LEAST_EXPLAINED:
        raise InputError(
            f"channel {channel} says too little about progress: {100 * explained[best]:.0f} % of "
            f"its variance in {len(used)} recordings, at least {100 * LEAST_EXPLAINED:.0f} % are "
            "needed; name another with --channel, or give its values at rest and at the grasp "
            "with --range"
        )
    if best != 1 and len(ways) == 3 and min(explained[0], explained[2]) >= LEAST_EXPLAINED:
        missed = [_missed(used, channel, relative=relative) for relative in (False, True)]
        best = 2 if missed[1] < missed[0] else 0
    rising, relative = ways[best]
    return fitted_map(used, channel, rising=rising, relative=relative, explained=explained[best])


def _folds(n: int) -> Index:
    """Return the fold of each recording; they alternate, so that objects mix."""
    return np.arange(n) % min(n, _MOST_FOLDS)


def _explained(levels: Array) -> float:
    """Return the share of the variance of progress that levels explain in recordings left out.

    Of a single recording, in itself.
    """
    n = len(levels)
    fold = _folds(n)
    missed = 0.0
    for left_out in range(int(fold.max()) + 1):
        known = levels[fold != left_out] if n > 1 else levels
        told = levels[fold == left_out]
        knots, values = isotonic_fit(known.ravel(), np.tile(SIGNAL_PROGRESS, len(known)))
        missed += float(np.sum((np.interp(told, knots, values) - SIGNAL_PROGRESS) ** 2))
    return 1.0 - missed / (n * len(SIGNAL_PROGRESS) * float(np.var(SIGNAL_PROGRESS)))


def _missed(demonstrations: Sequence[Demonstration], channel: str, *, relative: bool) -> float:
    """Return the mean rms over time of progress driven in recordings left out."""
    some = demonstrations[:_MOST_DRIVEN]
    fold = _folds(len(some))
    errors: list[float] = []
    for left_out in range(int(fold.max()) + 1):
        others = [d for d, f in zip(some, fold, strict=True) if f != left_out] or list(some)
        rule = DriverRule(fitted_map(others, channel, rising=False, relative=relative))
        told = (d for d, f in zip(some, fold, strict=True) if f == left_out)
        errors += [_driven_error(rule, d, d.signals[channel]) for d in told]
    return float(np.mean(errors))


def _driven_error(rule: DriverRule, demonstration: Demonstration, signal: Array) -> float:
    """Return the rms over time of the progress that a recorded signal drives."""
    steps = np.diff(times_at_progress(demonstration), prepend=0.0)
    driver = SignalDriver(rule)
    driven = np.array([driver.step(value, dt) for value, dt in zip(signal, steps, strict=True)])
    squared = (driven - SIGNAL_PROGRESS) ** 2
    return float(np.sqrt(np.sum(steps * squared) / max(float(np.sum(steps)), np.finfo(float).tiny)))


def _no_channel(channel: str, demonstrations: Sequence[Demonstration]) -> InputError:
    known = tuple(dict.fromkeys(name for d in demonstrations for name in d.signals))
    if known:
        return UnknownNameError("channel of the recordings", channel, known)
    return InputError(
        f"channel {channel}: the recordings that the controller was learned from hold no channels; "
        "give the values at rest and at the grasp with --range, or learn from recordings with it"
    )
