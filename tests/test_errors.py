"""What an unknown name is answered with."""

import pickle

import pytest

from handsim.errors import UnknownNameError
from handsim.joints import FINGERS, JOINT_NAMES


@pytest.mark.parametrize(
    ("known", "asked", "near"),
    [
        (FINGERS, "pinky", "little"),
        (FINGERS, "Pinkie", "little"),
        (FINGERS, "forefinger", "index"),
        (FINGERS, "thum", "thumb"),
        (JOINT_NAMES, "pinky_mcp", "little_mcp"),
        (("small-cup", "little-cake"), "small-cups", "small-cup"),
        (("a", "b"), "pinky", "a, b"),  # nothing is like it
    ],
)
def test_the_nearest_names_are_offered(known, asked, near):
    said = str(UnknownNameError("finger", asked, known))
    assert said == f"unknown finger '{asked}'; did you mean {near}?"


def test_where_names_are_listed_is_said_in_other_processes_too():
    error = UnknownNameError("task", "cube-rase", ("cube-raise",), "handsim tasks")
    said = "unknown task 'cube-rase'; did you mean cube-raise? `handsim tasks` lists all"
    assert str(error) == str(pickle.loads(pickle.dumps(error))) == said
