"""Poses and quaternions against closed forms."""

import numpy as np

from handsim.recordings.fitting.rigid import best_poses, quaternions_of, rotations_of


def turns(n: int = 200) -> np.ndarray:
    return np.random.default_rng(0).uniform(-3, 3, (n, 3)) / np.sqrt(3)


def test_rotations_are_those_of_scipy() -> None:
    from scipy.spatial.transform import Rotation

    v = np.vstack([turns(), np.zeros((1, 3))])
    assert np.abs(rotations_of(v) - Rotation.from_rotvec(v).as_matrix()).max() < 1e-12


def test_quaternions_are_those_of_scipy_and_do_not_leap() -> None:
    from scipy.spatial.transform import Rotation

    v = turns()
    made = quaternions_of(rotations_of(v))
    theirs = Rotation.from_rotvec(v).as_quat()[:, [3, 0, 1, 2]]
    assert np.abs(np.abs((made * theirs).sum(axis=1)) - 1).max() < 1e-12
    angle = np.linspace(0, 4 * np.pi, 100)
    about = quaternions_of(rotations_of(np.stack([0 * angle, 0 * angle, angle], axis=1)))
    assert about[0, 0] == 1 and np.abs(np.diff(about, axis=0)).max() < 0.1
    missing = rotations_of(v[:4])
    missing[1] = np.nan
    found = quaternions_of(missing)
    assert np.isnan(found[1]).all() and np.isfinite(found[[0, 2, 3]]).all()


def test_best_poses_bring_places_back_and_never_mirror() -> None:
    rng = np.random.default_rng(1)
    places, rotation, position = rng.normal(size=(6, 3)), rotations_of(turns(5)), np.ones((5, 3))
    seen = places @ rotation.swapaxes(1, 2) + position[:, None]
    weights = np.ones((5, 6))
    weights[:, 5] = 0
    seen[:, 5] = 77.0  # of no weight
    found, moved = best_poses(places, seen, weights)
    assert np.abs(found - rotation).max() < 1e-9 and np.abs(moved - position).max() < 1e-9
    mirrored, _ = best_poses(places, seen * [1, 1, -1], weights)
    assert np.allclose(np.linalg.det(mirrored), 1)
