"""Outcomes as tables in Markdown, with the machine and the versions that they were found with."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from handsim.baseline.environment import Environment

from .data import TrialSet
from .running import N_RANDOM, SETTINGS, Measured, Outcome


@dataclass(frozen=True)
class Row:
    """One rival on all sets of a folder."""

    name: str
    measured: Sequence[Measured]

    def outcomes(self, setting: str) -> list[Outcome]:
        """Return the outcomes in one setting, one a set."""
        return [each.outcomes[setting] for each in self.measured]

    def mean(self, setting: str, name: str) -> float:
        """Return the mean over the sets of a score's mean, NaN where no set has it."""
        means = np.array([each.mean(name) for each in self.outcomes(setting)])
        known = means[np.isfinite(means)]
        return float(known.mean()) if known.size else float("nan")

    def ratio(self, setting: str) -> float:
        """Return the mean over the sets of the ratio."""
        return float(np.mean([each.ratio for each in self.outcomes(setting)]))


def machine() -> str:
    """Return a line about processor and versions."""
    here = Environment.here()
    return (
        f"{here.processor}, {here.system}; Python {here.python}, NumPy {here.numpy}, "
        f"SciPy {here.scipy}, scikit-learn {here.scikit_learn}; BLAS threads {here.blas_threads}."
    )


def tables(name: str, sets: Sequence[TrialSet], rows: Sequence[Row], n_folds: int) -> str:
    """Return the section of a folder: scores of all rivals, and their ratios set by set."""
    n, unit = sum(len(each.trials) for each in sets), sets[0].unit
    if len(sets) == 1:
        title = f"### {name}: {n} movements"
    else:
        title = f"### {name}: {n} movements in {len(sets)} sets ({', '.join(s.name for s in sets)})"
    lines = [title, "", _floor(sets, rows[0]), ""]
    header = [
        "method",
        *(f"path: {each}" for each in ("training", "left out", f"{n_folds} folds")),
        f"over time, {unit}: training",
        "over time: left out",
        "speed: training",
        "speed: left out",
        f"arrive of {n}: training",
        "arrive: left out",
        f"arrive of {N_RANDOM * len(sets)} random starts",
        "proven, left out",
        "learning, CPU s",
        "a query, CPU ms",
    ]
    lines += _table(header, [_cells(row) for row in rows])
    if len(sets) > 1:
        per_set = [
            [row.name, *(f"{each.ratio:.2f}" for each in row.outcomes("left out"))] for row in rows
        ]
        lines += ["", "Path, left out, set by set:", ""]
        lines += _table(["method", *(each.name for each in sets)], per_set)
    return "\n".join([*lines, ""])


def _cells(row: Row) -> list[str]:
    training, out = row.outcomes("training"), row.outcomes("left out")
    proven = sum(each.proven for each in out)
    return [
        row.name,
        *(f"{row.ratio(setting):.3f}" for setting in SETTINGS),
        *(f"{row.mean(setting, 'rms'):.1f}" for setting in SETTINGS[:2]),
        *(f"{row.mean(setting, 'speed_correlation'):.2f}" for setting in SETTINGS[:2]),
        *(str(sum(each.arrived for each in outcomes)) for outcomes in (training, out)),
        str(sum(each.random for each in row.measured)),
        f"{proven}: {row.measured[0].argument}" if proven else "no",
        f"{np.mean([each.learning for each in training]):.2f}",
        f"{1e3 * np.mean([each.query for each in out]):.1f}",
    ]


def _floor(sets: Sequence[TrialSet], row: Row) -> str:
    n_components, unit = sets[0].n_components, sets[0].unit
    if n_components is None:
        return "Places of the pen as they are."
    floors = (row.mean(setting, "floor") for setting in SETTINGS[:2])
    told = ", ".join(f"{each:.1f} {unit}" for each in floors)
    return f"The recordings themselves in {n_components} components are off by {told} over time."


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    body = ["| " + " | ".join(row) + " |" for row in (header, *rows)]
    return [body[0], "|" + "---|" * len(header), *body[1:]]
