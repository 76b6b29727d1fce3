"""Digests of content: the last bits do not count, what can be noticed does."""

from dataclasses import dataclass

import numpy as np
import pytest

from handsim.digests import content_digest, rounded

CHOSEN = np.concatenate(
    [
        np.array([0.0, 0.1, 0.25, 0.5, 0.81, 1.0, 2.0, 3.0, 0.0000125, 1234.5, 1e-5, 9.81]),
        np.arange(1, 2000) / 2**20,  # half-way between numbers of so many bits
        np.arange(1, 2000) / 2e6,  # half-way between numbers of so many digits
        2.0 ** np.arange(-20, 20),
    ]
)
"""Numbers as people and formulas choose them, the next to which may be computed instead."""


@pytest.mark.parametrize("factor", [1 + 1e-14, 1 - 1e-14])
def test_noise_is_gone_wherever_a_number_lies(factor):
    for part in np.array_split(CHOSEN, 40):
        np.testing.assert_array_equal(rounded(part * factor), rounded(part))
    for number in CHOSEN[::11]:
        assert rounded(number * factor) == rounded(number)


def test_what_should_be_nothing_is_nothing():
    exact = np.array([0.3, 0.0, -0.0])
    np.testing.assert_array_equal(rounded(exact + [0.0, 1e-17, -1e-17]), rounded(exact))
    assert content_digest(0.0) == content_digest(-0.0)


def test_steps_are_as_fine_as_they_say():
    generator = np.random.default_rng(0)
    numbers = generator.uniform(-1, 1, 1000) * 10.0 ** generator.integers(-2, 3, 1000)
    each = np.array([float(rounded(number)) for number in numbers])
    assert np.abs(each / numbers - 1).max() < 2.4e-6
    for change in (1 + 2.4e-6, 1 - 2.4e-6):
        assert all(rounded(number * change) != rounded(number) for number in numbers)
    small = np.array([1000.0, 4e-6])
    assert rounded(small)[1] != rounded(small * [1, 2])[1]
    assert rounded(small * [1, 1e-3])[1] == 0.0


def test_what_is_no_number_stays():
    np.testing.assert_array_equal(
        rounded([np.inf, -np.inf, np.nan, 0.5]), [np.inf, -np.inf, np.nan, 0.5]
    )
    assert rounded(np.zeros((0, 3))).shape == (0, 3)


@dataclass(frozen=True)
class Thing:
    size: tuple[float, ...]
    name: str | None = None


def test_content_is_told_apart_by_kind_shape_and_order():
    different = [
        (), None, "None", "", 0.0, 1.0, True, (1.0,), (1.0, 2.0), (2.0, 1.0), (1.0, (2.0,)),
        ((1.0,), (2.0,)), "1.0", {"a": 1.0}, {"b": 1.0}, {"a": 1.0, "b": 1.0}, Thing((1.0,)),
        Thing((1.0,), "x"), Thing((), "x"), ("a", "b"), ("ab",), np.zeros(3), np.zeros((3, 1)),
    ]  # fmt: skip
    digests = [content_digest(each) for each in different]
    assert len(set(digests)) == len(digests)
    assert all(len(digest) == 16 for digest in digests)
    assert content_digest("a", "b") != content_digest("ab")


def test_the_same_numbers_in_another_guise_are_the_same():
    assert content_digest((1, 2)) == content_digest([1.0, 2.0]) == content_digest(np.arange(1, 3))
    assert content_digest(((1.0, 2.0), (3.0, 4.0))) == content_digest(np.arange(1, 5).reshape(2, 2))
    assert content_digest({"a": 1, "b": 2}) == content_digest({"b": 2, "a": 1})
    assert content_digest(Thing((1.0,))) == content_digest(Thing((1.0 + 1e-15,)))


def test_digests_stay_what_they_are():
    """Plans and tables hold them: whoever changes one has all of them made again."""
    assert content_digest(Thing((0.1, 2.0), "x"), np.eye(2)) == PINNED


PINNED = "cdcd81c1aa941c46"
