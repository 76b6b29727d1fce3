"""What a check found: how far each trace moved, and the findings as text."""

from dataclasses import asdict, dataclass
from typing import Any, Literal

from handsim.baseline.environment import Environment, differences
from handsim.wording import number_of

Kind = Literal[
    "environment", "outcome", "missing", "new", "shape", "number", "movement", "measure", "input"
]
ORDER: tuple[Kind, ...] = (
    "environment", "outcome", "missing", "new", "shape", "number", "movement", "measure", "input"
)  # fmt: skip
"""Order of findings: first those that another environment explains, then the worst."""
GOOD = ("held", "arrived")
"""Verdicts of a success."""
MOST_LISTED = 3
"""So many findings of one cause are listed; more are one line."""


@dataclass(frozen=True)
class Change:
    """How one trace differs from the baseline's.

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
        Values before and after, of those beyond their tolerance or not finite.
    tolerance_deg
        Limit of ``deviation_deg``.
    lost, added
        Measures that only the baseline has, and that only the new trace has.
    frames
        Number of frames and last time [s], before and after. None where the length is the same or
        may change.
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
    lost: tuple[str, ...] = ()
    added: tuple[str, ...] = ()
    frames: tuple[tuple[int, float], tuple[int, float]] | None = None

    @property
    def moved(self) -> bool:
        """Whether a joint deviates beyond the tolerance, as NaN does."""
        return not self.deviation_deg <= self.tolerance_deg

    @property
    def within(self) -> bool:
        """Whether all differences are within the tolerances."""
        same = self.before == self.after and self.frames is None
        return same and not (self.moved or self.measures or self.lost or self.added)


@dataclass(frozen=True)
class Finding:
    """One difference beyond its tolerance, as text; ``harm`` orders those of one kind."""

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
        One for every trace that both have and that can be compared.
    notes
        Differences that do not count, such as inputs where those are ignored.
    n_answers
        Number of different names of traces in the baseline and now.
    environments
        Of the baseline and of now, where they are known.
    causes
        What the findings follow from: text, and the findings, worst first.
    """

    findings: tuple[Finding, ...]
    changes: tuple[Change, ...]
    notes: tuple[str, ...]
    n_answers: int
    environments: tuple[Environment, Environment] | None = None
    causes: tuple[tuple[str, tuple[Finding, ...]], ...] = ()

    @property
    def ok(self) -> bool:
        """Whether nothing moved."""
        return not self.findings

    @property
    def differences(self) -> tuple[str, ...]:
        """What differs between the environments, a line each."""
        return differences(*self.environments) if self.environments else ()

    def as_dict(self) -> dict[str, Any]:
        """Return what `handsim baseline check --json` says."""
        before, now = self.environments or (None, None)
        return {
            "ok": self.ok,
            "environment": {
                "before": asdict(before) if before else None,
                "now": asdict(now) if now else None,
                "differences": list(self.differences),
            },
            "findings": [asdict(finding) for finding in self.findings],
            "causes": [
                {"cause": text, "findings": len(of_cause), "names": [f.name for f in of_cause]}
                for text, of_cause in self.causes
            ],
            "notes": list(self.notes),
            "answers": [asdict(change) | {"within": change.within} for change in self.changes],
        }

    def as_text(self, *, details: bool = False) -> str:
        """Return lines for people: first how the environments differ, then the findings.

        Parameters
        ----------
        details
            Give each finding a line, however many follow from one cause.
        """
        head = (
            f"{number_of(self.n_answers, 'answer')} as in the baseline"
            if self.ok
            else f"{number_of(len(self.findings), 'finding')} in "
            f"{number_of(self.n_answers, 'answer')}, worst first"
        )
        first = [f"environment: {difference}" for difference in self.differences]
        many = [] if details else [each for each in self.causes if len(each[1]) > MOST_LISTED]
        together = {finding for _, of_cause in many for finding in of_cause}
        alone = [finding for finding in self.findings if finding not in together]
        lines = [_in_one_line(text, of_cause) for text, of_cause in many]
        width = max((len(finding.name) for finding in alone), default=0)
        rows = [f"{f.kind:<11} {f.name:<{width}}  {f.text}" for f in alone]
        return "\n".join([*first, head, *lines, *rows, *(f"note: {note}" for note in self.notes)])


def _in_one_line(cause: str, findings: tuple[Finding, ...]) -> str:
    """Return a cause, how much follows from it, and the worst of that."""
    worst = next((finding for finding in findings if finding.kind != "input"), findings[0])
    told = number_of(len(findings), "finding")
    return f"{cause}: {told}, the worst {worst.kind} {worst.name} {worst.text}"
