"""Poses of rigid bodies, many at once: rotations, quaternions, and the best pose for given points.

Rotations are (n, 3, 3); a point p of the body is at ``rotation @ p + position``.
"""

import numpy as np

from handsim.types import Array


def best_poses(places: Array, seen: Array, weights: Array) -> tuple[Array, Array]:
    """Return the poses that bring places on a body nearest to where they are seen.

    Least squares by singular values: K. S. Arun, T. S. Huang, S. D. Blostein (1987), IEEE Trans.
    PAMI 9(5):698-700, with the determinant's correction.

    Parameters
    ----------
    places : (m, 3) or (n, m, 3) [m]
        In the body's frame.
    seen : (n, m, 3) [m]
        Finite; where a point is not seen its weight is 0.
    weights : (n, m)

    Returns
    -------
    rotation : (n, 3, 3)
    position : (n, 3) [m]
    """
    share = weights / np.maximum(weights.sum(axis=1, keepdims=True), 1e-12)
    places = np.broadcast_to(places, seen.shape)
    middle_of_places = (share[..., None] * places).sum(axis=1)
    middle_of_seen = (share[..., None] * seen).sum(axis=1)
    spread = (seen - middle_of_seen[:, None]) * share[..., None]
    u, _, vt = np.linalg.svd(spread.swapaxes(1, 2) @ (places - middle_of_places[:, None]))
    handed = np.ones((len(seen), 3))
    handed[:, 2] = np.sign(np.linalg.det(u @ vt))
    rotation = (u * handed[:, None, :]) @ vt
    return rotation, middle_of_seen - apply(rotation, middle_of_places)


def apply(rotation: Array, vectors: Array) -> Array:
    """Return rotated vectors (n, 3), or (n, m, 3) with m a rotation."""
    if vectors.ndim == rotation.ndim:
        return vectors @ rotation.swapaxes(-1, -2)
    return (rotation @ vectors[..., None])[..., 0]


def rotations_of(turns: Array) -> Array:
    """Return the rotations of rotation vectors (n, 3) [rad], (n, 3, 3)."""
    angle = np.linalg.norm(turns, axis=1)[:, None, None]
    x, y, z = turns.T
    zero = np.zeros_like(x)
    skew = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    half = np.sinc(angle / (2 * np.pi))  # sin(angle / 2) / (angle / 2)
    return np.eye(3) + np.sinc(angle / np.pi) * skew + half**2 / 2 * (skew @ skew)


def quaternions_of(rotation: Array) -> Array:
    """Return unit quaternions w, x, y, z of rotations, (n, 4), without leaps from frame to frame.

    The sign is that of the frame before; the first has w >= 0. A rotation of NaN gives NaN.
    """
    n = len(rotation)
    r = rotation
    trace = r[:, 0, 0] + r[:, 1, 1] + r[:, 2, 2]
    # Four ways to the same quaternion; the one with the greatest divisor is the exact one.
    squares = np.stack([trace, r[:, 0, 0], r[:, 1, 1], r[:, 2, 2]], axis=1)
    best = np.argmax(np.where(np.isfinite(squares), squares, -np.inf), axis=1)
    # 4 q q^T, from the rotation's own entries.
    product = np.empty((n, 4, 4))
    product[:, 0, 0] = 1 + trace
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        product[:, i + 1, i + 1] = 1 + 2 * r[:, i, i] - trace
        product[:, 0, i + 1] = product[:, i + 1, 0] = r[:, k, j] - r[:, j, k]
        product[:, j + 1, k + 1] = product[:, k + 1, j + 1] = r[:, j, k] + r[:, k, j]
    made = product[np.arange(n), best]
    made = made / np.linalg.norm(made, axis=1, keepdims=True)
    known = np.flatnonzero(np.isfinite(made).all(axis=1))
    if len(known):
        signs = np.sign((made[known][1:] * made[known][:-1]).sum(axis=1))
        first = 1.0 if made[known[0], 0] >= 0 else -1.0
        made[known] *= np.cumprod(np.concatenate([[first], np.where(signs < 0, -1, 1)]))[:, None]
    return made
