"""Where reaches begin and end, how sure that is, and when no choice is made."""

import numpy as np
import pytest

from handsim.errors import InputError, UnknownNameError
from handsim.recordings.cutting.find import WHOLE, find_reaches
from handsim.recordings.cutting.reach import CutOptions
from handsim.recordings.cutting.readings import pause_probability
from handsim.recordings.phases import low_pass
from handsim.recordings.recording import Recording

DEFAULT = CutOptions()


def smooth(n: int) -> np.ndarray:
    x = np.linspace(0, 1, n)
    return x**3 * (10 - 15 * x + 6 * x**2)


REST, GO, HOLD, BACK = (0, 1.5), (1, 1.2), (1, 1.5), (0, 0.5)
ONE = (REST, GO, HOLD, BACK, REST)


def test_a_reach_is_found_where_it_is_in_spite_of_a_fast_return(stream) -> None:
    found = find_reaches(stream(*ONE), DEFAULT)
    assert len(found) == 1
    assert found[0].start_s == pytest.approx(1.5, abs=0.12)
    assert found[0].end_s == pytest.approx(2.7, abs=0.12)
    assert found[0].hold_end_s == pytest.approx(4.2, abs=0.12)
    assert found[0].confidence > 0.95 and found[0].second is None


def test_every_reach_of_a_stream_is_found(stream) -> None:
    found = find_reaches(stream(*ONE, *ONE[1:], *ONE[1:]), DEFAULT)
    assert [round(r.start_s, 0) for r in found] == [2.0, 6.0, 11.0]
    np.testing.assert_allclose([r.end_s - r.start_s for r in found], 1.1, atol=0.15)
    assert all(reach.certain for reach in found)


def test_a_short_pause_half_way_is_part_of_the_reach(stream) -> None:
    found = find_reaches(stream(REST, (0.5, 0.7), (0.5, 0.4), (1, 0.7), HOLD, BACK, REST), DEFAULT)
    assert len(found) == 1 and found[0].certain
    assert found[0].start_s == pytest.approx(1.5, abs=0.12)
    assert found[0].end_s == pytest.approx(3.3, abs=0.12)
    assert "pauses" in found[0].reason
    assert found[0].second is not None and found[0].second[1] == pytest.approx(2.2, abs=0.15)


def test_two_stops_alike_are_not_decided(stream) -> None:
    legs = (REST, (0.5, 0.7), (0.5, 1.8), (1, 0.7), (1, 1.8), BACK, REST)
    found = find_reaches(stream(*legs), DEFAULT)
    assert len(found) == 1 and not found[0].certain
    assert found[0].second is not None
    ends = sorted([found[0].end_s, found[0].second[1]])
    assert ends == pytest.approx([2.2, 4.7], abs=0.15)
    patient = find_reaches(stream(*legs), CutOptions(longest_pause_s=4.0))
    assert patient[0].certain and patient[0].end_s == pytest.approx(4.7, abs=0.12)


def test_the_option_decides_that_a_stop_ends_the_reach(stream) -> None:
    legs = (REST, (0.8, 0.9), (0.8, 1.5), (1, 0.4), (1, 0.3), BACK, REST)
    found = find_reaches(stream(*legs), CutOptions(longest_pause_s=0.1))
    assert found[0].certain and found[0].end_s == pytest.approx(2.4, abs=0.12)
    assert "moves on" in found[0].reason


def test_probability_of_a_pause() -> None:
    def half_way(pause: float, hold: float, onward: float = 0.5, *, arrived: bool = False) -> float:
        return pause_probability(pause, hold, onward, DEFAULT, arrived=arrived)

    assert half_way(0.2, 1.5) > 0.97
    assert half_way(1.0, 1.0) == pytest.approx(1 / (1 + np.exp(-0.8)))
    assert half_way(2.0, 0.4) < 0.3
    assert half_way(0.5, 1.0, 0.1) < half_way(0.5, 1.0, 0.6)
    assert half_way(0.5, 1.0, arrived=True) < half_way(0.5, 1.0)


def test_a_return_that_pauses_is_no_reach(stream) -> None:
    legs = (REST, GO, HOLD, (0.4, 0.6), (0.4, 0.3), (0, 0.5), REST)
    found = find_reaches(stream(*legs, *legs[1:]), DEFAULT)
    assert len(found) == 2
    assert [r.end_s for r in found] == pytest.approx([2.7, 8.3], abs=0.15)


def test_fidgets_are_no_reaches_and_small_movements_are_doubted(stream) -> None:
    fidget = ((0.15, 0.4), (0.15, 0.5), (0, 0.4), REST)
    found = find_reaches(stream(*ONE, *fidget, *ONE[1:]), DEFAULT)
    assert len(found) == 2
    settled = (REST, (0.07, 0.15), (0.07, 3.0), GO, HOLD, BACK, REST)
    found = find_reaches(stream(*settled), DEFAULT)
    assert len(found) == 1 and found[0].certain
    assert found[0].start_s == pytest.approx(4.65, abs=0.12)
    half = ((0.38, 0.6), (0.38, 1.0), (0, 0.6), REST)
    found = find_reaches(stream(*ONE, *half, *ONE[1:]), DEFAULT)
    assert [reach.certain for reach in found] == [True, False, True]
    assert "small" in found[1].reason


def test_a_hand_that_opens_wide_and_closes_has_grasped_when_it_stops(stream) -> None:
    found = find_reaches(stream(REST, (1, 0.8), (0.7, 0.5), (0.7, 1.5), BACK, REST), DEFAULT)
    assert len(found) == 1
    assert found[0].end_s == pytest.approx(2.8, abs=0.15)


def test_opening_and_closing_without_a_stop_is_not_decided(stream) -> None:
    legs = (REST, (1, 0.8), (0.1, 0.8), (0.1, 1.5))
    found = find_reaches(stream(*legs), DEFAULT)
    assert [reach.certain for reach in found] == [False]
    assert found[0].end_s == pytest.approx(2.3, abs=0.15)
    assert found[0].second is not None and found[0].second[1] == pytest.approx(3.1, abs=0.15)
    assert find_reaches(stream(*legs, channels=PALM), DEFAULT)[0].certain  # a palm that goes back


def test_a_recording_that_is_one_reach_comes_back_whole(stream) -> None:
    reach = stream((0, 0.02), GO, (1, 0.1))
    found = find_reaches(reach, DEFAULT)
    assert [(r.start_s, r.end_s) for r in found] == [(0, reach.time[-1])]
    assert found[0].reason == WHOLE and found[0].certain
    assert find_reaches(stream(REST, GO, HOLD), DEFAULT)[0].reason != WHOLE
    there_and_back = stream((0, 0.02), GO, (0.1, 1.2))
    assert all(each.reason != WHOLE for each in find_reaches(there_and_back, DEFAULT))


def test_nothing_is_found_where_the_hand_rests(stream) -> None:
    assert find_reaches(stream((0, 5.0)), DEFAULT) == ()
    assert find_reaches(stream((0, 5.0), noise_deg=0.0), DEFAULT) == ()
    tiny = stream(*ONE)
    small = Recording("b", tiny.time, tiny.q / 57.3, 1, "s", "o", "t", tiny.hand)
    assert find_reaches(small, DEFAULT) == ()  # radians taken for degrees


def test_noise_does_not_move_the_ends(stream) -> None:
    for seed in range(5):
        found = find_reaches(stream(*ONE, noise_deg=1.0, seed=seed), DEFAULT)
        assert len(found) == 1 and found[0].certain
        assert found[0].start_s == pytest.approx(1.5, abs=0.2)
        assert found[0].end_s == pytest.approx(2.7, abs=0.2)


PALM = {
    "palm_x_m": lambda share: 0.3 * share,
    "palm_y_m": lambda share: 0 * share,
    "palm_z_m": lambda share: 0.4 * share,
}
BACK_AND_FORTH = ((0, 0.5), *(((1, 1.0), (1, 0.4), (0, 1.0)) * 4), (0, 0.3))


def test_the_palm_is_followed_where_it_moves_and_turns_without_a_stop(stream) -> None:
    found = find_reaches(stream(*BACK_AND_FORTH, channels=PALM), DEFAULT)
    assert [r.certain for r in found] == [True] * 4
    # A fifth of the peak of a minimum-jerk movement is passed at 0.129 and 0.871 of it.
    assert found[1].start_s == pytest.approx(2.9 + 0.129, abs=0.04)
    assert found[1].end_s == pytest.approx(2.9 + 0.871, abs=0.04)
    assert found[1].hold_end_s == pytest.approx(2.9 + 1.4, abs=0.2)


def test_turns_on_a_curve_are_found(stream) -> None:
    """On an ellipse the palm is nowhere slower than 0.3 of its peak, and never stops."""

    def turning(share: np.ndarray) -> np.ndarray:
        return 2 * np.pi * np.clip(np.arange(len(share)) / 100 - 1.0, 0, 8.0) / 2.0

    ellipse = {
        "palm_x_m": lambda share: 0.15 * (1 - np.cos(turning(share))),
        "palm_y_m": lambda share: 0.05 * np.sin(turning(share)),
        "palm_z_m": lambda share: 0 * share,
    }
    found = find_reaches(stream((0, 10.0), channels=ellipse), DEFAULT)
    assert [r.start_s for r in found] == pytest.approx([1, 3, 5, 7], abs=0.2)
    assert [r.end_s for r in found] == pytest.approx([2, 4, 6, 8], abs=0.2)


def test_a_hand_that_wanders_is_doubted(stream) -> None:
    walk = low_pass(np.cumsum(np.random.default_rng(1).normal(size=(1500, 22)), axis=0), 100, 1.0)
    ramp = np.linspace(0, 1, 1500)[:, None]
    q = 0.02 * walk / np.abs(walk).max() + 0.02 * ramp + 0.1 * np.sin(20 * ramp * np.arange(1, 23))
    one = Recording("w", np.arange(1500) / 100, q, 1, "s", "o", "t", stream(*ONE).hand)
    found = find_reaches(one, DEFAULT)
    assert len(found) == 1 and not found[0].certain
    assert "wanders" in found[0].reason


def test_a_palm_that_is_lost_on_the_way_makes_a_reach_doubtful(stream) -> None:
    def gap(share: np.ndarray) -> np.ndarray:
        lost = 0.3 * share
        lost[320:370] = np.nan
        return lost

    found = find_reaches(stream(*BACK_AND_FORTH, channels={**PALM, "palm_x_m": gap}), DEFAULT)
    assert [r.certain for r in found] == [True, False, True, True]
    assert "lost" in found[1].reason


def test_a_palm_that_stays_where_it_is_is_not_followed(stream) -> None:
    still = {name: lambda share: 0.01 * share for name in PALM}
    found = find_reaches(stream(*ONE, channels=still), DEFAULT)
    assert len(found) == 1 and found[0].start_s == pytest.approx(1.5, abs=0.12)


def test_a_channel_ends_the_reach_where_it_first_moves(stream) -> None:
    def latch(share: np.ndarray) -> np.ndarray:
        turned = np.clip(np.arange(len(share)) / 100 - 2.2, 0, 0.5) * 2
        return turned + 0.05 * (np.arange(len(share)) > 690)  # trembles later

    door = stream(*ONE, *ONE[1:], channels={"latch_rad": latch})
    found = find_reaches(door, CutOptions(channel="latch_rad"))
    assert len(found) == 1 and found[0].certain
    assert found[0].end_s == pytest.approx(2.2, abs=0.03)
    assert found[0].start_s == pytest.approx(1.5, abs=0.12)
    with pytest.raises(UnknownNameError, match="latch_rad"):
        find_reaches(door, CutOptions(channel="latch"))
    with pytest.raises(InputError, match="no channels"):
        find_reaches(stream(*ONE), CutOptions(channel="latch"))
    empty = stream(*ONE, channels={"latch_rad": lambda share: np.full(len(share), np.nan)})
    with pytest.raises(InputError, match="fewer than 2 values"):
        find_reaches(empty, CutOptions(channel="latch_rad"))


def test_a_channel_that_moves_again_ends_no_reach_unless_the_hand_was_back(stream) -> None:
    def twice(share: np.ndarray) -> np.ndarray:
        time = np.arange(len(share)) / 100
        return np.clip(time - 2.2, 0, 0.5) + np.clip(time - 6.2, 0, 0.5)

    for back, n in ((0.45, 1), (0.0, 2)):
        legs = (REST, GO, HOLD, (back, 0.5), (back, 1.0), GO, HOLD)
        door = stream(*legs, channels={"latch_rad": twice})
        assert len(find_reaches(door, CutOptions(channel="latch_rad"))) == n


def test_an_object_that_is_bumped_twice_is_reached_for_once(stream) -> None:
    def bumped(share: np.ndarray) -> np.ndarray:
        time = np.arange(len(share)) / 100
        return 0.01 * (np.clip(time - 2.1, 0, 0.05) + np.clip(time - 2.6, 0, 0.05)) / 0.05

    found = find_reaches(stream(*ONE, channels={**lifted(9.0), "object_x_m": bumped}), DEFAULT)
    assert len(found) == 1 and "object begins" in found[0].reason
    assert found[0].start_s == pytest.approx(1.5, abs=0.12)


def test_fingers_that_creep_at_first_are_kept(stream) -> None:
    creep = np.concatenate([np.zeros(300), np.linspace(0, 0.12, 200)])
    share = np.concatenate([creep, 0.12 + 0.88 * smooth(120), np.ones(200)])
    q = np.outer(share, np.full(22, 0.7))
    one = Recording("c", np.arange(len(q)) / 100, q, 1, "s", "o", "t", stream(*ONE).hand)
    found = find_reaches(one, DEFAULT)
    assert len(found) == 1
    assert 3.1 < found[0].start_s < 3.7  # where 3 % of the way are gone, at 3.5 s


def test_a_hand_that_is_busy_where_it_arrived_is_less_sure(stream) -> None:
    there = np.concatenate([np.zeros(150), smooth(120), np.ones(350)])
    aside = np.concatenate([np.zeros(262), smooth(80), 1 - smooth(80), np.zeros(198)])
    q = np.column_stack([np.outer(there, np.full(11, 0.7)), np.outer(aside, np.full(11, 0.4))])
    one = Recording("b", np.arange(620) / 100, q, 1, "s", "o", "t", stream(*ONE).hand)
    found = find_reaches(one, DEFAULT)
    assert [reach.confidence for reach in found] == [0.75]
    assert "slows down" in found[0].reason
    assert found[0].end_s == pytest.approx(4.15, abs=0.15)
    assert found[0].second is not None and found[0].second[1] == pytest.approx(2.6, abs=0.15)


def lifted(lift_s: float):
    return {
        "object_x_m": lambda share: 0 * share,
        "object_y_m": lambda share: 0 * share,
        "object_z_m": lambda share: np.clip(np.arange(len(share)) / 100 - lift_s, 0, 0.8) * 0.2,
    }


def test_an_object_says_which_stop_is_the_grasp(stream) -> None:
    legs = (REST, (0.5, 0.7), (0.5, 1.8), (1, 0.7), (1, 1.8), BACK, REST)
    for lift_s, end_s in ((4.8, 4.7), (2.5, 2.2)):
        found = find_reaches(stream(*legs, channels=lifted(lift_s)), DEFAULT)
        assert [reach.certain for reach in found] == [True]
        assert found[0].end_s == pytest.approx(end_s, abs=0.15)
        assert "object" in found[0].reason


def test_an_object_that_moves_when_the_hand_goes_back_was_grasped_before(stream) -> None:
    found = find_reaches(stream(*ONE, channels=lifted(4.35)), DEFAULT)
    assert [reach.certain for reach in found] == [True]
    assert found[0].end_s == pytest.approx(2.7, abs=0.15)
    assert found[0].hold_end_s == pytest.approx(4.2, abs=0.15)


def test_a_reach_that_moves_no_object_is_doubtful(stream) -> None:
    twice = stream(*ONE, *ONE[1:], channels=lifted(3.0))
    found = find_reaches(twice, DEFAULT)
    assert [reach.certain for reach in found] == [True, False]
    assert found[0].end_s == pytest.approx(2.7, abs=0.15)  # where it took hold, before it lifted
    assert found[1].reason == "the object did not move"


def test_labels_frame_the_reaches(stream) -> None:
    def phases(share: np.ndarray) -> np.ndarray:
        time = np.arange(len(share)) / 100
        return np.select([time < 1.5, time < 2.7, time < 4.2, time < 4.7], [0, 1, 2, 3], 0)

    found = find_reaches(stream(*ONE, channels={"label": phases}), DEFAULT)
    assert [(r.start_s, r.end_s) for r in found] == [(1.5, pytest.approx(2.69))]

    def repetitions(share: np.ndarray) -> np.ndarray:
        time = np.arange(len(share)) / 100
        return np.select([(time > 1.0) & (time < 5.5)], [7.0], 0.0)

    found = find_reaches(stream(*ONE, *ONE[1:], channels={"label": repetitions}), DEFAULT)
    assert len(found) == 1  # the second reach has no label
    assert found[0].end_s == pytest.approx(2.7, abs=0.12)


def test_an_hour_of_milliseconds_is_no_reach(stream) -> None:
    one = stream((0, 0.02), GO, (1, 0.1))
    slow = Recording("b", one.time * 1000, one.q, 1, "s", "o", "t", one.hand)
    found = find_reaches(slow, DEFAULT)
    assert len(found) == 1 and not found[0].certain and "seconds" in found[0].reason
    endless = Recording("b", one.time * 1e6, one.q, 1, "s", "o", "t", one.hand)
    with pytest.raises(InputError, match="recording 'b': it lasts"):
        find_reaches(endless, DEFAULT)


def test_options_have_limits() -> None:
    for options in ({"rest_speed": 0.0}, {"rest_speed": 0.6}, {"longest_pause_s": -1.0},
                    {"longest_pause_s": float("nan")}):  # fmt: skip
        with pytest.raises(InputError, match="give"):
            CutOptions(**options)
