"""The specification of a sweep: tasks, controllers, hands and conditions, all combined."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from handsim.errors import InputError
from handsim.grasping.conditions import LIMITS, Conditions, perturb
from handsim.hand.population import Sex, preset, sample_sizes
from handsim.tasks.task import Task
from handsim.types import HandSize, Side

DEMONSTRATOR = "demonstrator"
BUILT_IN = "built-in"
MAX_RUNS = 1_000_000
"""Limit of a sweep, whose rows are kept in memory, some 300 bytes each."""


@dataclass(frozen=True)
class SweepHand:
    """A hand size with its name in the table; lengths in m."""

    name: str
    length: float
    breadth: float

    def size(self, side: Side) -> HandSize:
        """Return the right or left hand of that size."""
        return HandSize(self.length, self.breadth, side)


def hand_preset(name: str) -> SweepHand:
    """Return a preset, ``woman-5`` to ``man-95``.

    Raises
    ------
    UnknownNameError
        If there is no such preset.
    """
    size = preset(name)
    return SweepHand(name, size.length, size.breadth)


def sampled_hands(sex: Sex, count: int, seed: int = 0) -> tuple[SweepHand, ...]:
    """Draw hands from a population; sizes are rounded to 0.1 mm, the precision of a measurement.

    Raises
    ------
    UnknownNameError
        If ``sex`` is neither ``woman`` nor ``man``.
    InputError
        If the count is negative.
    """
    sizes = sample_sizes(count, sex, seed)
    return tuple(
        SweepHand(f"{sex}-{seed}-{i}", round(size.length, 4), round(size.breadth, 4))
        for i, size in enumerate(sizes, start=1)
    )


@dataclass(frozen=True)
class SweepRun:
    """One run of a sweep, and its number in the order of all runs."""

    number: int
    controller: str
    hand: SweepHand
    side: Side
    task: Task
    friction: float | None
    mass_scale: float | None
    seed: int

    @property
    def usual(self) -> Conditions:
        """Nominal conditions of the hand, for which plans are made."""
        return Conditions(hand=self.hand.size(self.side))

    @property
    def conditions(self) -> Conditions:
        """Conditions of the run: seed 0 is nominal, all others are perturbed."""
        conditions = perturb(self.usual, self.seed) if self.seed else self.usual
        asked = {"friction": self.friction, "mass_scale": self.mass_scale}
        return replace(conditions, **{name: v for name, v in asked.items() if v is not None})


@dataclass(frozen=True)
class SweepSpec:
    """The values of a sweep, which are run in all combinations.

    Attributes
    ----------
    tasks
    controllers
        Names: ``built-in``, ``demonstrator``, or names that the caller gives its controllers.
    hands
    sides
    frictions
        Of the hand; None is the default in nominal runs and a random value in perturbed ones.
    mass_scales
        Factors on the object's mass; None is 1 in nominal runs and a random value in perturbed
        ones.
    seeds
        0 is a nominal run, all others are perturbed.

    Raises
    ------
    InputError
        If one is empty, holds a value twice or one out of range, or if the runs are too many.
    """

    tasks: tuple[Task, ...]
    controllers: tuple[str, ...] = (BUILT_IN,)
    hands: tuple[SweepHand, ...] = (hand_preset("man-50"),)
    sides: tuple[Side, ...] = ("right",)
    frictions: tuple[float | None, ...] = (None,)
    mass_scales: tuple[float | None, ...] = (None,)
    seeds: tuple[int, ...] = (0,)

    def __post_init__(self) -> None:
        """Check all values."""
        for name, values in vars(self).items():
            if not values:
                raise InputError(f"{name}: none is given; a sweep needs one at least")
            keys = [getattr(value, "name", value) for value in values]
            if len(set(keys)) < len(keys):
                twice = next(key for key in keys if keys.count(key) > 1)
                raise InputError(f"{name}: {twice} is there twice; no run is made twice")
        for hand in self.hands:
            Conditions(hand=hand.size("right"))
        for name, values in (
            ("friction", self.frictions), ("mass_scale", self.mass_scales), ("seed", self.seeds)
        ):  # fmt: skip
            _check_range(name, values)
        if self.n_runs > MAX_RUNS:
            raise InputError(f"{self.n_runs} runs, more than {MAX_RUNS}; split the sweep")

    @property
    def n_runs(self) -> int:
        """Number of all combinations."""
        n = 1
        for values in vars(self).values():
            n *= len(values)
        return n

    def runs(self) -> Iterator[SweepRun]:
        """Yield all combinations in their order."""
        combined = product(
            self.controllers, self.hands, self.sides, self.tasks, self.frictions,
            self.mass_scales, self.seeds,
        )  # fmt: skip
        for number, values in enumerate(combined):
            yield SweepRun(number, *values)


def _check_range(name: str, values: tuple[Any, ...]) -> None:
    low, high = LIMITS[name]
    for value in values:
        if value is not None and not low <= value <= high:
            raise InputError(f"{name} of {value:g} is outside {low:g} to {high:g}")
