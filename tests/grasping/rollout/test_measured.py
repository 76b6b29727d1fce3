"""What is measured at a reading, and when the glove is asked for it."""

import numpy as np
import pytest

from handsim.grasping.rollout import jobs
from handsim.grasping.rollout.forearm import WRIST_COLUMNS
from handsim.grasping.rollout.glove import DataGlove, Measured
from handsim.grasping.rollout.jobs import GripLayer, Sensors
from handsim.joints import FINGERS

from .short_runs import made_with

INDEX, THUMB = FINGERS.index("index"), FINGERS.index("thumb")
REST = np.delete(np.arange(22), WRIST_COLUMNS)
"""All joints but the wrist's, which an arm moves."""


def measured(first: float, *, wrist: bool = True) -> Measured:
    """What is measured of three runs: numbers that differ everywhere, from ``first`` on."""
    q, noise = first + np.arange(132.0).reshape(2, 3, 22)
    said = first + 0.5 + np.arange(6.0).reshape(3, 2) if wrist else None
    return Measured(q, noise, said, [[first + i] * 5 for i in range(3)])


@pytest.mark.parametrize("wrist", [True, False])
def test_where_a_reading_is_lost_posture_noise_and_wrist_are_those_before(wrist):
    """And forces are those of now: they are not the glove's."""
    before, now = measured(1000.0, wrist=wrist), measured(0.0, wrist=wrist)
    lost = np.array([False, True, False])
    found = now.without(lost, before)
    for name in ("q", "noise", "wrist") if wrist else ("q", "noise"):
        values = getattr(found, name)
        np.testing.assert_array_equal(values[1], getattr(before, name)[1], err_msg=name)
        np.testing.assert_array_equal(values[[0, 2]], getattr(now, name)[[0, 2]], err_msg=name)
    assert (found.wrist is None) is not wrist
    assert found.forces == now.forces
    # What was measured stays as it is, for readings that come late.
    for each, first in ((before, 1000.0), (now, 0.0)):
        np.testing.assert_array_equal(each.q, measured(first).q)
        np.testing.assert_array_equal(each.noise, measured(first).noise)


def test_a_reading_that_is_lost_twice_is_the_last_that_came():
    lost, none = np.array([False, True, True]), np.zeros(3, dtype=bool)
    first, second = measured(0.0), measured(1000.0)
    again = measured(2000.0).without(lost, second.without(lost, first))
    np.testing.assert_array_equal(again.q[1:], first.q[1:])
    np.testing.assert_array_equal(again.q[0], measured(2000.0).q[0])
    for ours, theirs in zip(second.without(none, first)[:3], second[:3], strict=True):
        np.testing.assert_array_equal(ours, theirs)


def asked_of_the_glove(monkeypatch, touches: dict[int, int], **values):
    """Make a run whose fingers touch at some readings, {tick: finger}.

    Returns the run, the number of readings that the glove was asked for by each reading, (61,),
    and by reading what the grip layer kept as the posture at a touch.
    """
    times, kept, read = [], {}, DataGlove.reading
    forces = [[0.0] * 5 for _ in range(61)]
    for tick, finger in touches.items():
        for row in forces[tick:]:
            row[finger] = 1.0
    ticks = iter(forces)

    def reading(self, q, disturbance):
        times.append(len(counts) - 1)
        return read(self, q, disturbance)

    def measure(self, tick):
        counts.append(tick)
        usual(self, tick)

    def touch(self, q):
        kept[counts[-1]] = q[0].copy()
        usual_touch(self, q)

    counts: list[int] = []
    usual, usual_touch = jobs.Group.measure, GripLayer.touch
    monkeypatch.setattr(jobs.Group, "measure", measure)
    monkeypatch.setattr(GripLayer, "touch", touch)
    monkeypatch.setattr(DataGlove, "reading", reading)
    monkeypatch.setattr(Sensors, "finger_forces", lambda self, values: [next(ticks)])
    made = made_with(**values)
    assert counts == list(range(61))
    times.remove(60)  # that of the record, of all readings at once
    return made, np.bincount(times, minlength=61), kept


@pytest.mark.parametrize(("base", "first"), [("free", 1), ("arm", 2)])
def test_after_the_reach_the_glove_is_asked_only_where_a_finger_touches(monkeypatch, base, first):
    """Once at each of the reach's six readings; of an arm's wrist once more at the beginning."""
    touches = {12: INDEX, 30: THUMB}
    made, asked, kept = asked_of_the_glove(monkeypatch, touches, seed=6, base=base)
    assert len(made.driver.asked) == 6
    assert asked[:6].tolist() == [first, 1, 1, 1, 1, 1]
    assert np.flatnonzero(asked[6:]).tolist() == [12 - 6, 30 - 6]
    assert asked[6:].sum() == 2
    assert list(kept) == [12, 30]
    for tick, q in kept.items():
        np.testing.assert_array_equal(q[REST], made.run.reading[tick, REST])


def test_where_nothing_touches_the_glove_is_never_asked_after_the_reach(monkeypatch):
    _, asked, kept = asked_of_the_glove(monkeypatch, {}, seed=6, base="free")
    assert asked.tolist() == [1] * 6 + [0] * 55
    assert kept == {}


def test_a_touch_in_the_reach_is_where_the_hand_was_read(monkeypatch):
    made, asked, kept = asked_of_the_glove(monkeypatch, {3: INDEX}, seed=6, base="free")
    assert asked[:6].tolist() == [1, 1, 1, 2, 1, 1] and not asked[6:].any()
    np.testing.assert_array_equal(kept[3], made.run.reading[3])


def test_a_late_glove_feels_late_and_tells_where_the_hand_was(monkeypatch):
    made, asked, kept = asked_of_the_glove(
        monkeypatch, {12: INDEX}, seed=6, base="free", latency=0.03
    )
    assert np.flatnonzero(asked[6:]).tolist() == [15 - 6]
    np.testing.assert_array_equal(kept[15], made.run.reading[12])


def test_a_touch_while_readings_are_lost_is_where_the_hand_was_read_last(monkeypatch):
    lost = made_with(seed=7, base="free", lost=0.5).commands.lost
    tick = next(i for i in range(10, 60) if lost[i] and lost[i - 1] and not lost[i - 2])
    made, _, kept = asked_of_the_glove(monkeypatch, {tick: INDEX}, seed=7, base="free", lost=0.5)
    np.testing.assert_array_equal(kept[tick], made.run.reading[tick - 2])
