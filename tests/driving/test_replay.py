"""A recorded signal along the path of a controller, and its score."""

import numpy as np
import pytest

from handsim.driving.driver import DriverRule
from handsim.driving.replay import Driven, drive_postures
from handsim.driving.signal_map import PHASES, map_between, mean_progress
from handsim.errors import InputError
from handsim.files import data_folder
from handsim.joints import LOWER, UPPER, clip_to_range
from handsim.learning.controller import GraspController
from handsim.learning.over_time import posture_rms_deg


@pytest.fixture(scope="module")
def controller() -> GraspController:
    return GraspController.load(data_folder("assets") / "controller.npz")


def ramp(n: int = 200) -> tuple[np.ndarray, np.ndarray]:
    time = 3.0 + np.arange(n) / 50
    return time, np.minimum(np.linspace(0.0, 1.5, n), 1.0)


def rule(controller: GraspController) -> DriverRule:
    return DriverRule(map_between(controller.demonstrations, 0.0, 1.0), smoothing=0.0, speed=100.0)


def replayed(controller: GraspController, values: np.ndarray, time: np.ndarray, q=None) -> Driven:
    known = controller.demonstration("cube-raise")
    return drive_postures(
        controller, rule(controller), time, values, known.q_start, known.q_goal, q
    )


def led(controller: GraspController, values: np.ndarray) -> np.ndarray:
    """Progress of this task at the phase at which people's mean progress is the signal's value."""
    known = controller.demonstration("cube-raise")
    usual = rule(controller).map.pace.duration
    law = controller.progress(known.z_start, known.z_goal, usual)
    phase = np.interp(values, mean_progress(controller.demonstrations), PHASES)
    return np.interp(phase, PHASES, law.covered(PHASES * usual))


def test_it_goes_from_start_to_destination(controller: GraspController) -> None:
    time, values = ramp()
    known = controller.demonstration("cube-raise")
    driven = replayed(controller, values, time)
    assert driven.arrived and driven.reason == "arrived"
    assert driven.goal_distance < np.deg2rad(4)
    assert driven.progress[-1] == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(driven.progress[1:], led(controller, values)[1:], atol=1e-3)
    subspace = controller.subspace
    first = clip_to_range(subspace.inverse_transform(subspace.transform(known.q_start)))
    np.testing.assert_allclose(driven.q[0], first, atol=1e-9)
    assert ((driven.q >= LOWER) & (driven.q <= UPPER)).all()
    assert driven.time is time
    assert driven.rms_deg is None and driven.time_law_rms_deg is None


def test_a_signal_that_stops_leaves_it_on_the_way(controller: GraspController) -> None:
    time, values = ramp()
    driven = replayed(controller, np.minimum(values, 0.5), time)
    assert driven.progress[-1] == pytest.approx(led(controller, np.array([0.5]))[0])
    assert not driven.arrived
    assert driven.reason == "on the way"


def test_missing_values_are_counted_and_held(controller: GraspController) -> None:
    time, values = ramp()
    values[50:100] = np.nan
    driven = replayed(controller, values, time)
    assert driven.n_missing == 50
    assert (driven.progress[50:100] == driven.progress[49]).all()
    assert (driven.q[50:100] == driven.q[49]).all()


def test_the_score_is_the_root_of_the_mean_square(controller: GraspController) -> None:
    time, values = ramp()
    driven = replayed(controller, values, time)
    off = driven.q + np.deg2rad(3.0)
    assert posture_rms_deg(driven.q, off) == pytest.approx(3.0)
    again = replayed(controller, values, time, off)
    assert again.rms_deg == pytest.approx(3.0)
    assert again.time_law_rms_deg is not None and again.time_law_rms_deg > 3.0
    known = controller.demonstration("cube-raise")
    made = controller.postures(known.q_start, known.q_goal, duration=time[-1] - time[0], rate=50.0)
    by_time = replayed(controller, values, time, made.q[: len(time)])
    assert by_time.time_law_rms_deg == pytest.approx(0.0, abs=0.05)


def test_what_cannot_be_replayed_is_refused(controller: GraspController) -> None:
    time, values = ramp()
    for wrong_time, wrong_values, words in (
        (time, values[:-1], "must be"),
        (time[:1], values[:1], "at least 2"),
        (time[::-1], values, "times do not increase"),
        (np.where(time > 4, np.nan, time), values, "times do not increase"),
        (time, np.full(len(time), np.nan), "no value in 200 frames"),
    ):
        with pytest.raises(InputError, match=words):
            replayed(controller, wrong_values, wrong_time)


def test_the_answer_prints_and_converts(controller: GraspController) -> None:
    time, values = ramp()
    driven = replayed(controller, values, time)
    assert driven.as_dict()["reason"] == "arrived"
    assert "progress" in str(driven)
