"""What has moved between two sets of answers, worst first."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

import numpy as np

from handsim.baseline.outputs import Outputs, Trace
from handsim.errors import InputError
from handsim.joints import JOINT_NAMES, Array
from handsim.learning.paths import path_error

Kind = Literal["outcome", "missing", "movement", "measure", "input"]
_RANK: dict[Kind, int] = {"outcome": 0, "missing": 1, "movement": 2, "measure": 3, "input": 4}
MEASURES = {
    "lift_m": 0.003,
    "peak_slip_m": 0.001,
    "peak_tilt_deg": 5.0,
    "hold_s": 0.05,
    "penetration_m": 0.0002,
}
"""How far what a grasp is judged by may move."""


@dataclass(frozen=True)
class Tolerances:
    """How far answers may move.

    On one machine with one set of versions every answer repeats to the bit, whatever the process
    or the number of threads. From MuJoCo 4.0.0 to 3.17.0, 21 grasps, no outcome changes. In those
    that hold the glove's readings move by 1 deg, one of its steps, and in the worst three by 2 to
    4; slip by up to 0.41 mm, tilt by 3.8 deg, lift by 2.1 mm, the time held by 0.02 s, penetration
    by 0.11 mm. One that fails moves by more; of those only the outcome is compared. Movements,
    which MuJoCo has no part in, do not move at all. The defaults leave that and little more, so
    that within one version smaller ones can be asked for.

    Attributes
    ----------
    movement_deg, grasp_deg
        Largest deviation of a joint in a movement, and in a grasp [deg].
    measures
        By name of the measure, in its own unit.
    """

    movement_deg: float = 0.01
    grasp_deg: float = 5.0
    measures: Mapping[str, float] = field(default_factory=lambda: dict(MEASURES))

    def __post_init__(self) -> None:
        """Check that none is negative.

        Raises
        ------
        InputError
            If one is.
        """
        for name, value in (("movement", self.movement_deg), ("grasp", self.grasp_deg)):
            if not 0 <= value < np.inf:
                raise InputError(f"tolerance of a {name} of {value:g} deg; give 0 or more")


@dataclass(frozen=True)
class Change:
    """How one answer differs from the baseline's.

    Attributes
    ----------
    name
    joint, deviation_deg, time_s
        The joint that deviates most, by how much and when.
    path_deg
        Root-mean-square distance of the paths of all joints, each over its own length [deg].
    before, after
        Verdicts.
    measures
        Before and after, of those beyond their tolerance.
    tolerance_deg
        Of the joint's deviation.
    """

    name: str
    joint: str
    deviation_deg: float
    time_s: float
    path_deg: float
    before: str
    after: str
    measures: dict[str, tuple[float, float]]
    tolerance_deg: float

    @property
    def within(self) -> bool:
        """Whether it is no change within the tolerances."""
        return not (
            self.before != self.after or self.measures or self.deviation_deg > self.tolerance_deg
        )


@dataclass(frozen=True)
class Finding:
    """One thing that moved, in words for people."""

    kind: Kind
    name: str
    text: str
    harm: float


@dataclass(frozen=True)
class Report:
    """The outcome of a check.

    Attributes
    ----------
    findings
        What moved beyond its tolerance, worst first.
    changes
        Of every answer that both have.
    notes
        What differs without being counted: versions, and inputs where those are ignored.
    """

    findings: tuple[Finding, ...]
    changes: tuple[Change, ...]
    notes: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """Whether nothing moved."""
        return not self.findings

    def as_json(self) -> dict[str, Any]:
        """Return what `handsim baseline check --json` says."""
        return {
            "ok": self.ok,
            "findings": [asdict(finding) for finding in self.findings],
            "notes": list(self.notes),
            "answers": [asdict(change) | {"within": change.within} for change in self.changes],
        }

    def as_text(self) -> str:
        """Return it in lines for people."""
        head = (
            f"{len(self.changes)} answers as in the baseline"
            if self.ok
            else f"{len(self.findings)} findings in {len(self.changes)} answers, worst first"
        )
        width = max((len(finding.name) for finding in self.findings), default=0)
        rows = [f"{f.kind:<9} {f.name:<{width}}  {f.text}" for f in self.findings]
        return "\n".join([head, *rows, *(f"note: {note}" for note in self.notes)])


def compare(
    before: Outputs,
    after: Outputs,
    tolerances: Tolerances | None = None,
    versions: tuple[Mapping[str, str], Mapping[str, str]] = ({}, {}),
    ignore_inputs: bool = False,
) -> Report:
    """Compare answers with the baseline's.

    Parameters
    ----------
    before, after
        The baseline's answers and the new ones.
    tolerances
    versions
        Of the baseline and of now; differences are noted.
    ignore_inputs
        Note changed inputs instead of counting them: a controller learned anew differs in all its
        numbers, and the question is what it does.
    """
    tolerances = tolerances or Tolerances()
    common = [name for name in before.traces if name in after.traces]
    changes = [
        trace_change(name, before.traces[name], after.traces[name], tolerances) for name in common
    ]
    findings = [finding for change in changes for finding in _findings(change)]
    for name in before.traces:
        if name not in after.traces:
            findings.append(Finding("missing", name, "is not made any more", np.inf))
    inputs = _input_findings(before.inputs, after.inputs)
    notes = [
        f"{name} {versions[0].get(name, 'none')} in the baseline, {now} here"
        for name, now in versions[1].items()
        if versions[0].get(name) != now
    ]
    if ignore_inputs:
        notes += [f"{finding.name} {finding.text}" for finding in inputs]
    else:
        findings += inputs
    findings.sort(key=lambda finding: (_RANK[finding.kind], -finding.harm, finding.name))
    return Report(tuple(findings), tuple(changes), tuple(notes))


def trace_change(name: str, before: Trace, after: Trace, tolerances: Tolerances) -> Change:
    """Measure how far one answer moved; a shorter one stays where it ends."""
    grasp = name.startswith("grasp/")
    failed = grasp and before.verdict != "held"
    time, apart = deviation_deg(before, after)
    frame, joint = np.unravel_index(int(apart.argmax()), apart.shape)
    measures = {
        measure: (value, after.measures[measure])
        for measure, value in before.measures.items()
        if not failed
        and measure in after.measures
        and abs(after.measures[measure] - value) > tolerances.measures[measure]
    }
    tolerance = tolerances.grasp_deg if grasp else tolerances.movement_deg
    return Change(
        name=name,
        joint=JOINT_NAMES[int(joint)],
        deviation_deg=float(apart[frame, joint]),
        time_s=float(time[frame]),
        path_deg=float(np.rad2deg(path_error(after.q, before.q))),
        before=before.verdict,
        after=after.verdict,
        measures=measures,
        tolerance_deg=np.inf if failed else tolerance,
    )


def deviation_deg(before: Trace, after: Trace) -> tuple[Array, Array]:
    """Return all times (n,) [s] of two answers, and how far each joint is apart, (n, 22) [deg]."""
    time = np.union1d(before.time, after.time)
    return time, np.rad2deg(np.abs(_at(after, time) - _at(before, time)))


def _at(trace: Trace, time: Array) -> Array:
    return np.column_stack([np.interp(time, trace.time, angle) for angle in trace.q.T])


def _findings(change: Change) -> list[Finding]:
    found = []
    if change.before != change.after:
        # What was good and is not any more comes before what changed in any other way.
        harm = 2.0 if change.before in ("held", "arrived") else 1.0
        text = f"{change.before} in the baseline, {change.after} now"
        found.append(Finding("outcome", change.name, text, harm))
    if change.deviation_deg > change.tolerance_deg:
        text = (
            f"{change.joint} by {change.deviation_deg:.3g} deg at {change.time_s:.2f} s "
            f"(limit {change.tolerance_deg:g}), path by {change.path_deg:.3g} deg"
        )
        found.append(Finding("movement", change.name, text, change.deviation_deg))
    for measure, (before, after) in change.measures.items():
        size = abs(after - before) / max(abs(before), 1e-3)
        text = f"{measure} {before:.4g} in the baseline, {after:.4g} now"
        found.append(Finding("measure", change.name, text, size))
    return found


def _input_findings(before: Mapping[str, str], after: Mapping[str, str]) -> list[Finding]:
    """Name what changed among the inputs; what changed alike in many places is told once."""
    places: dict[tuple[str, str], list[str]] = {}
    for name in (*before, *(name for name in after if name not in before)):
        old, new = before.get(name), after.get(name)
        if old == new:
            continue
        group, _, place = name.partition("/")
        if group == "condition":
            text = f"{old or 'none'} in the baseline, {new or 'none'} now"
            places.setdefault((name, text), [])
            continue
        text = "is new" if old is None else "is gone" if new is None else "changed"
        places.setdefault((group, text), []).append(place)
    return [
        Finding("input", group, " ".join([text, _listed(names)]).strip(), float(len(names)))
        for (group, text), names in places.items()
    ]


def _listed(names: list[str], most: int = 6) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"({', '.join(names[:most])}{more})" if names else ""
