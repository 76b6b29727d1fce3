"""What a run may be made with, and what a perturbed trial varies."""

from dataclasses import fields, replace

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.grasping.conditions import (
    LIMITS,
    MAX_OFFSET,
    Conditions,
    Perturbation,
    made_hard,
    perturb,
)
from handsim.types import HandSize


def test_a_run_is_nominal_by_default():
    """A median right hand, rubber-like skin (0.8), the object as it is and where it should be."""
    assert Conditions() == Conditions(
        seed=0, nominal=True, hand=HandSize(0.1933, 0.0883, "right"), friction=0.8,
        base="arm", mass_scale=1.0, object_offset=(0.0, 0.0, 0.0), shake=0.0,
        bias=0.0, drift=0.0, latency=0.0, lost=0.0,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("seed", 0, 2**63 - 1),
        ("friction", 0.05, 3.0),
        ("mass_scale", 1e-3, 1e3),
        ("shake", 0.0, 100.0),
        ("bias", 0.0, np.pi),
        ("drift", 0.0, np.pi),
        ("latency", 0.0, 1.0),
        ("lost", 0.0, 0.99),
    ],
)
def test_what_is_simulated_ends_at_its_limits(name, low, high):
    """The limits themselves are simulated, what lies next beyond is not, nor is what is no number.

    Seeds are whole numbers that a 64-bit integer holds.
    """
    assert name in LIMITS
    for value in (low, high):
        assert getattr(Conditions(**{name: value}), name) == value
    whole = name == "seed"
    below, above = (low - 1, high + 1) if whole else np.nextafter((low, high), (-np.inf, np.inf))
    for value in (below, above, np.nan, np.inf, -np.inf):
        with pytest.raises(InputError, match=f"{name} of .* is outside"):
            Conditions(**{name: value})


@pytest.mark.parametrize("place", range(3))
def test_offsets_end_at_half_a_turn_and_a_little_to_both_sides(place):
    assert np.pi < MAX_OFFSET < 3.3
    for sign in (-1, 1):
        offset = [0.0, 0.0, 0.0]
        offset[place] = sign * MAX_OFFSET
        assert Conditions(object_offset=tuple(offset)).object_offset[place] == offset[place]
        for bad in (sign * np.nextafter(MAX_OFFSET, np.inf), np.nan, sign * np.inf):
            offset[place] = bad
            with pytest.raises(InputError, match="object_offset"):
                Conditions(object_offset=tuple(offset))


def test_all_that_has_limits_is_tried():
    assert set(LIMITS) == {
        *("seed", "friction", "mass_scale", "shake"),
        *("bias", "drift", "latency", "lost"),
    }


@pytest.mark.parametrize("base", ["Arm", "", "robot", None])
def test_hands_are_carried_by_an_arm_or_freely(base):
    assert Conditions(base="free").base == "free"
    with pytest.raises(InputError, match=r"base .* is unknown; give 'arm', 'free' or 'mounted'"):
        Conditions(base=base)


def test_conditions_stand_in_files_by_name():
    given = Conditions(
        seed=3, nominal=False, hand=HandSize(0.18, 0.08, "left"), base="free", friction=0.5,
        mass_scale=1.1, object_offset=(0.1, 0.2, 0.3), shake=2.0, bias=0.05, drift=0.01,
        latency=0.02, lost=0.1,
    )  # fmt: skip
    assert given.as_dict() == {
        "seed": 3, "nominal": False, "hand_length": 0.18, "hand_breadth": 0.08, "side": "left",
        "base": "free", "friction": 0.5, "mass_scale": 1.1, "object_offset": (0.1, 0.2, 0.3),
        "shake": 2.0, "bias": 0.05, "drift": 0.01, "latency": 0.02, "lost": 0.1,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("name", "changed"),
    [
        ("friction", {"friction": 0.3}),
        ("mass", {"mass_scale": 2.0}),
        ("shake", {"shake": 5.0}),
        ("bias", {"bias": np.deg2rad(3.0)}),
        ("latency", {"latency": 0.05}),
    ],
)
def test_a_hard_trial_is_hard_in_one_thing_and_nominal_in_all_others(name, changed):
    given = Conditions(seed=3, hand=HandSize(side="left"), base="free")
    expected = replace(given, seed=8, nominal=False, **changed)
    assert made_hard(given, 8, name) == expected


def test_a_trial_with_a_hard_pose_has_its_object_up_to_a_centimetre_and_10_deg_off():
    given = Conditions(seed=3, friction=0.6)
    trials = [made_hard(given, seed, "pose") for seed in range(100)]
    offsets = np.array([trial.object_offset for trial in trials])
    most = np.abs(offsets).max(axis=0)
    assert (most <= [0.01, 0.01, np.deg2rad(10.0)]).all()
    assert (most > 0.9 * np.array([0.01, 0.01, np.deg2rad(10.0)])).all()
    for seed, trial in enumerate(trials):
        expected = replace(given, seed=seed, nominal=False, object_offset=trial.object_offset)
        assert trial == expected
    assert made_hard(given, 4, "pose") == trials[4]


def test_hands_that_nobody_has_are_refused():
    for size in (HandSize(0.5), HandSize(breadth=0.2), HandSize(np.nan)):
        with pytest.raises(InputError):
            Conditions(hand=size)


def test_a_perturbed_trial_is_drawn_as_it_was_published():
    """Five uniform draws in a fixed order: x, y, yaw, friction, mass."""
    for seed in (0, 7):
        u = np.random.default_rng(seed).random(5)
        mixed = 2 * u - 1
        trial = perturb(Conditions(), seed)
        assert trial.seed == seed
        np.testing.assert_allclose(trial.object_offset[:2], 0.003 * mixed[:2])
        assert trial.object_offset[2] == pytest.approx(np.deg2rad(3.0) * mixed[2])
        assert trial.friction == pytest.approx(0.5 + 0.3 * u[3])
        assert trial.mass_scale == pytest.approx(1 + 0.2 * mixed[4])
        assert (trial.shake, trial.bias) == (2.0, 0.0)
        assert not trial.nominal
        assert trial == perturb(Conditions(), seed)
        assert trial != perturb(Conditions(), seed + 1)


def test_a_perturbed_trial_keeps_the_hand():
    left = Conditions(
        hand=HandSize(0.17, 0.08, "left"), seed=3, base="free", bias=0.05, drift=0.01,
        latency=0.02, lost=0.1,
    )  # fmt: skip
    trial = perturb(left, 5)
    assert trial.hand == left.hand
    varied = {
        field.name
        for field in fields(left)
        if getattr(trial, field.name) != getattr(left, field.name)
    }
    assert varied == {"seed", "nominal", "friction", "mass_scale", "object_offset", "shake"}


@pytest.mark.parametrize(
    ("given", "asked", "expected"),
    [(0.0, 0.0, 0.0), (0.05, 0.0, 0.05), (0.0, 0.02, 0.02), (0.05, 0.02, 0.05), (3.14, 0.1, 3.14)],
)
def test_a_perturbed_glove_is_off_by_its_ranges_or_by_what_it_was_before(given, asked, expected):
    """A trial with a glove that is off keeps it, and is drawn as others are."""
    trial = perturb(Conditions(bias=given), 5, Perturbation(bias=asked))
    assert trial.bias == expected
    assert replace(trial, bias=0.0) == perturb(Conditions(), 5)


def test_other_ranges_are_taken_where_they_are_given():
    still = Perturbation(position=0.0, yaw=0.0, friction=(0.4, 0.4), mass=0.0, shake=0.0)
    assert perturb(Conditions(), 1, still) == replace(
        Conditions(), seed=1, nominal=False, friction=0.4
    )
    wide = Perturbation(position=0.1, yaw=1.0, friction=(1.0, 2.0), mass=0.9, shake=7.0)
    trials = [perturb(Conditions(), seed, wide) for seed in range(200)]
    for values, low, high in (
        ([t.object_offset[0] for t in trials], -0.1, 0.1),
        ([t.object_offset[1] for t in trials], -0.1, 0.1),
        ([t.object_offset[2] for t in trials], -1.0, 1.0),
        ([t.friction for t in trials], 1.0, 2.0),
        ([t.mass_scale for t in trials], 0.1, 1.9),
    ):
        # The least and the most of 200 uniform draws lie near the ends.
        assert low <= min(values) < low + 0.05 * (high - low)
        assert high - 0.05 * (high - low) < max(values) <= high
    assert {t.shake for t in trials} == {7.0}
