"""The navigation function that leads along a guide: its flow, and the proof that it arrives."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.learning.guide.curve import Curve
from handsim.learning.guide.field import GuidedField
from handsim.navigation.flow import follow
from handsim.navigation.paths import at_arc_length, path_error

LOW, HIGH, WIDTH = np.full(3, -1.0), np.full(3, 1.0), np.full(3, 0.15)
K = 4.0


def winding(seed: int, size: float = 0.5) -> np.ndarray:
    """A wild path (100, 3) from one random place to another."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-size, size, (7, 3))
    return at_arc_length(Curve(corners).at(np.linspace(0, 1, 400)), np.linspace(0, 1, 100))


def led(path: np.ndarray) -> GuidedField:
    return GuidedField.leading(path, LOW, HIGH, WIDTH, K, 2.0)


def phi(field: GuidedField, e: np.ndarray) -> np.ndarray:
    """Eq. (2) of the paper in straightened coordinates, written down once more."""
    gamma = field.pull * (e[:, :-1] ** 2).sum(axis=1) + e[:, -1] ** 2
    ln_beta = field.obstacle.log_jets(field.restored(e)[0], field.k, 0)[0]
    return gamma / (gamma**field.k + np.exp(ln_beta)) ** (1 / field.k)


@pytest.mark.parametrize("seed", range(4))
def test_from_its_start_the_guide_is_followed(seed: int) -> None:
    path = winding(seed)
    found = led(path).path(path[0])
    assert found.arrived and found.reason == "arrived"
    np.testing.assert_array_equal(found.points[[0, -1]], path[[0, -1]])
    assert path_error(found.points, path) < 0.02


def test_the_flow_is_minus_the_gradient_of_phi() -> None:
    field = led(winding(1))
    rng = np.random.default_rng(0)
    low, high = field.obstacle.lower, field.obstacle.upper
    z = low + (high - low) * rng.uniform(0.01, 0.99, (3000, 3))
    e = field.straightened(z, rng.uniform(-0.2, 1.2, 3000))
    h = 1e-6 * np.eye(4)
    gradient = np.stack([(phi(field, e + d) - phi(field, e - d)) / 2e-6 for d in h], axis=1)
    wanted = -gradient / np.linalg.norm(gradient, axis=1, keepdims=True)
    steep = np.linalg.norm(gradient, axis=1) > 1e-3
    assert steep.sum() > 200
    near = field.obstacle.closure(z)[1].any(axis=1)
    assert (steep & near).sum() > 40  # the closing layer counts, too
    flow = field.flow(e)
    np.testing.assert_allclose(flow[steep], wanted[steep], atol=2e-4)
    alone = [
        field.flow(each[None])[0] for each in e[:300]
    ]  # away from walls they are not asked for
    np.testing.assert_array_equal(flow[:300], alone)
    assert 50 < near[:300].sum() < 250


@pytest.mark.parametrize("seed", range(6))
def test_it_is_proven_and_every_start_in_the_workspace_arrives(seed: int) -> None:
    field = led(winding(seed, size=0.8))
    assert field.proven
    rng = np.random.default_rng(seed)
    low, high = field.obstacle.lower, field.obstacle.upper
    starts = low + (high - low) * rng.uniform(0.0, 1.0, (60, 3))
    e = field.straightened(starts, rng.uniform(0.0, 1.0, 60))
    found = follow(lambda e, _: field.flow(e), e, np.zeros_like(e))
    assert all(each.arrived for each in found)
    for each in found:  # phi falls all the way
        values = phi(field, each.points[:-1])
        assert (np.diff(values) < 1e-9).all()


def test_e_grad_phi_is_positive_everywhere_but_at_the_destination() -> None:
    rng = np.random.default_rng(5)
    for seed in range(5):
        field = led(winding(seed, size=0.9))
        low, high = field.obstacle.lower, field.obstacle.upper
        z = low + (high - low) * rng.uniform(0.0, 1.0, (4000, 3))
        e = field.straightened(z, rng.uniform(-1.0, 2.0, 4000))
        assert (np.sum(field.flow(e) * e, axis=1) < 0).all()


def test_a_workspace_too_narrow_is_not_proven() -> None:
    """A sharp turn in front of a wall: its straight continuation leaves the box."""
    turn = np.vstack(
        [np.linspace([0, 0, 0], [0.8, 0, 0], 50), np.linspace([0.8, 0, 0], [0, 0.5, 0], 51)[1:]]
    )
    field = led(turn.astype(float))
    assert field.proven and field.obstacle.upper[0] > 1.0
    narrow = led(np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]))
    assert not replace(field, obstacle=narrow.obstacle).proven
    assert not replace(field, pull=np.nan).proven
    assert not replace(field, pull=np.inf).proven and not replace(field, k=np.inf).proven
    assert not replace(field, guide=Curve(turn * np.nan)).proven
    assert not replace(field, pull=0.0).proven
    assert not replace(field, k=0.5).proven


def test_velocity_on_the_guide_is_its_own_and_beside_it_leads_back() -> None:
    field = led(winding(2))
    s, rate = 0.4, 0.7
    on = field.guide.at(np.array([s]))
    np.testing.assert_allclose(
        field.velocity(on, s, rate, 1.5), rate * field.guide.slope(np.array([s])), atol=1e-12
    )
    aside = np.array([[0.05, -0.02, 0.03]])
    difference = field.velocity(on + aside, s, rate, 1.5) - field.velocity(on, s, rate, 1.5)
    np.testing.assert_allclose(difference, -1.5 * field.pull * aside, rtol=1e-9)
    # With ds/dt = 1 and so ds/dt / (1 - s), the velocity is the flow itself.
    z = np.vstack([on + aside, on - aside])
    flow = field.flow(field.straightened(z, np.full(2, s)))
    along = field.velocity(z, s, 1.0, 1 / (1 - s)) - field.guide.slope(np.array([s]))
    np.testing.assert_allclose(along, field.length * flow[:, :-1] / flow[:, -1:], rtol=1e-9)


def test_velocities_near_a_wall_are_of_the_flow_too() -> None:
    field = led(winding(3))
    s, low, high = 0.5, field.obstacle.lower, field.obstacle.upper
    inside = field.guide.at(np.array([s])) + 0.02
    beside = np.array([[high[0] - 0.3 * WIDTH[0], *inside[0, 1:]]])
    for z in (inside, beside):
        flow = field.flow(field.straightened(z, np.array([s])))
        back = field.length * flow[:, :-1] / np.maximum(flow[:, -1:], 0.05)
        wanted = 0.4 * field.guide.slope(np.array([s])) + 0.8 * (1 - s) * back
        np.testing.assert_allclose(field.velocity(z, s, 0.4, 0.8), wanted, rtol=1e-9, atol=1e-12)
    assert (field.obstacle.closure(beside)[1][0] != 0).any() and (beside > low).all()


def test_velocities_of_one_posture_are_those_of_many_to_the_bit() -> None:
    """On the guide, beside it and by a wall."""
    field, rng = led(winding(4)), np.random.default_rng(0)
    low, high = field.obstacle.lower, field.obstacle.upper
    free = 0
    for s in (0.0, 0.3, 0.97, 1.0):
        for _ in range(20):
            z = low + (high - low) * rng.uniform(0.0, 1.0, (2, 3))
            free += all(field._free(row[None]) for row in z)
            together = field.velocity(z, s, 0.4, 0.8)
            if not all(field._free(row[None]) == field._free(z) for row in z):
                continue  # near a wall all of them are computed by the flow
            for row, expected in zip(z, together, strict=True):
                np.testing.assert_array_equal(field.velocity(row[None], s, 0.4, 0.8)[0], expected)
    assert 5 < free < 75
