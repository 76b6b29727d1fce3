"""A check as one HTML page: the findings, and the curves of before and after."""

import tempfile
from dataclasses import asdict
from pathlib import Path

import numpy as np

from handsim.baseline.comparison import deviation_deg
from handsim.baseline.environment import LABELS
from handsim.baseline.findings import Change, Report
from handsim.baseline.results import Results, Trace
from handsim.baseline.store import Baseline
from handsim.files import write_text
from handsim.joints import JOINT_INDEX
from handsim.viewing import html as page
from handsim.viewing.figures.style import BLUE, VERMILION, WIDE, drawing, save_figure
from handsim.wording import number_of

MOST_DRAWN = 12
"""Largest number of traces whose curves are drawn; those that moved most are taken."""
_JOINTS = 3  # joints drawn of each


def write_page(path: Path, baseline: Baseline, results: Results, report: Report) -> None:
    """Write the page, as a whole or not at all."""
    moved = sorted(
        (change for change in report.changes if not change.within),
        key=lambda change: -change.deviation_deg / max(change.tolerance_deg, 1e-9),
    )
    sections = [("findings", "What moved", _findings(report))]
    if report.differences:
        sections.insert(0, ("environment", "Another environment", page.listing(report.differences)))
    if moved:
        sections.append(("curves", "Curves", _curves(moved[:MOST_DRAWN], baseline, results)))
    sections += [
        ("answers", "All answers", _answers(report)),
        ("versions", "Environment and reasons", _environment(baseline, report)),
    ]
    verdict = "as in the baseline" if report.ok else number_of(len(report.findings), "finding")
    top = page.tiles(
        (
            (verdict, "verdict"),
            (str(report.n_answers), "answers compared"),
            (str(len(moved)), "of them moved beyond their tolerance"),
        )
    )
    lead = "Answers of a controller compared with those that were taken for right"
    write_text(path, page.page("Check of a baseline", lead, top, sections))


def _findings(report: Report) -> str:
    if report.ok:
        return page.paragraph("Nothing moved beyond its tolerance.")
    rows = [(finding.kind, finding.name, finding.text) for finding in report.findings]
    return page.table(("kind", "what", "how, worst first"), rows, n_text=3)


def _answers(report: Report) -> str:
    rows = [
        (
            change.name,
            change.after
            if change.before == change.after
            else f"{change.before}, now {change.after}",
            change.joint if change.deviation_deg else "",
            f"{change.deviation_deg:.3g}",
            f"{change.time_s:.2f}" if change.deviation_deg else "",
            f"{change.path_deg:.3g}",
            change.within,
        )
        for change in report.changes
    ]
    header = (
        "answer", "outcome", "joint that moved most", "by [deg]", "at [s]", "path by [deg]",
        "within tolerance",
    )  # fmt: skip
    return page.table(header, rows, n_text=3)


def _environment(baseline: Baseline, report: Report) -> str:
    kept, now = (asdict(one) for one in report.environments or (baseline.environment,) * 2)
    rows = [(LABELS.get(name, name), kept[name], now[name]) for name in kept]
    reasons = [f"{i}. {reason}" for i, reason in enumerate(baseline.reasons, start=1)]
    notes = "".join(page.paragraph(note) for note in report.notes)
    return page.table(("", "baseline", "here"), rows, n_text=3) + notes + page.listing(reasons)


def _curves(moved: list[Change], baseline: Baseline, results: Results) -> str:
    with tempfile.TemporaryDirectory() as folder:
        return "".join(
            _curve(change, baseline.results.traces[change.name], results.traces[change.name],
                   Path(folder))
            for change in moved
        )  # fmt: skip


def _curve(change: Change, before: Trace, after: Trace, folder: Path) -> str:
    with drawing(WIDE, 1.7) as figure:
        panels = figure.subplots(1, _JOINTS, sharex=True)
        for axes, joint in zip(panels, _joints(change, before, after), strict=True):
            index = JOINT_INDEX[joint]
            for trace, style in ((before, {"color": BLUE}), (after, _AFTER)):
                axes.plot(trace.time, np.rad2deg(trace.q[:, index]), **style)
            axes.set_title(joint)
            axes.set_xlabel("time [s]")
        panels[0].set_ylabel("angle [deg]")
        panels[0].axvline(change.time_s, color="0.6", linewidth=0.7)
        panels[-1].legend(["baseline", "now"])
    save_figure(figure, folder, "curve")
    caption = f"{change.name}: {change.joint} by {change.deviation_deg:.3g} deg at "
    return page.picture(folder / "curve.svg", f"{caption}{change.time_s:.2f} s")


_AFTER = {"color": VERMILION, "linestyle": (0, (4, 1.5))}


def _joints(change: Change, before: Trace, after: Trace) -> list[str]:
    """Return the joints that deviate most at any time."""
    most = deviation_deg(before, after)[1].max(axis=0)
    others = sorted(set(JOINT_INDEX) - {change.joint}, key=lambda name: -most[JOINT_INDEX[name]])
    return [change.joint, *others[: _JOINTS - 1]]
