"""Summary of a sweep: success rates by controller and task."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from handsim.grasping.judging.rates import wilson_interval

Row = Mapping[str, str]
"""A row of the results table, as text."""


@dataclass(frozen=True)
class Rates:
    """Successes among nominal and perturbed runs.

    Attributes
    ----------
    nominal, nominal_held
        Numbers of nominal runs, and of those that held.
    trials, successes
        Numbers of perturbed runs, and of those that held.
    reasons
        Why nominal runs failed, each reason once.
    """

    nominal: int
    nominal_held: int
    trials: int
    successes: int
    reasons: tuple[str, ...]

    @classmethod
    def of(cls, rows: Iterable[Row]) -> "Rates":
        """Count."""
        kept = list(rows)
        nominal = [row for row in kept if row["nominal"] == "True"]
        held, all_held = (sum(row["success"] == "True" for row in some) for some in (nominal, kept))
        return cls(
            nominal=len(nominal),
            nominal_held=held,
            trials=len(kept) - len(nominal),
            successes=all_held - held,
            reasons=tuple(dict.fromkeys(row["reason"] for row in nominal if row["reason"])),
        )

    def as_json(self) -> dict[str, Any]:
        """Return the numbers with Wilson's interval of the perturbed runs."""
        return {
            "nominal": self.nominal,
            "nominal_held": self.nominal_held,
            "trials": self.trials,
            "successes": self.successes,
            "success_interval": wilson_interval(self.successes, self.trials),
        }

    def in_a_cell(self) -> str:
        """Return the rates as text for a cell of a table."""
        if self.nominal == 1:
            nominal = ["held" if self.nominal_held else self.reasons[0]]
        else:
            nominal = [f"{self.nominal_held}/{self.nominal} nominal"] if self.nominal else []
        return ", ".join(nominal + ([f"{self.successes}/{self.trials}"] if self.trials else []))

    def in_words(self) -> str:
        """Return the rates as text, with Wilson's interval."""
        low, high = wilson_interval(self.successes, self.trials)
        rate = 100 * self.successes / max(self.trials, 1)
        perturbed = f"perturbed {rate:.0f} % ({100 * low:.0f} to {100 * high:.0f})"
        nominal = f"{self.nominal_held} of {self.nominal}"
        parts = ([nominal] if self.nominal else []) + ([perturbed] if self.trials else [])
        return ", ".join(parts)


def rates(rows: Iterable[Row]) -> dict[str, dict[str, Rates]]:
    """Return rates by controller, then by task, in the order of the rows; the last is ``all``."""
    grouped: dict[str, dict[str, list[Row]]] = {}
    for row in rows:
        of_controller = grouped.setdefault(row["controller"], {})
        of_controller.setdefault(row["task"], []).append(row)
    return {
        controller: {task: Rates.of(kept) for task, kept in tasks.items()}
        | {"all": Rates.of(row for kept in tasks.values() for row in kept)}
        for controller, tasks in grouped.items()
    }


def results_table(rows: Iterable[Row]) -> str:
    """Return a Markdown table of tasks and controllers; its last row is the rates of all tasks."""
    found = rates(rows)
    lines = [f"| task | {' | '.join(found)} |", f"|---|{'---|' * len(found)}"]
    first = next(iter(found.values()), dict[str, Rates]())
    tasks = [task for task in first if task != "all"]
    for task in tasks:
        cells = (of_task[task].in_a_cell() for of_task in found.values())
        lines.append(f"| {task} | {' | '.join(cells)} |")
    totals = (of_task["all"].in_words() for of_task in found.values())
    lines.append(f"| **all** | {' | '.join(totals)} |")
    return "\n".join(lines) + "\n"
