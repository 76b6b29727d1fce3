"""The parts of a fit: its derivatives, its prior, its steps."""

import numpy as np
import pytest

from handsim.joints import JOINT_INDEX, LOWER, UPPER
from handsim.recordings.fitting.hand_points import HandPoints, PalmPostures
from handsim.recordings.fitting.posture_fit import (
    DIP_PER_PIP,
    N_ANGLES,
    fit_postures,
    frame_costs,
    linearised,
    moved,
    weak_prior,
)
from handsim.recordings.fitting.start import rest_posture
from handsim.recordings.points.keypoint_order import expected_places
from handsim.types import HandSize

POINTS = HandPoints.expected(expected_places(), HandSize(0.19, 0.09))


def some_postures(n: int = 4) -> tuple[PalmPostures, np.ndarray]:
    rng = np.random.default_rng(3)
    q = rng.uniform(0.8 * LOWER + 0.2 * UPPER, 0.2 * LOWER + 0.8 * UPPER, (n, 22))
    q[:, N_ANGLES:] = 0
    rotation = np.linalg.qr(rng.normal(size=(n, 3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))[:, None, None]
    seen = rng.normal(size=(n, 21, 3))
    seen[0, 4] = np.nan
    return PalmPostures(q, rotation, rng.normal(size=(n, 3))), seen


def test_derivatives_of_the_cost_by_all_26_unknowns() -> None:
    postures, seen = some_postures()
    prior, step = weak_prior(), 1e-6
    off, slope = linearised(POINTS, seen, postures)
    down = np.einsum("nij,ni->nj", slope, off)
    down[:, 6:] -= prior.slope(postures.q[:, :N_ANGLES])
    for j in range(26):
        change = np.zeros((len(seen), 26))
        change[:, j] = step
        costs = [
            frame_costs(POINTS, seen, moved(postures, sign * change), prior) for sign in (1, -1)
        ]
        assert (costs[0] - costs[1]) / (2 * step) == pytest.approx(-2 * down[:, j], rel=1e-4)


def test_prior_is_least_at_rest_and_couples_dip_to_pip() -> None:
    prior, rest = weak_prior(), rest_posture()[:N_ANGLES]
    dips = [j for name, j in JOINT_INDEX.items() if name.endswith("_dip")]
    pips = [j - 1 for j in dips]
    least = np.linalg.solve(prior.matrix, prior.vector)
    assert least[pips] == pytest.approx(rest[pips])
    assert least[dips] == pytest.approx(DIP_PER_PIP * rest[pips])
    assert prior.cost(least[None])[0] == pytest.approx(0, abs=1e-9)
    assert prior.cost(least[None] + 0.1)[0] > 0.1
    pulled = prior.with_pull(np.zeros((2, N_ANGLES)), 1e-3)
    assert np.abs(np.linalg.solve(pulled.matrix, pulled.vector[1])).max() < 0.01


def test_angles_at_an_end_do_not_keep_the_others_from_their_best() -> None:
    postures, _ = some_postures()
    q = postures.q.copy()
    q[:, JOINT_INDEX["index_pip"]] = UPPER[JOINT_INDEX["index_pip"]] + 0.4  # beyond the range
    q[:, JOINT_INDEX["ring_pip"]] = -0.4
    hand = POINTS.kinematics
    places = hand.points(hand.frames(q), POINTS.on_hand)
    seen = places @ postures.rotation.swapaxes(1, 2) + postures.position[:, None]
    fitted = fit_postures(POINTS, seen, postures)
    assert (fitted.q[:, JOINT_INDEX["index_pip"]] == UPPER[JOINT_INDEX["index_pip"]]).all()
    off, slope = linearised(POINTS, seen, fitted)
    down = np.einsum("nij,ni->nj", slope, off)[:, 6:]
    down -= weak_prior().slope(fitted.q[:, :N_ANGLES])
    within = (fitted.q > LOWER + 1e-9) & (fitted.q < UPPER - 1e-9)
    stiffness = np.einsum("nij,nij->nj", slope, slope)[:, 6:] + 1
    assert np.rad2deg(np.abs(down / stiffness)[within[:, :N_ANGLES]]).max() < 0.5


def test_a_posture_is_reached_from_a_wrong_start() -> None:
    postures, _ = some_postures()
    hand = POINTS.kinematics
    places = hand.points(hand.frames(postures.q), POINTS.on_hand)
    seen = places @ postures.rotation.swapaxes(1, 2) + postures.position[:, None]
    start = PalmPostures(
        np.tile(rest_posture(), (4, 1)), postures.rotation, postures.position + 0.02
    )
    fitted = fit_postures(POINTS, seen, start)
    bent = hand.points(hand.frames(fitted.q), POINTS.on_hand)
    found = bent @ fitted.rotation.swapaxes(1, 2) + fitted.position[:, None]
    assert np.sqrt(((found - seen) ** 2).sum(axis=2).mean()) < 0.002
