"""Whether recordings can be what they say: angles of a hand in degrees, times in s, one reach.

Numbers that no hand makes are stopped before anything is learned from them. Each anomaly names the
recording, the joint, the figure, the limit and the remedy. An *error* stops the work unless its
kind is accepted; a *warning* is said aloud. Limits were set on 80 glove recordings of four people
and the 24 built-in ones, none of which shows an error, and on the same with each fault planted.
"""

from collections.abc import Collection, Iterable
from dataclasses import asdict, dataclass
from typing import Literal, get_args

import numpy as np

from handsim.errors import InputError, UnknownNameError
from handsim.recordings import _faults
from handsim.recordings._faults import Fault
from handsim.recordings.recording import RecordingSet
from handsim.recordings.sides import MIRRORED_JOINTS, looks_mirrored
from handsim.wording import number_of

Kind = Literal[
    "radians", "small", "milliseconds", "duration", "counts", "range", "sign", "rest-to-rest",
    "wrap", "jump", "constant", "stuck", "rate", "gap", "side",
]  # fmt: skip
KINDS: tuple[Kind, ...] = get_args(Kind)
"""Kinds of anomalies, by which they are accepted."""
_EXPLAIN_RANGES = frozenset({"counts", "sign", "range"})
"""Errors beside which the warnings of single joints would say nothing more."""


@dataclass(frozen=True)
class Anomaly:
    """Something about a recording that cannot be, or is unlikely to be, right.

    Attributes
    ----------
    kind
        One of `KINDS`.
    severity
        ``error`` or ``warning``.
    recording, joint
        Where; no joint where it is about the whole hand or the time.
    value, limit
        The figure and the limit that it breaks, in the unit that the message names.
    message
        What was found, in words, with the remedy.
    """

    kind: Kind
    severity: Literal["error", "warning"]
    recording: str
    joint: str | None
    value: float
    limit: float
    message: str

    def __str__(self) -> str:
        """Return recording, joint and message in one line."""
        where = f"recording '{self.recording}'" + (f", {self.joint}" if self.joint else "")
        return f"{where}: {self.message}"


class ImplausibleError(InputError):
    """Recordings cannot be what they say; `anomalies` holds what was found."""

    def __init__(self, anomalies: tuple[Anomaly, ...]) -> None:
        first, kinds = anomalies[0], {each.kind for each in anomalies}
        others = len({each.recording for each in anomalies}) - 1
        more = f" (and in {number_of(others, 'further recording')})" if others else ""
        accepts = " ".join(f"--accept {kind}" for kind in sorted(kinds))
        super().__init__(f"{first}{more}; if it is right, use {accepts}")
        self.anomalies = anomalies

    def __reduce__(self) -> tuple[type, tuple[tuple[Anomaly, ...]]]:
        """Let it come through from another process."""
        return type(self), (self.anomalies,)


class PlausibilityWarning(UserWarning):
    """Something about recordings is unlikely to be right."""


def anomalies(recordings: RecordingSet) -> tuple[Anomaly, ...]:
    """Return what is wrong or unlikely with recordings, in their order, errors first in each."""
    found: list[Anomaly] = []
    of_hands = _of_hands(recordings)
    constant_everywhere = _faults.constant_joints(recordings)
    for recording in recordings:
        faults = [
            *_faults.of_time(recording),
            *_faults.of_movement(recording),
            *of_hands[recording.name],
            *_faults.of_angles(recording),
            *_faults.of_sensors(recording, constant_everywhere),
        ]
        kinds = {fault.kind for fault in faults if fault.severity == "error"}
        own = [
            Anomaly(recording=recording.name, **asdict(fault))
            for fault in faults
            if fault.severity == "error" or not kinds & _EXPLAIN_RANGES or fault.kind != "range"
        ]
        found += sorted(own, key=lambda each: each.severity != "error")
    return tuple(found)


def check_plausible(recordings: RecordingSet, accept: Collection[str] = ()) -> tuple[Anomaly, ...]:
    """Stop at what cannot be right.

    Parameters
    ----------
    recordings
    accept
        Kinds of anomalies that are right all the same.

    Returns
    -------
    tuple
        The warnings that are left.

    Raises
    ------
    ImplausibleError
        If there are errors of a kind that is not accepted.
    UnknownNameError
        If a kind is not known.
    """
    check_kinds(accept)
    left = tuple(each for each in anomalies(recordings) if each.kind not in accept)
    errors = tuple(each for each in left if each.severity == "error")
    if errors:
        raise ImplausibleError(errors)
    return left


def check_kinds(kinds: Iterable[str]) -> None:
    """Check names of kinds.

    Raises
    ------
    UnknownNameError
        If one is not known.
    """
    for kind in kinds:
        if kind not in KINDS:
            raise UnknownNameError("kind of anomaly", kind, KINDS)


def lines_of(found: Iterable[Anomaly]) -> list[str]:
    """Return anomalies as lines, those of one kind and joint in one with their number."""
    groups: dict[tuple[str, str | None], list[Anomaly]] = {}
    for each in found:
        groups.setdefault((each.kind, each.joint), []).append(each)
    return [
        f"{group[0].severity}: {group[0]}"
        + (f" (and in {number_of(len(group) - 1, 'further recording')})" if len(group) > 1 else "")
        for group in groups.values()
    ]


def _of_hands(recordings: RecordingSet) -> dict[str, list[Fault]]:
    """Return by recording what is wrong with all angles of a hand.

    Each recording is judged, and those that pass together, since a common fault may show too little
    in each.
    """
    found: dict[str, list[Fault]] = {r.name: [] for r in recordings}
    hands = dict.fromkeys((r.subject, r.session, r.hand.side) for r in recordings)
    for hand in hands:
        own = [r for r in recordings if (r.subject, r.session, r.hand.side) == hand]
        single = {r.name: _faults.of_whole_hand(r.q, tolerance=2.0) for r in own}
        others = [r for r in own if single[r.name] is None]
        common = _faults.of_whole_hand(np.vstack([r.q for r in others])) if others else None
        turned = looks_mirrored([r.q for r in own])
        for r in own:
            fault = single[r.name] or common
            if fault is not None:
                found[r.name].append(fault)
            if turned:
                found[r.name].append(_faults.mirrored(r, MIRRORED_JOINTS))
    return found
