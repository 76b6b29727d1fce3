"""What is predicted for a query: paths, timings, and who is asked for unknown objects."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.learning.demonstration import Demonstration
from handsim.learning.guide.gaussian_process import cholesky, predicted, regression_weights
from handsim.learning.guide.likeness import Likeness, object_numbers
from handsim.learning.guide.predictor import GuideSettings, PathPredictor
from handsim.learning.movement.progress import minimum_jerk
from handsim.navigation.paths import at_arc_length, path_error

S = np.linspace(0.0, 1.0, 100)
TIMES = np.linspace(0.0, 1.0, 51)
SETTINGS = GuideSettings()


def demonstrated(
    start: list[float], goal: list[float], bulge: float, thing: str = "cup", duration: float = 1.0,
    late: float = 0.0, **numbers: float,
) -> Demonstration:  # fmt: skip
    """A path that bulges to the side of its segment by ``bulge``, its middle late by ``late``."""
    a, b = np.array(start, dtype=float), np.array(goal, dtype=float)
    aside = np.array([0.0, 0.0, 1.0])
    path = a + S[:, None] * (b - a) + bulge * np.sin(np.pi * S)[:, None] * aside
    progress = minimum_jerk(TIMES, 1.0) - late * np.sin(np.pi * TIMES) ** 2
    return Demonstration(
        "d", "t", thing, np.zeros(22), np.zeros(22), a, b, 0.19, 0.085, duration, numbers,
        at_arc_length(path, S), progress,
    )  # fmt: skip


def bulge_of(path: np.ndarray) -> float:
    return float(
        path[:, 2].max() if abs(path[:, 2].max()) > abs(path[:, 2].min()) else path[:, 2].min()
    )


CUPS = [demonstrated([0, 0.1 * i, 0], [1, 0.2 * i, 0], 0.4) for i in range(-2, 3)]
PENS = [demonstrated([0, 0.1 * i, 0], [1, 0.2 * i, 0], -0.4, "pen", late=0.1) for i in range(-2, 3)]


def test_regression_is_that_of_the_textbook() -> None:
    rng = np.random.default_rng(0)
    root = rng.normal(size=(9, 9))
    kernel, values, shares = root @ root.T, rng.normal(size=(9, 4)), rng.normal(size=9)
    np.testing.assert_allclose(cholesky(kernel + np.eye(9)), np.linalg.cholesky(kernel + np.eye(9)))
    weights = regression_weights(kernel, 0.3, values)
    wanted = shares @ np.linalg.solve(kernel + 0.3 * np.eye(9), values)
    np.testing.assert_allclose(predicted(shares, weights), wanted, atol=1e-10)


def test_a_known_object_is_approached_as_it_was() -> None:
    asked = PathPredictor.of(CUPS + PENS, SETTINGS)
    start, goal = np.array([0.0, 0.05, 0.0]), np.array([1.0, 0.1, 0.0])
    cup, pen = asked.path(start, goal, "cup"), asked.path(start, goal, "pen")
    assert 0.3 < bulge_of(cup) < 0.45 and -0.45 < bulge_of(pen) < -0.3
    np.testing.assert_array_equal(cup[[0, -1]], [start, goal])
    steps = np.linalg.norm(np.diff(cup, axis=0), axis=1)
    np.testing.assert_allclose(steps, steps.mean(), rtol=1e-2)  # equally spaced
    assert abs(bulge_of(asked.path(start, goal))) < 0.05  # either is as likely


def test_an_unknown_object_is_guessed_from_the_destination() -> None:
    here = [demonstrated([0, 0, 0], [1, 0.1 * i, 0], 0.4) for i in range(4)]
    there = [demonstrated([0, 0, 0], [1, 1 + 0.1 * i, 0], -0.4, "pen") for i in range(4)]
    asked = PathPredictor.of(here + there, SETTINGS)
    start = np.zeros(3)
    for goal, thing in (([1, 0.15, 0], "cup"), ([1, 1.15, 0], "pen")):
        known = asked.path(start, np.array(goal, float), thing)
        for nothing in (None, "never heard of"):
            guessed = asked.path(start, np.array(goal, float), nothing)
            assert path_error(guessed, known) < 0.03


def test_far_from_all_recordings_what_they_share_is_left() -> None:
    asked = PathPredictor.of(CUPS, SETTINGS)
    far = asked.path(np.array([0.0, 50.0, 0.0]), np.array([1.0, 50.0, 0.0]), "cup")
    assert np.isfinite(far).all()
    alone = PathPredictor.of(CUPS, replace(SETTINGS, linear=1e-9, common=1e-9))
    far = alone.path(np.array([0.0, 50.0, 0.0]), np.array([1.0, 50.0, 0.0]), "cup")
    assert abs(bulge_of(far)) < 1e-6  # nothing is known: straight


def test_timing_is_that_of_the_object_and_rises() -> None:
    asked = PathPredictor.of(CUPS + PENS, SETTINGS)
    start, goal = np.zeros(3), np.array([1.0, 0.0, 0.0])
    cup, pen = (asked.covered(start, goal, 1.0, thing) for thing in ("cup", "pen"))
    for curve in (cup, pen):
        assert curve[0] == 0.0 and curve[-1] == 1.0 and (np.diff(curve) >= 0).all()
    np.testing.assert_allclose(cup, minimum_jerk(np.linspace(0, 1, 16), 1.0), atol=0.03)
    assert 0.05 < (cup - pen).max() < 0.1


def test_numbers_of_objects_serve_objects_never_grasped() -> None:
    numbered = [
        demonstrated([0, 0, 0], [1, 0.05 * i, 0], 0.1 + w, f"thing{i}", object_width_m=w)
        for i, w in enumerate((0.02, 0.03, 0.30, 0.31))
    ]
    asked = PathPredictor.of(numbered, SETTINGS)
    start, goal = np.zeros(3), np.array([1.0, 0.1, 0.0])
    small = asked.path(start, goal, {"object_width_m": 0.025})
    large = asked.path(start, goal, {"object_width_m": 0.305})
    assert bulge_of(small) < 0.2 and bulge_of(large) > 0.3
    with pytest.raises(InputError, match="object_width_m"):
        asked.path(start, goal, {"object_height_m": 0.1})
    with pytest.raises(InputError, match="the recordings have none"):
        PathPredictor.of(CUPS, SETTINGS).path(start, goal, {"object_width_m": 0.1})


def test_likeness_by_names_and_by_numbers() -> None:
    by_name = Likeness.of(("a", "b", "a"), [{}, {}, {}], 0.2)
    np.testing.assert_allclose(by_name.among, [[1, 0.2, 1], [0.2, 1, 0.2], [1, 0.2, 1]])
    np.testing.assert_allclose(by_name.to("b", np.ones(3)), [0.2, 1.0, 0.2])
    np.testing.assert_allclose(by_name.to(None, np.ones(3)), by_name.among.mean(axis=0))
    np.testing.assert_allclose(by_name.to(None, np.array([0, 1.0, 0])), [0.2, 1, 0.2], atol=1e-8)
    numbers = [{"object_w": 1.0, "object_same": 5.0}, {"object_w": 3.0, "object_same": 5.0}]
    by_number = Likeness.of(("a", "b"), numbers, 0.2)
    assert by_number.numbers == ("object_w",)  # what does not vary tells nothing
    np.testing.assert_allclose(by_number.among[0], [1.0, 0.2 + 0.8 * np.exp(-2.0)])
    extra = {"object_w_m": "0.3", "object_colour": "red", "notes": "1", "object_nan": "nan"}
    assert object_numbers(extra) == {"object_w_m": 0.3}


def test_without_paths_there_is_nothing_to_ask() -> None:
    with pytest.raises(InputError, match="learn the recordings again"):
        PathPredictor.of([replace(CUPS[0], path=None)], SETTINGS)


def test_of_very_many_recordings_some_are_asked() -> None:
    many = PathPredictor.of(CUPS * 500, SETTINGS)
    assert len(many.paths) == 834
