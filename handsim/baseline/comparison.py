"""Compare two sets of results and list the differences, worst first.

Limits are tested as ``not distance <= limit``, so that NaN counts as beyond them.
"""

from collections.abc import Mapping
from math import isfinite

import numpy as np

from handsim.baseline.causes import causes_of, changed_inputs, options_in_words
from handsim.baseline.environment import Environment, differences
from handsim.baseline.findings import GOOD, ORDER, Change, Finding, Report
from handsim.baseline.inputs import SCHEMA_OF_INPUTS
from handsim.baseline.results import Results, Trace
from handsim.baseline.tolerances import ENVIRONMENT_LIMITS, Tolerances
from handsim.joints import JOINT_NAMES, N_JOINTS
from handsim.navigation.paths import path_error
from handsim.types import Array

SAME_TIME = 1e-6
"""Difference of last times below which two traces count as equally long [s]."""


def compare(
    before: Results,
    after: Results,
    tolerances: Tolerances | None = None,
    environments: tuple[Environment, Environment] | None = None,
    ignore_inputs: bool = False,
    notes: tuple[str, ...] = (),
) -> Report:
    """Compare results with those of the baseline.

    Parameters
    ----------
    before, after
        The baseline's results and the new ones.
    tolerances
    environments
        In which the baseline and the new results were made. A difference is reported as one of the
        environment where the environments differ, the inputs are the same and the trace has moved
        no further than `ENVIRONMENT_LIMITS`.
    ignore_inputs
        Report changed inputs as notes and not as findings. A controller learned anew differs in
        all its numbers, and only its movements are of interest.
    notes
        Further lines for the report: what differs in version.
    """
    tolerances = tolerances or Tolerances()
    names = list(dict.fromkeys([*before.traces, *after.traces]))
    changes: list[Change] = []
    findings: list[Finding] = []
    for name in names:
        faults = _faults(name, before.traces.get(name), after.traces.get(name))
        findings += faults
        if not faults:
            changes.append(trace_change(name, before.traces[name], after.traces[name], tolerances))
    versions = notes
    inputs = _input_findings(before.inputs, after.inputs)
    elsewhere = differences(*environments) if environments and not inputs else ()
    for change in changes:
        findings += _findings(change, elsewhere)
    if ignore_inputs:
        notes += tuple(f"{finding.name} {finding.text}" for finding in inputs)
    else:
        findings += inputs
    findings.sort(key=lambda finding: (ORDER.index(finding.kind), -finding.harm, finding.name))
    others = (*versions, *(differences(*environments) if environments else ()))
    causes = causes_of(findings, before.inputs, after.inputs, others)
    return Report(tuple(findings), tuple(changes), notes, len(names), environments, causes)


def unusable(trace: Trace) -> list[str]:
    """Say why the postures of a trace cannot be compared; empty if they can."""
    time, q = np.asarray(trace.time), np.asarray(trace.q)
    if time.ndim != 1 or q.shape != (len(time), N_JOINTS):
        return [f"has postures of shape {q.shape} for times of shape {time.shape}"]
    if not len(time):
        return ["has no frames"]
    bad = ~np.isfinite(q)
    if bad.any():
        frame, joint = np.argwhere(bad)[0]
        return [
            f"is no number in {bad.any(axis=1).sum()} of {len(q)} frames, "
            f"first {JOINT_NAMES[joint]} at {time[frame]:.2f} s"
        ]
    if not (np.isfinite(time).all() and (np.diff(time) > 0).all()):
        return ["has times that do not increase"]
    return []


def not_numbers(results: Results) -> list[str]:
    """Describe all values that are not finite; nothing can be compared with them later."""
    return [
        f"{name} {text}"
        for name, trace in results.traces.items()
        for text in (
            *unusable(trace),
            *(f"has {m} {v}" for m, v in trace.measures.items() if not isfinite(v)),
        )
    ]


def trace_change(name: str, before: Trace, after: Trace, tolerances: Tolerances) -> Change:
    """Measure how far one trace moved; a shorter one is continued by its last posture.

    Of a grasp that failed in the baseline only the verdict is compared, and that its measures are
    finite. It may fail in another way each time.
    """
    failed = name.startswith("grasp/") and before.verdict != "held"
    time, apart = deviation_deg(before, after)
    frame, joint = np.unravel_index(int(apart.argmax()), apart.shape)
    both = {
        m: (old, after.measures[m]) for m, old in before.measures.items() if m in after.measures
    }
    frames = (
        (len(before.time), float(before.time[-1])),
        (len(after.time), float(after.time[-1])),
    )
    as_long = frames[0][0] == frames[1][0] and abs(frames[0][1] - frames[1][1]) <= SAME_TIME
    return Change(
        name=name,
        joint=JOINT_NAMES[int(joint)],
        deviation_deg=float(apart[frame, joint]),
        time_s=float(time[frame]),
        path_deg=float(np.rad2deg(path_error(after.q, before.q))),
        before=before.verdict,
        after=after.verdict,
        measures={
            m: (old, new)
            for m, (old, new) in both.items()
            if not (isfinite(old) and isfinite(new))
            or not (failed or abs(new - old) <= tolerances.of_measure(m))
        },
        tolerance_deg=np.inf if failed else tolerances.of_answer(name),
        lost=tuple(m for m in before.measures if m not in after.measures),
        added=tuple(m for m in after.measures if m not in before.measures),
        frames=None if failed or as_long or before.verdict != after.verdict else frames,
    )


def deviation_deg(before: Trace, after: Trace) -> tuple[Array, Array]:
    """Return all times (n,) [s] of two traces, and the distance of each joint, (n, 22) [deg]."""
    time = np.union1d(before.time, after.time)
    return time, np.rad2deg(np.abs(_at(after, time) - _at(before, time)))


def _at(trace: Trace, time: Array) -> Array:
    angles: list[Array] = [np.interp(time, trace.time, angle) for angle in trace.q.T]
    return np.column_stack(angles)


def _faults(name: str, before: Trace | None, after: Trace | None) -> list[Finding]:
    """Say why a trace cannot be compared with the baseline's; empty if it can."""
    if after is None:
        return [Finding("missing", name, "is not made any more", np.inf)]
    if before is None:
        return [Finding("new", name, "is new; the baseline has no such answer", np.inf)]
    return [
        Finding("number" if text.startswith("is no number") else "shape", name,
                f"{text} {whose}", np.inf)
        for trace, whose in ((before, "in the baseline"), (after, "now"))
        for text in unusable(trace)
    ]  # fmt: skip


def _findings(change: Change, elsewhere: tuple[str, ...]) -> list[Finding]:
    """Describe a change; ``elsewhere`` is how the environments differ, if that may be why."""
    found: list[Finding] = []
    name = change.name
    if change.before != change.after:
        # What was good and is not any more comes before what changed in any other way.
        harm = 2.0 if change.before in GOOD else 1.0
        text = f"{change.before} in the baseline, {change.after} now"
        found.append(Finding("outcome", name, text, harm))
    if change.lost:
        text = f"{', '.join(change.lost)} not measured any more"
        found.append(Finding("missing", name, text, float(len(change.lost))))
    if change.added:
        text = f"{', '.join(change.added)} measured, and not in the baseline"
        found.append(Finding("new", name, text, float(len(change.added))))
    if change.frames:
        (n, end), (n_now, end_now) = change.frames
        text = f"{n} frames to {end:.2f} s in the baseline, {n_now} to {end_now:.2f} s now"
        found.append(Finding("shape", name, text, abs(end_now - end)))
    moved = _moved(change)
    if elsewhere and not found and _explained(change):
        why = f"a difference of environment: {_listed_briefly(elsewhere)}; "
        moved = [Finding("environment", name, why + each.text, each.harm) for each in moved]
    return found + moved


def _moved(change: Change) -> list[Finding]:
    found: list[Finding] = []
    if change.moved:
        text = (
            f"{change.joint} by {change.deviation_deg:.3g} deg at {change.time_s:.2f} s "
            f"(limit {change.tolerance_deg:g}), path by {change.path_deg:.3g} deg"
        )
        found.append(Finding("movement", change.name, text, change.deviation_deg))
    for measure, (before, after) in change.measures.items():
        size = abs(after - before) / max(abs(before), 1e-3)
        text = f"{measure} {before:.4g} in the baseline, {after:.4g} now"
        found.append(Finding("measure", change.name, text, size if isfinite(size) else np.inf))
    return found


def _explained(change: Change) -> bool:
    """Whether a trace has moved no further than another environment may move it."""
    return change.deviation_deg <= ENVIRONMENT_LIMITS.of_answer(change.name) and all(
        abs(after - before) <= ENVIRONMENT_LIMITS.of_measure(measure)
        for measure, (before, after) in change.measures.items()
    )


def _input_findings(before: Mapping[str, str], after: Mapping[str, str]) -> list[Finding]:
    """Name what changed among the inputs; the same change in many places is one finding."""
    if before.get(SCHEMA_OF_INPUTS) != after.get(SCHEMA_OF_INPUTS):
        text = "are kept in another way by this handsim and not compared; record the baseline again"
        return [Finding("input", "inputs", text, np.inf)]
    places: dict[tuple[str, str], list[str]] = {}
    for name in dict.fromkeys([*before, *after]):
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
    changed = changed_inputs(before, after)
    options = options_in_words({n: b for n, b in changed.items() if n.startswith("controller/")})
    return [
        Finding(
            "input",
            group,
            " ".join([text, _listed(names)]).strip()
            + (f": {'; '.join(options)}" if options and (group, text) == _OPTIONS else ""),
            float(len(names)),
        )
        for (group, text), names in places.items()
    ]


_OPTIONS = ("controller", "changed")


def _listed(names: list[str], most: int = 6) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return f"({', '.join(names[:most])}{more})" if names else ""


def _listed_briefly(lines: tuple[str, ...], most: int = 2) -> str:
    more = f" and {len(lines) - most} more" if len(lines) > most else ""
    return f"{', '.join(lines[:most])}{more}"
