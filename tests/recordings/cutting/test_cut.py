"""Recordings made of reaches: what they hold, what they are called, what they carry along."""

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.recordings.cutting.cut import Cut, cut_recordings
from handsim.recordings.cutting.find import WHOLE
from handsim.recordings.cutting.reach import CutOptions, Reach
from handsim.recordings.cutting.times import GivenReach
from handsim.recordings.recording import Recording, RecordingSet

ONE = ((0, 1.5), (1, 1.2), (1, 1.5), (0, 0.5), (0, 1.5))
UNDECIDED = ((0, 1.5), (0.5, 0.7), (0.5, 1.8), (1, 0.7), (1, 1.8), (0, 0.5), (0, 1.5))


def given(name: str, start: float, end: float, **words: str) -> GivenReach:
    return GivenReach(Reach(name, start, end, end, 1.0, "by hand"), **words)


def test_each_reach_becomes_a_recording(stream) -> None:
    two = stream(*ONE, *ONE[1:], name="b", session="monday", extra={"room": "7"}, notes=("x",))
    cut = cut_recordings(RecordingSet((stream(*ONE), two)))
    assert [r.name for r in cut.recordings] == ["a-01", "b-01", "b-02"]
    assert [r.number for r in cut.recordings] == [1, 2, 3]
    assert len(cut.reaches) == 3 and cut.doubtful == ()
    last, reach = cut.recordings[2], cut.reaches[2]
    assert last.session == "monday" and last.extra == {"room": "7"} and last.task == "cup-drink"
    assert last.notes[0] == "x"
    assert last.notes[1] == f"cut from {reach.start_s:.2f} to {reach.end_s:.2f} s of b"
    assert "low-passed at 3 Hz" in last.notes[2]
    np.testing.assert_allclose(last.time, np.arange(len(last.time)) / 100)
    assert last.duration == pytest.approx(reach.end_s - reach.start_s, abs=1e-9)
    frames = np.round((last.time + reach.start_s) * 100).astype(int)
    assert np.abs(np.rad2deg(last.q - two.q[frames])).max() < 2  # noise of 0.2 deg, and the filter


def test_channels_are_carried_along_and_stay_missing_where_they_were(stream) -> None:
    def slow_ramp(share: np.ndarray) -> np.ndarray:
        ramp = np.arange(len(share)) / 100
        ramp[200:240] = np.nan
        ramp[180] = np.nan
        return ramp

    channels = {"emg_01": slow_ramp}
    fast = stream(*ONE, channels=channels)
    part = cut_recordings(RecordingSet((fast,))).recordings[0]
    start = float(part.notes[0].split()[2])
    missing = np.isnan(part.channels["emg_01"])
    assert missing.sum() == 40 and not missing[round(180 - 100 * start)]
    np.testing.assert_allclose(
        part.channels["emg_01"][~missing], (part.time + start)[~missing], atol=1e-9
    )


def test_other_rates_come_out_at_100_hz(stream) -> None:
    one = stream(*ONE, noise_deg=0.0)
    time = np.sort(np.random.default_rng(0).uniform(0, one.time[-1], 4000))
    q = np.column_stack([np.interp(time, one.time, column) for column in one.q.T])
    sign = np.where(np.arange(4000) % 2, -1.0, 1.0)  # a quaternion and its negative are one turn
    uneven = Recording(
        "u", time, q, 1, "s", "o", "t", one.hand, channels={"palm_qw": sign, "emg_01": sign}
    )
    part = cut_recordings(RecordingSet((uneven,))).recordings[0]
    np.testing.assert_allclose(np.diff(part.time), 0.01)
    assert part.duration == pytest.approx(1.1, abs=0.1)
    assert set(part.channels["palm_qw"]) == {-1.0, 1.0}
    assert len(set(part.channels["emg_01"])) > 50


def test_a_single_reach_stays_whole_and_says_so(stream) -> None:
    reach = stream((0, 0.02), (1, 1.2), (1, 0.1))
    part = cut_recordings(RecordingSet((reach,))).recordings[0]
    assert len(part.time) == len(reach.time)
    assert part.notes[-1] == WHOLE


def test_times_given_by_hand_are_kept_to(stream) -> None:
    both = RecordingSet((stream(*UNDECIDED), stream(*ONE, name="b")))
    cut = cut_recordings(both, times=[given("a", 1.5, 4.7, object="jar"), given("a", 0.1, 0.4)])
    assert [r.name for r in cut.recordings] == ["a-01", "a-02", "b-01"]
    assert [r.duration for r in cut.recordings[:2]] == pytest.approx([0.3, 3.2])
    assert [r.object for r in cut.recordings] == ["cup", "jar", "cup"]


def test_doubtful_ones_are_listed_and_not_cut(stream) -> None:
    cut = cut_recordings(RecordingSet((stream(*UNDECIDED), stream(*ONE, name="b"))))
    assert [r.name for r in cut.recordings] == ["b-01"]
    assert [r.recording for r in cut.doubtful] == ["a"]
    assert isinstance(cut, Cut)


def test_nothing_certain_is_an_error_that_says_what_to_do(stream) -> None:
    with pytest.raises(InputError, match=r"a from .* or from .*--times"):
        cut_recordings(RecordingSet((stream(*UNDECIDED),)))
    with pytest.raises(InputError, match=r"no reach in 1 recording:.*--times"):
        cut_recordings(RecordingSet((stream((0, 3.0)),)))
    short = Recording("s", np.arange(10) / 1e4, np.zeros((10, 22)), 1, "s", "o", "t",
                      stream(*ONE).hand)  # fmt: skip
    with pytest.raises(InputError, match=r"recording 's': it lasts 0\.0009 s"):
        cut_recordings(RecordingSet((short,)), CutOptions())


def test_progress_is_told(stream) -> None:
    seen: list[float] = []
    cut_recordings(RecordingSet((stream(*ONE), stream(*ONE, name="b"))), progress=seen.append)
    assert seen == [0.5, 1.0]
