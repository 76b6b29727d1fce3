"""Sets of recordings: parts of them, and equality by what they hold."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.joints import N_JOINTS
from handsim.recordings.folder import read_recordings, write_recordings
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import HandSize

NAMES = ("a", "b", "c", "d", "e")


def recording(name: str, seed: int = 0) -> Recording:
    q = np.random.default_rng(seed).uniform(-1.0, 1.0, (12, N_JOINTS))
    return Recording(
        name, np.arange(12) / 100, q, 14, "someone", "cube", "cube-raise", HandSize(0.19, 0.085)
    )


@pytest.fixture
def five() -> RecordingSet:
    return RecordingSet(tuple(recording(name, i) for i, name in enumerate(NAMES)))


def names(recordings: object) -> list[str]:
    assert isinstance(recordings, RecordingSet)
    return [each.name for each in recordings]


@pytest.mark.parametrize(
    "part",
    [slice(3), slice(1, 4), slice(-2, None), slice(None, None, -1), slice(0, 99), slice(None)],
)
def test_a_slice_is_a_set_of_the_same_recordings(five, part):
    assert names(five[part]) == list(NAMES[part])
    assert all(each in five.recordings for each in five[part])


@pytest.mark.parametrize("place", [0, 4, -1, -5, np.int64(2), np.array(3)])
def test_a_place_is_one_recording(five, place):
    assert five[place] is five.recordings[int(place)]


@pytest.mark.parametrize(
    ("chosen", "expected"),
    [
        ([0, 2], "ac"),
        ((4, -5), "ea"),
        (np.array([3, 1]), "db"),
        (np.array([2]), "c"),
        ([True, False, True, False, False], "ac"),
        (np.array([False, False, False, False, True]), "e"),
    ],
)
def test_places_and_bools_are_a_set(five, chosen, expected):
    assert names(five[chosen]) == list(expected)


@pytest.mark.parametrize("place", [5, -6, [0, 5], np.array([-6])])
def test_no_such_place(five, place):
    with pytest.raises(IndexError):
        five[place]


@pytest.mark.parametrize(
    ("chosen", "word"),
    [
        (slice(5, None), "0 recordings"),
        ([], "0 recordings"),
        ([False] * 5, "0 recordings"),
        ([True, False], "5 bools"),
        ([0, 0], "two recordings are named 'a'"),
        ("a", "whole numbers"),
        (1.5, "whole numbers"),
        ([0.0, 1.0], "whole numbers"),
        (np.zeros((2, 2), int), "whole numbers"),
    ],
)
def test_what_chooses_no_set_is_refused(five, chosen, word):
    with pytest.raises(InputError, match=word) as raised:
        five[chosen]
    assert "\n" not in str(raised.value)


def test_one_is_left_out_by_any_place(five):
    assert names(five.without(1)) == list("acde")
    assert names(five.without(-1)) == list("abcd")
    for place in (5, -6):
        with pytest.raises(IndexError):
            five.without(place)


def test_an_object_is_left_out_with_all_its_recordings(five):
    first, second, *others = five
    jars = RecordingSet((first, replace(second, object="jar"), *others))
    assert names(jars.without_object("cube")) == ["b"]
    assert names(jars.without_object("jar")) == ["a", "c", "d", "e"]
    with pytest.raises(InputError, match="no recordings are left without object 'jar'"):
        jars.without_object("cube").without_object("jar")


def test_recordings_are_equal_by_what_they_hold(five):
    one, same = five[0], recording("a", 0)
    assert one == same and hash(one) == hash(same)
    assert one is not same and {one, same} == {one}
    for change in (
        {"name": "z"}, {"number": 15}, {"subject": "x"}, {"object": "x"}, {"task": "x"},
        {"hand": HandSize(0.191, 0.085)}, {"hand": HandSize(0.19, 0.086)},
        {"time": one.time + 1e-9},
        {"q": one.q + 1e-12}, {"time": one.time[:11], "q": one.q[:11]},
    ):  # fmt: skip
        other = replace(one, **change)
        assert one != other, change
        assert hash(one) != hash(other), change
    assert one != "a"


def test_minus_nothing_is_nothing():
    plus, minus = (replace(recording("a"), q=np.full((12, N_JOINTS), zero)) for zero in (0.0, -0.0))
    assert plus == minus and hash(plus) == hash(minus)


def test_sets_are_equal_by_what_they_hold(five, tmp_path):
    same = RecordingSet(tuple(recording(name, i) for i, name in enumerate(NAMES)))
    assert five == same and hash(five) == hash(same)
    assert five[:3] == same[:3] != same[1:4]
    assert five != five[::-1]
    write_recordings(five, tmp_path / "R")
    assert read_recordings(tmp_path / "R") == read_recordings(tmp_path / "R")
