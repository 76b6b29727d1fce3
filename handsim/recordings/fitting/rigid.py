"""Poses of rigid bodies, many at once: rotations, quaternions, and the best pose for given points.

Rotations are (n, 3, 3); a point p of the body is at ``rotation @ p + position``.
"""

import numpy as np
from scipy.spatial.transform import Rotation

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
    return Rotation.from_rotvec(turns).as_matrix()


def quaternions_of(rotation: Array) -> Array:
    """Return unit quaternions w, x, y, z of rotations, (n, 4), without leaps from frame to frame.

    The sign is that of the frame before; the first has w >= 0. A rotation of NaN gives NaN.
    """
    made = np.full((len(rotation), 4), np.nan)
    known = np.flatnonzero(np.isfinite(rotation).all(axis=(1, 2)))
    if len(known):
        quaternions = Rotation.from_matrix(rotation[known]).as_quat(scalar_first=True)
        signs = np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0, -1.0, 1.0)
        first = 1.0 if quaternions[0, 0] >= 0 else -1.0
        made[known] = quaternions * np.cumprod(np.concatenate([[first], signs]))[:, None]
    return made
