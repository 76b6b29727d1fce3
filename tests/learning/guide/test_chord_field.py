"""The field of the place alone: its flow, its proof, and what it can and cannot follow."""

from dataclasses import replace

import numpy as np
import pytest

from handsim.learning.guide.chord import across, graphs
from handsim.learning.guide.chord_field import ChordField
from handsim.learning.guide.curve import Curve
from handsim.learning.movement.progress import ProgressLaw, minimum_jerk
from handsim.learning.movement.timing import GuidedTiming
from handsim.navigation.flow import follow
from handsim.navigation.paths import arc_length, path_error

LOW, HIGH, WIDTH = np.full(3, -1.0), np.full(3, 1.0), np.full(3, 0.15)
K, PULL = 4.0, 2.0
S = np.linspace(0.0, 1.0, 100)


def bent(seed: int, size: float = 0.6) -> np.ndarray:
    """A path (100, 3) that wanders at right angles to its chord."""
    rng = np.random.default_rng(seed)
    start, goal = rng.uniform(-size, size, (2, 3))
    departure = Curve(np.vstack([np.zeros(3), rng.uniform(-size, size, (4, 3)), np.zeros(3)])).at(S)
    return start + S[:, None] * (goal - start) + across(departure, goal - start)


def led(path: np.ndarray) -> ChordField:
    return ChordField.leading(path, LOW, HIGH, WIDTH, K, PULL)


def phi(field: ChordField, z: np.ndarray) -> np.ndarray:
    """Eq. (2) of the paper at places, written down once more."""
    a, b = field.guide.points[[0, -1]]
    s = (z - a) @ (b - a) / np.sum((b - a) ** 2)
    y = z - field.guide.at(s)
    gamma = PULL * np.sum(y**2, axis=1) + np.sum((b - a) ** 2) * (1 - s) ** 2
    ln_beta = field.obstacle.log_jets(z, K, 0)[0]
    return gamma / (gamma**K + np.exp(ln_beta)) ** (1 / K)


def inside(field: ChordField, count: int, seed: int = 0) -> np.ndarray:
    low, high = field.obstacle.lower, field.obstacle.upper
    return low + (high - low) * np.random.default_rng(seed).uniform(0.005, 0.995, (count, 3))


def test_straightened_places_come_back_and_are_a_shear() -> None:
    field = led(bent(0))
    z = inside(field, 500)
    e = field.straightened(z)
    np.testing.assert_allclose(field.restored(e)[0], z, atol=1e-12)
    chord = field.guide.points[-1] - field.guide.points[0]
    np.testing.assert_allclose(e[:, :-1] @ chord, 0.0, atol=1e-12)
    np.testing.assert_allclose(field.straightened(field.z_goal[None]), 0.0, atol=1e-15)
    np.testing.assert_array_equal(field.straightened(z, np.full(500, 0.3)), e)


@pytest.mark.parametrize("seed", range(4))
def test_the_flow_is_the_steepest_fall_of_phi(seed: int) -> None:
    """Over e, of which one number is not free."""
    field = led(bent(seed))
    z = inside(field, 2000, seed)
    e = field.straightened(z)
    chord = field.guide.points[-1] - field.guide.points[0]
    axis = chord / np.linalg.norm(chord)
    sideways = np.linalg.svd(axis[None])[2][1:]  # (2, 3)
    steps = np.vstack([np.column_stack([sideways, np.zeros(2)]), [0.0, 0.0, 0.0, 1.0]])
    h = 1e-6
    slopes = np.stack(
        [
            (phi(field, field.restored(e + h * d)[0]) - phi(field, field.restored(e - h * d)[0]))
            / (2 * h)
            for d in steps
        ],
        axis=1,
    )
    steep = np.linalg.norm(slopes, axis=1) > 1e-3
    near = field.obstacle.closure(z)[1].any(axis=1)
    assert (steep & near).sum() > 40
    wanted = -slopes[steep] / np.linalg.norm(slopes[steep], axis=1, keepdims=True) @ steps
    np.testing.assert_allclose(field.flow(e)[steep], wanted, atol=2e-4)


@pytest.mark.parametrize("seed", range(6))
def test_it_is_proven_and_every_start_arrives_while_phi_falls(seed: int) -> None:
    field = led(bent(seed, size=0.8))
    assert field.proven
    e = field.straightened(inside(field, 60, seed))
    found = follow(lambda e, _: field.flow(e), e, np.zeros_like(e))
    assert all(each.arrived for each in found)
    for each in found:
        assert (np.diff(phi(field, field.restored(each.points[:-1])[0])) < 1e-9).all()
    everywhere = field.straightened(inside(field, 4000, seed + 1))
    assert (np.sum(field.flow(everywhere) * everywhere, axis=1) < 0).all()


def test_a_workspace_too_narrow_is_not_proven() -> None:
    field = led(bent(1))
    narrow = led(np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]))
    small = replace(narrow.obstacle, width=0.3 * (narrow.obstacle.upper - narrow.obstacle.lower))
    assert field.proven and not replace(field, obstacle=small).proven
    assert not replace(field, pull=0.0).proven


@pytest.mark.parametrize("seed", range(4))
def test_from_its_start_the_guide_is_followed_and_from_on_it_too(seed: int) -> None:
    path = bent(seed)
    field = led(path)
    found = field.path(path[0])
    assert found.arrived and path_error(found.points, path) < 0.02
    half = field.guide.at(np.array([0.5]))[0]
    rest = field.path(half)  # the place tells the progress
    assert rest.arrived and path_error(rest.points, field.guide.at(np.linspace(0.5, 1, 50))) < 0.02


def test_where_the_ends_agree_the_flow_is_straight_and_proven() -> None:
    field = led(np.zeros((100, 3)))
    assert field.proven and field.length == 1.0
    found = field.path(np.array([0.5, -0.2, 0.3]))
    assert found.arrived
    np.testing.assert_allclose(
        found.points[:3], np.array([[0.5, -0.2, 0.3]]) * found.points[:3, :1] / 0.5, atol=1e-9
    )
    assert np.isfinite(field.velocity(np.full((1, 3), 0.1), 0.0, 1.0, 1.0)).all()


@pytest.mark.parametrize("seed", [2, 3])
def test_in_a_loop_the_guide_is_covered_as_the_law_says_and_a_push_made_up_for(seed: int) -> None:
    path = bent(seed)
    timing = GuidedTiming(led(path), ProgressLaw(2.0))
    z, dt, covered, length = path[0], 0.002, [], arc_length(timing.field.guide.at(S))
    for i in range(1000):
        covered.append(np.interp(timing.field.covered(z[None])[0], S, length / length[-1]))
        z = z + dt * timing.velocities(z[None], i * dt)[0]
    wanted = minimum_jerk(dt * np.arange(1000), 2.0)
    assert np.abs(np.array(covered) - wanted).max() < 0.02
    assert np.linalg.norm(z - path[-1]) < np.deg2rad(1.0)
    z = path[0]
    for i in range(1200):
        if i == 400:
            z = z + across(np.array([[0.2, -0.1, 0.15]]), path[-1] - path[0])[0]
        z = z + dt * timing.velocities(z[None], i * dt)[0]
    assert np.linalg.norm(z - path[-1]) < np.deg2rad(1.5)


def test_velocity_is_the_flow() -> None:
    field = led(bent(2))
    z = inside(field, 300)
    e = field.straightened(z)
    flow = field.flow(e)
    h = 1e-7
    pushed = (field.restored(e + h * flow)[0] - z) / h
    moved = field.velocity(z, 0.5, 1.0, 1.5)
    moved /= np.linalg.norm(moved, axis=1, keepdims=True)
    np.testing.assert_allclose(
        moved, pushed / np.linalg.norm(pushed, axis=1, keepdims=True), atol=1e-5
    )
    np.testing.assert_allclose(
        field.velocity(z, 0.1, 9.0, 3.0), 2 * field.velocity(z, 0.5, 1.0, 1.5), rtol=1e-12
    )


def test_beside_the_guide_it_leads_back_pull_times_as_fast_as_along_it() -> None:
    field = led(bent(2))
    on, slope = field.guide.at(np.array([0.4])), field.guide.slope(np.array([0.4]))
    chord = field.guide.points[-1] - field.guide.points[0]
    aside = across(np.array([[0.05, -0.02, 0.03]]), chord)
    along = field.velocity(on, 0.0, 0.0, 1.5)
    rate = np.linalg.norm(along) / np.linalg.norm(slope)
    np.testing.assert_allclose(along, rate * slope, rtol=1e-9)
    back = field.velocity(on + aside, 0.0, 0.0, 1.5) - along
    np.testing.assert_allclose(back, -PULL * rate / 0.6 * aside, rtol=1e-9)


def test_graphs_are_departures_from_the_chord_and_wait_where_the_path_goes_back() -> None:
    path = bent(4)
    departure = graphs(path[None])[0]
    chord = path[0] + S[:, None] * (path[-1] - path[0])
    np.testing.assert_allclose(departure, path - chord, atol=1e-9)
    uneven = np.repeat(path, np.arange(100) % 3 + 1, axis=0)[:100]
    uneven[-1] = path[-1]
    assert np.isfinite(graphs(uneven[None])).all()  # standstills do not matter
    there = np.linspace([0.0, 0.0], [1.0, 0.0], 40)
    back = np.linspace([1.0, 0.5], [0.5, 0.5], 30)
    again = np.linspace([0.5, 1.0], [2.0, 0.0], 30)
    found = graphs(np.vstack([there, back, again])[None])[0]
    assert (np.abs(found[:49, 1]) < 1e-12).all()  # the first time that a place was passed
    assert found[50:60, 1].max() > 0.3
    np.testing.assert_array_equal(graphs(np.zeros((1, 100, 2))), np.zeros((1, 100, 2)))
