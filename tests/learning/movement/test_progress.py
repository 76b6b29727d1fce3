"""Laws of progress over time."""

import numpy as np
import pytest

from handsim.errors import InputError
from handsim.learning.movement.progress import ProgressLaw, minimum_jerk


def test_minimum_jerk_profile() -> None:
    time = np.linspace(-0.5, 3.0, 3501)
    s = minimum_jerk(time, 2.0)
    assert (s[time <= 0] == 0).all() and (s[time >= 2] == 1).all()
    np.testing.assert_allclose(s + minimum_jerk(2.0 - time, 2.0), 1.0, atol=1e-12)
    speed = np.gradient(s, time)
    assert speed.max() == pytest.approx(1.875 / 2.0, rel=1e-4)  # 15/8 of the mean


def test_a_learned_law_rises_from_0_to_1_with_its_own_slope() -> None:
    law = ProgressLaw(2.0, np.array([0.0, 0.1, 0.1, 0.8, 0.95, 1.0]))
    time = np.linspace(0.0, 2.0, 2001)
    covered = law.covered(time)
    assert covered[0] == 0.0 and covered[-1] == pytest.approx(1.0, abs=1e-15)
    assert (np.diff(covered) >= 0).all()
    slopes = np.gradient(covered, time)
    for i in (200, 700, 1100):
        at, rate = law.at(time[i])
        assert at == pytest.approx(covered[i]) and rate == pytest.approx(slopes[i], rel=1e-3)
    assert slopes[900] > 2 * slopes[500]  # slow, then fast


@pytest.mark.parametrize("curve", [None, np.array([0.0, 0.1, 0.5, 0.9, 1.0])])
def test_the_rate_is_held_near_the_end(curve: np.ndarray | None) -> None:
    law = ProgressLaw(1.0, curve)
    time = np.linspace(0.0, 1.0, 1001)
    covered = law.covered(time)
    late = int(np.argmax(covered >= 0.95))
    at, rate = law.at(time[late])
    assert law.closing(time[late]) == pytest.approx(rate / (1 - at), rel=1e-3)
    assert law.closing(1.0) == law.closing(5.0) == pytest.approx(rate / (1 - at), rel=1e-2)
    assert law.closing(-1.0) == law.closing(0.0) and law.at(-1.0)[0] == 0.0
    assert law.at(1.0) == law.at(5.0) == (1.0, 0.0)


@pytest.mark.parametrize("curve", [None, np.array([0.0, 0.1, 0.1, 0.8, 0.95, 1.0])])
def test_both_at_once_are_the_same_bits_as_one_by_one(curve: np.ndarray | None) -> None:
    """Before, in and after the movement, and where the rate begins to be held."""
    law = ProgressLaw(1.3, curve)
    time = np.linspace(-0.4, 1.7, 2101)
    held = float(time[np.argmax(law.covered(time) >= 0.95)])
    near = [np.nextafter(edge, way) for edge in (0.0, held, 1.3) for way in (-9.0, 9.0)]
    for each in [*time.tolist(), 0.0, held, 1.3, *map(float, near)]:
        assert law.at_and_closing(each) == (*law.at(each), law.closing(each)), each
    assert law.at_and_closing(5.0)[:2] == (1.0, 0.0) and law.at_and_closing(5.0)[2] > 1.0


@pytest.mark.parametrize("duration", [0.0, -1.0, np.nan, np.inf, 601.0])
def test_bad_durations(duration: float) -> None:
    with pytest.raises(InputError, match="positive number of seconds"):
        ProgressLaw(duration)
