import numpy as np
import pytest

from handsim.grasping.rollout.glove import RATE, DataGlove

STEP = np.deg2rad(1.0)
SILENT = DataGlove(noise=0.0)


def degrees(angles, glove=SILENT, disturbance=0.0):
    """What is read of angles [deg], in degrees."""
    q = np.deg2rad(np.asarray(angles, dtype=float))
    return np.rad2deg(glove.reading(q, np.broadcast_to(np.deg2rad(disturbance), q.shape)))


def test_readings_are_the_nearest_whole_degrees():
    read = degrees([0.0, 0.49, 0.51, 1.0, 29.6, -0.49, -0.51, -29.6])
    np.testing.assert_allclose(read, [0, 0, 1, 1, 30, 0, -1, -30], atol=1e-12)


def test_readings_are_right_on_average():
    """Rounded down they would be half a degree too small."""
    q = np.linspace(-1.0, 1.5, 10_001)
    error = SILENT.reading(q, np.zeros_like(q)) - q
    assert abs(error.mean()) < 0.01 * STEP
    assert np.abs(error).max() <= STEP / 2 + 1e-12


def test_the_step_is_the_resolution():
    coarse = DataGlove(resolution=np.deg2rad(5.0), noise=0.0)
    np.testing.assert_allclose(degrees([2.4, 2.6, 8.0], coarse), [0, 5, 10], atol=1e-12)


def test_noise_is_added_before_rounding():
    np.testing.assert_allclose(degrees([10.4, 10.4], disturbance=[0.2, -0.2]), [11, 10], atol=1e-9)


def test_noise_is_normal_of_a_quarter_degree_and_from_the_generator():
    drawn = np.rad2deg(DataGlove().disturbance((200, 100), np.random.default_rng(1)))
    assert drawn.shape == (200, 100)
    assert drawn.std() == pytest.approx(0.25, rel=0.02)
    assert drawn.mean() == pytest.approx(0.0, abs=0.01)
    # As of a normal distribution; of a uniform one it would be 0.58.
    assert (np.abs(drawn) < drawn.std()).mean() == pytest.approx(0.683, abs=0.01)
    same = np.random.default_rng(1).standard_normal((200, 100))
    np.testing.assert_allclose(drawn, 0.25 * same, rtol=1e-12)


def test_a_reading_takes_its_noise_from_the_generator():
    glove, q = DataGlove(), np.linspace(-0.3, 1.4, 22)
    generator = np.random.default_rng(7)
    first, second = glove.read(q, generator), glove.read(q, generator)
    noise = np.random.default_rng(7).standard_normal((2, 22)) * np.deg2rad(0.25)
    expected = np.round(np.rad2deg(q + noise))
    np.testing.assert_allclose(np.rad2deg([first, second]), expected, atol=1e-9)
    assert (first != second).any()


def test_it_is_read_a_hundred_times_a_second():
    assert RATE == 100.0
