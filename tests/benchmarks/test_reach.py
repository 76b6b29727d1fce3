"""The yardstick of reaches runs on the ones that are shipped, and holds what pages say of it."""

import numpy as np
import pytest

from tests.benchmarks import reach as bench


@pytest.mark.slow
def test_a_reach_left_out_is_nearer_than_the_straight_line() -> None:
    recordings = bench.recordings_of(bench.SHIPPED)
    person = bench.measured(recordings)
    assert person.forearm == pytest.approx(0.236, abs=0.003)
    reaches = [bench.reach_of(each, person) for each in recordings]
    palm = bench.palm_scores(reaches, 0)
    assert palm["proved"] == palm["arrived"] == 1
    assert palm["path, learned"] < 0.5 * palm["path, straight"]
    assert palm["over time, learned"] < 0.8 * palm["over time, straight with minimum jerk"]
    elbow = [bench.elbow_scores(reaches, i, person) for i in range(len(reaches))]
    mean = {name: np.mean([each[name] for each in elbow]) for name in elbow[0]}
    assert mean["height, fitted law"] < 8
    assert mean["height, handsim's arm, 7 joints"] < 8
    assert mean["place, fitted law"] < 0.5 * mean["place, towards the mouth"]
    hand = bench.aperture_scores(recordings, 0)
    assert hand["hand's progress, coupled"] < 0.3 * hand["hand's progress, minimum jerk"]
