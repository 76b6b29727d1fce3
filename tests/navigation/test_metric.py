"""The metric of a destination in closed form: its kernel, its logarithm and what is kept of it."""

import numpy as np
import pytest
from scipy.linalg import expm

from handsim.navigation import metric as metric_module
from handsim.navigation.metric import (
    DestinationMetric,
    Exponential,
    exponential,
    gaussian_kernel,
)


@pytest.mark.parametrize("reach", [0.5, 2.0])
def test_destinations_share_by_a_gaussian_of_their_distance_in_reaches(reach: float) -> None:
    centre, along = np.array([0.2, -0.1]), np.array([0.6, 0.8])
    distances = np.array([0.0, 1.0, 2.0, 3.0])
    points = centre + reach * distances[:, None] * along
    shares = gaussian_kernel(points, np.array([centre, points[2]]), reach)
    assert shares.shape == (4, 2)
    np.testing.assert_allclose(shares[:, 0], np.exp([0.0, -0.5, -2.0, -4.5]))
    np.testing.assert_allclose(shares[:, 1], np.exp([-2.0, -0.5, 0.0, -0.5]))


def test_a_diagonal_metric_in_closed_form() -> None:
    """Logarithms (a, b) + K (c, d): the metric is their exponential, share by share."""
    centres = np.array([[0.0, 0.0], [1.0, 0.0]])
    logs = np.array([np.diag([0.3, -0.3]), np.diag([1.0, -1.0]), np.diag([-0.5, 0.25])])
    metric = DestinationMetric(centres, logs, 1.0)
    near, far = 1.0, np.exp(-0.5)
    expected = [0.3 + near - 0.5 * far, -0.3 - near + 0.25 * far]
    np.testing.assert_allclose(metric.at(np.zeros(2)), np.diag(np.exp(expected)), atol=1e-12)
    both = metric.at(centres)
    other = [0.3 + far - 0.5 * near, -0.3 - far + 0.25 * near]
    np.testing.assert_allclose(both[1], np.diag(np.exp(other)), atol=1e-12)


def metric_of(log: np.ndarray) -> np.ndarray:
    """Return the metric of a destination whose logarithm is given."""
    logs = np.array([log, np.zeros_like(log)])
    return DestinationMetric(np.zeros((1, len(log))), logs, 1.0).at(np.ones(len(log)))


@pytest.mark.parametrize("t", [0.0, 0.7, -1.3, 4.0])
def test_the_metric_is_the_exponential_of_its_logarithm(t: float) -> None:
    """Of [[0, t], [t, 0]] it is [[cosh t, sinh t], [sinh t, cosh t]]."""
    expected = [[np.cosh(t), np.sinh(t)], [np.sinh(t), np.cosh(t)]]
    np.testing.assert_allclose(metric_of(t * np.array([[0.0, 1.0], [1.0, 0.0]])), expected)
    # And of one with other axes, where rows and columns of the eigenvectors differ.
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    along = t * np.array([0.1, -0.4, 0.9])
    found = metric_of(turn @ np.diag(along) @ turn.T)
    np.testing.assert_allclose(found, turn @ np.diag(np.exp(along)) @ turn.T, atol=1e-12)


def test_what_is_kept_is_of_the_same_destinations_in_the_same_shape() -> None:
    logs = np.array([np.zeros((2, 2)), np.diag([1.0, -1.0])])
    metric = DestinationMetric(np.zeros((1, 2)), logs, 1.0)
    one, other = np.array([0.0, 0.0]), np.array([0.0, 2.0])
    for asked, share in (
        (one, 1.0),
        (other, np.exp(-2.0)),
        (one, 1.0),
        (one[None], 1.0),
        (one, 1.0),
    ):
        found = metric.at(asked)
        assert found.shape == (*asked.shape, 2)
        np.testing.assert_allclose(np.squeeze(found), np.diag(np.exp([share, -share])))
    for asked in (one, other):  # the latest answer alone
        assert metric.at(asked) is metric.at(asked.copy())
    many = metric.at(np.zeros((3, 4, 2)))
    assert many.shape == (3, 4, 2, 2)


def test_each_destination_of_a_roll_out_is_computed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """While paths end one by one, and for destinations that stand there many times."""
    computed: list[int] = []

    def counted(a: np.ndarray, b: np.ndarray, reach: float) -> np.ndarray:
        computed.append(len(a))
        return gaussian_kernel(a, b, reach)

    monkeypatch.setattr(metric_module, "gaussian_kernel", counted)
    rng = np.random.default_rng(0)
    logs = rng.normal(size=(4, 3, 3))
    metric = DestinationMetric(rng.normal(size=(3, 3)), logs + np.swapaxes(logs, 1, 2), 1.0)
    goals = 2.0 * rng.normal(size=(20, 3))
    repeated = goals[rng.integers(20, size=200)]
    assert len(np.unique(repeated, axis=0)) == 20
    for asked in (repeated, repeated[::2], repeated[50:60], goals[::-1], goals[3]):
        metric.at(asked)
    assert computed == [20]
    metric.at(np.vstack([goals[:2], goals[:1] + 1.0]))
    metric.at(np.vstack([goals[:1], goals[:1] + 1.0]))
    assert computed == [20, 3]


def test_what_is_kept_is_the_same_to_the_bit() -> None:
    rng = np.random.default_rng(1)
    logs = rng.normal(size=(4, 3, 3))  # norms of many sizes, which take different numbers of steps
    made = (rng.normal(size=(3, 3)), logs + np.swapaxes(logs, 1, 2), 1.0)
    metric = DestinationMetric(*made)
    goals = 2.0 * rng.normal(size=(20, 3))
    metric.at(goals)
    for which in ([7], [3, 3, 19], list(range(0, 20, 3))):
        np.testing.assert_array_equal(
            metric.at(goals[which]), DestinationMetric(*made).at(goals[which])
        )
    each = [DestinationMetric(*made).at(goal) for goal in goals]
    np.testing.assert_array_equal(DestinationMetric(*made).at(goals), each)


@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_exponentials_of_all_sizes_together_are_scipys_and_symmetric(n: int) -> None:
    rng = np.random.default_rng(3)
    logs, along = rng.normal(size=(2, 6, n, n)) * np.array([0.01, 0.1, 0.3, 1, 2, 4])[:, None, None]
    logs, along = logs + np.swapaxes(logs, 1, 2), along + np.swapaxes(along, 1, 2)
    found = Exponential(logs)
    wanted = expm(logs)
    scale = np.abs(wanted).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(found.value / scale, wanted / scale, atol=1e-13)
    for matrices in (found.value, found.slopes(along)):
        np.testing.assert_array_equal(matrices, np.swapaxes(matrices, 1, 2))


def test_the_slope_of_the_exponential_is_its_derivative() -> None:
    rng = np.random.default_rng(2)
    logs, along = rng.normal(size=(2, 6, 3, 3)) * np.array([0.1, 0.3, 1, 2, 3, 4])[:, None, None]
    logs, along = logs + np.swapaxes(logs, 1, 2), along + np.swapaxes(along, 1, 2)
    step = 1e-6
    slopes = (exponential(logs + step * along) - exponential(logs - step * along)) / (2 * step)
    scale = np.abs(slopes).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(Exponential(logs).slopes(along) / scale, slopes / scale, atol=1e-7)
