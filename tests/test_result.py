"""What functions answer prints a field a line and converts to what JSON can hold."""

import json
from dataclasses import dataclass

import numpy as np

from handsim.result import Result


@dataclass(frozen=True)
class Part:
    name: str
    place: np.ndarray


@dataclass(frozen=True)
class Answer(Result):
    ratio: float
    done: bool
    axis: tuple[float, ...]
    trace: np.ndarray
    parts: tuple[Part, ...]
    counts: dict[str, np.int64]
    inner: "Answer | None" = None


def answer(inner: Answer | None = None) -> Answer:
    parts = tuple(Part(name, np.zeros(2)) for name in "abcde")
    counts = {"a": np.int64(1)}
    return Answer(2 / 3, True, (0.5, 1.0), np.arange(6.0).reshape(2, 3), parts, counts, inner)


def test_all_of_it_is_what_json_can_hold():
    said = answer(answer()).as_dict()
    assert json.loads(json.dumps(said)) == said
    assert said["trace"] == [[0, 1, 2], [3, 4, 5]]
    assert said["axis"] == [0.5, 1.0]
    assert said["parts"][1] == {"name": "b", "place": [0, 0]}
    assert said["counts"] == {"a": 1} and type(said["counts"]["a"]) is int
    assert said["inner"] == answer().as_dict()


def test_it_prints_a_field_a_line_and_counts_what_is_long():
    lines = str(answer()).splitlines()
    assert lines == [
        "ratio   0.6667",
        "done    True",
        "axis    0.5, 1",
        "trace   array of shape (2, 3)",
        "parts   5 entries",
        "counts  a 1",
        "inner   None",
    ]
