"""Read the specification of a sweep from a TOML file.

::

    tasks = "all"                                  # or names of Table I
    controllers = ["built-in", "demonstrator", "people.npz"]
    hands = ["woman-5", {length = 0.19, breadth = 0.085}]
    sides = ["right", "left"]
    frictions = [0.4, 0.8]
    mass_scales = [0.5, 1.0, 2.0]
    seeds = 21                                     # 0 to 20, or a list

    [[population]]
    sex = "woman"
    count = 50
    seed = 1

Only ``tasks`` is required. Files are relative to the folder of the TOML file.
"""

import tomllib
from collections.abc import Callable
from difflib import get_close_matches
from pathlib import Path
from typing import Any, cast

from handsim.errors import FileError, InputError
from handsim.files import read_text
from handsim.grasping.sweep.spec import (
    MAX_RUNS,
    SweepHand,
    SweepSpec,
    hand_preset,
    sampled_hands,
)
from handsim.tasks.table_one import TASKS, task_by_name
from handsim.tasks.task import Task

POPULATION_KEYS = ("sex", "count", "seed")
HAND_KEYS = ("length", "breadth")
SIDES = ("right", "left")


def read_sweep(path: Path) -> SweepSpec:
    """Read a sweep; keys that are unknown and values of a wrong type or out of range are refused.

    Raises
    ------
    FileError
        If it cannot be read, or a key or value is refused.
    """
    try:
        content = tomllib.loads(read_text(path))
    except FileError:
        raise
    except (ValueError, RecursionError) as error:  # integers of any length, lists of any depth
        raise FileError(f"{path}: not a TOML file ({error}); correct it") from error
    try:
        return _spec(content)
    except InputError as error:
        raise FileError(f"{path}: {error}") from error


def _spec(content: dict[str, Any]) -> SweepSpec:
    _check_keys(content, tuple(_READERS), "")
    if "tasks" not in content:
        raise InputError('tasks are missing; add tasks = "all" or a list of names')
    values = {key: _READERS[key](key, value) for key, value in content.items()}
    if "population" in values:
        values["hands"] = values.get("hands", ()) + values.pop("population")
    return SweepSpec(**values)


def _tasks(key: str, value: Any) -> tuple[Task, ...]:
    if value == "all":
        return TASKS
    return tuple(task_by_name(name) for name in _list(key, value, str, 'names of tasks, or "all"'))


def _controllers(key: str, value: Any) -> tuple[str, ...]:
    names = _list(key, value, str, "built-in, demonstrator, or controller files")
    for name in names:
        if not (name and name.isprintable()):
            raise InputError(f"{key}: {_shown(name)} is not the name of a file; give one")
    return names


def _hands(key: str, value: Any) -> tuple[SweepHand, ...]:
    said = "presets such as man-50, or tables {length, breadth} in m"
    return tuple(
        hand_preset(each) if isinstance(each, str) else _hand(key, each)
        for each in _list(key, value, str | dict, said)
    )


def _hand(key: str, table: dict[str, Any]) -> SweepHand:
    _check_keys(table, HAND_KEYS, f"{key}: ")
    length, breadth = (
        _number(f"{key}: {name}", table.get(name), float | int) for name in HAND_KEYS
    )
    return SweepHand(f"{length:g}x{breadth:g}", float(length), float(breadth))


def _sides(key: str, value: Any) -> tuple[str, ...]:
    sides = _list(key, value, str, "right or left")
    for side in sides:
        if side not in SIDES:
            raise InputError(f"{key}: {_shown(side)} is not one of {', '.join(SIDES)}")
    return sides


def _numbers(key: str, value: Any) -> tuple[float, ...]:
    return tuple(float(each) for each in _list(key, value, float | int, "numbers"))


def _seeds(key: str, value: Any) -> tuple[int, ...]:
    if isinstance(value, list):
        return _list(key, value, int, "whole numbers from 0")
    count = _number(key, value, int)
    if not 1 <= count <= MAX_RUNS:
        raise InputError(f"{key} of {_shown(count)} is outside 1 to {MAX_RUNS}")
    return tuple(range(count))


def _population(key: str, value: Any) -> tuple[SweepHand, ...]:
    tables = [cast("object", value)] if isinstance(value, dict) else value
    return tuple(
        hand
        for table in _list(key, tables, dict, "tables of sex, count and seed")
        for hand in _drawn(key, table)
    )


def _drawn(key: str, table: dict[str, Any]) -> tuple[SweepHand, ...]:
    _check_keys(table, POPULATION_KEYS, f"{key}: ")
    sex = table.get("sex")
    if sex not in ("woman", "man"):
        raise InputError(f"{key}: sex is {_shown(sex)}; give woman or man")
    count, seed = (_number(f"{key}: {k}", table.get(k, 0), int) for k in ("count", "seed"))
    if not 1 <= count <= MAX_RUNS:
        raise InputError(f"{key}: count of {_shown(count)} is outside 1 to {MAX_RUNS}")
    if not 0 <= seed < 2**63:
        raise InputError(f"{key}: seed of {_shown(seed)} is outside 0 to 2^63 - 1")
    return sampled_hands(sex, count, seed)


_READERS: dict[str, Callable[[str, Any], tuple[Any, ...]]] = {
    "tasks": _tasks,
    "controllers": _controllers,
    "hands": _hands,
    "population": _population,
    "sides": _sides,
    "frictions": _numbers,
    "mass_scales": _numbers,
    "seeds": _seeds,
}


def _check_keys(table: dict[str, Any], known: tuple[str, ...], where: str) -> None:
    for key in table:
        if key not in known:
            near = get_close_matches(key, known, n=1)
            remedy = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}"
            raise InputError(f"{where}unknown key {_shown(key)}; {remedy}")


def _list(key: str, value: Any, kind: Any, said: str) -> tuple[Any, ...]:
    if not isinstance(value, list):
        raise InputError(f"{key} is {_shown(value)}; give a list of {said}")
    items = cast("list[Any]", value)
    for each in items:
        if not isinstance(each, kind) or isinstance(each, bool):
            raise InputError(f"{key} holds {_shown(each)}; give {said}")
    return tuple(items)


def _number(key: str, value: Any, kind: Any) -> Any:
    if not isinstance(value, kind) or isinstance(value, bool):
        wanted = "a whole number" if kind is int else "a number"
        raise InputError(f"{key} is {_shown(value)}; give {wanted}")
    return value


def _shown(value: Any) -> str:
    """Return a value as text that fits on a line."""
    text = "missing" if value is None else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
