"""What is measured at a reading, and when the glove is asked for it."""

import numpy as np
import pytest

from handsim.grasping.rollout import jobs
from handsim.grasping.rollout.forearm import WRIST_COLUMNS
from handsim.grasping.rollout.glove import DataGlove, LateGloves
from handsim.grasping.rollout.jobs import GripLayer, Sensors
from handsim.joints import FINGERS

from .short_runs import made_with

INDEX, THUMB = FINGERS.index("index"), FINGERS.index("thumb")
REST = np.delete(np.arange(22), WRIST_COLUMNS)
"""All joints but the wrist's, which an arm moves."""


N, N_RUNS = 8, 3
AS_IT_IS = DataGlove(resolution=2.0**-20, noise=0.0)
"""Rounds the whole numbers of these tests to themselves."""


class Worn:
    """Late gloves of three runs, and what they are to read: numbers that differ everywhere."""

    def __init__(self, lost=(), delay: int = 0):
        self.q = 1000.0 * np.arange(N)[:, None, None] + np.arange(66.0).reshape(3, 22)
        self.noise, self.told = self.q + 100_000.0, self.q + 500.0
        missing = np.zeros((N, N_RUNS), dtype=bool)
        for tick, run in lost:
            missing[tick, run] = True
        self.qpos, past = np.zeros((2, N_RUNS, 25)), np.full((N, N_RUNS, 25), np.nan)
        self.qpos, self.past = self.qpos[0], past
        self.gloves = LateGloves(
            AS_IT_IS, self.noise, missing, delay, self.qpos, past, np.arange(3, 25)
        )

    def at(self, tick: int, told: bool = True):
        """Measure reading by reading, up to one; return what comes then."""
        for now in range(tick + 1):
            self.qpos[:, 3:] = self.q[now]
            forces = [[float(now + run)] * 5 for run in range(N_RUNS)]
            self.gloves.measure(now, self.told[now] if told and now else None, forces)
            if now < tick:
                self.past[now] = self.qpos
        return self.gloves

    def expected(self, row: int) -> np.ndarray:
        return self.q[row] + self.noise[row]


def test_a_reading_is_posture_and_noise_of_now_with_the_wrist_that_was_told():
    worn = Worn()
    gloves = worn.at(4)
    np.testing.assert_array_equal(gloves.read(), worn.expected(4))
    by_driver = gloves.read_by_driver()
    np.testing.assert_array_equal(by_driver[:, REST], worn.expected(4)[:, REST])
    np.testing.assert_array_equal(by_driver[:, WRIST_COLUMNS], worn.told[4][:, WRIST_COLUMNS])
    np.testing.assert_array_equal(gloves.read(), worn.expected(4))  # which stays as it was
    assert gloves.forces == [[4.0] * 5, [5.0] * 5, [6.0] * 5]


def test_where_nothing_was_told_the_wrist_is_read_as_it_is():
    gloves = Worn().at(4, told=False)
    np.testing.assert_array_equal(gloves.read_by_driver(), gloves.read())


def test_where_a_reading_is_lost_posture_noise_and_wrist_are_those_before():
    """And forces are those of now: they are not the glove's."""
    worn = Worn(lost=[(4, 1)])
    gloves = worn.at(4)
    read, by_driver = gloves.read(), gloves.read_by_driver()
    for run, row in enumerate((4, 3, 4)):
        np.testing.assert_array_equal(read[run], worn.expected(row)[run])
        np.testing.assert_array_equal(by_driver[run, REST], worn.expected(row)[run, REST])
        told = worn.told[row][run, WRIST_COLUMNS]
        np.testing.assert_array_equal(by_driver[run, WRIST_COLUMNS], told)
    assert gloves.forces == [[4.0] * 5, [5.0] * 5, [6.0] * 5]


def test_a_reading_that_is_lost_twice_is_the_last_that_came():
    worn = Worn(lost=[(3, 0), (4, 0), (4, 2)])
    read = worn.at(4).read()
    for run, row in enumerate((2, 4, 3)):
        np.testing.assert_array_equal(read[run], worn.expected(row)[run])


def test_what_is_lost_from_the_beginning_is_the_first_with_its_own_wrist():
    worn = Worn(lost=[(tick, 2) for tick in range(5)])
    gloves = worn.at(4)
    np.testing.assert_array_equal(gloves.read()[2], worn.expected(0)[2])
    np.testing.assert_array_equal(gloves.read_by_driver()[2], worn.expected(0)[2])
    told = worn.told[4][:2, WRIST_COLUMNS]
    np.testing.assert_array_equal(gloves.read_by_driver()[:2, WRIST_COLUMNS], told)


@pytest.mark.parametrize(("tick", "row"), [(0, 0), (1, 0), (2, 0), (3, 1), (7, 5)])
def test_what_is_late_is_posture_wrist_and_forces_of_that_time(tick, row):
    worn = Worn(delay=2)
    gloves = worn.at(tick)
    np.testing.assert_array_equal(gloves.read(), worn.expected(row))
    told = worn.told[row] if row else worn.expected(0)
    by_driver = gloves.read_by_driver()[:, WRIST_COLUMNS]
    np.testing.assert_array_equal(by_driver, told[:, WRIST_COLUMNS])
    assert gloves.forces[0] == [float(row)] * 5


def test_what_was_read_is_read_anew_at_the_next_reading():
    worn = Worn()
    before = worn.at(4).read()
    assert worn.gloves.read() is before
    np.testing.assert_array_equal(worn.at(5).read(), worn.expected(5))
    np.testing.assert_array_equal(before, worn.expected(4))


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
    monkeypatch.setattr(Sensors, "felt", lambda self, values: ([next(ticks)], [[0.0] * 6]))
    made = made_with(**values)
    assert counts == list(range(61))
    times.remove(60)  # that of the record, of all readings at once
    return made, np.bincount(times, minlength=61), kept


@pytest.mark.parametrize("base", ["free", "arm"])
def test_after_the_reach_the_glove_is_asked_only_where_a_finger_touches(monkeypatch, base):
    """Once at each of the reach's six readings."""
    touches = {12: INDEX, 30: THUMB}
    made, asked, kept = asked_of_the_glove(monkeypatch, touches, seed=6, base=base)
    assert len(made.driver.asked) == 6
    assert asked[:6].tolist() == [1, 1, 1, 1, 1, 1]
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
    assert asked[:6].tolist() == [1] * 6 and not asked[6:].any()  # what was read is kept
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
