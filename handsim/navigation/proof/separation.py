"""Directions that have a positive scalar product with every vector of a set.

If d . v > 0 for all Bernstein coefficients v of a vector field on a cell, the field has no zero
there. Such a d is looked for by the perceptron rule: it is turned towards the vector that it serves
worst (Rosenblatt 1958, Psychol. Rev. 65(6):386-408). Where there is one it is found, if not in
these few rounds then on smaller cells.
"""

import numpy as np

from handsim.reproducible import dots, mean, total, units
from handsim.types import Array, Mask

_ROUNDS = 12


def separable(vectors: Array, least: Array, most: Array, levels: Array) -> Mask:
    """Return on which cells a direction d of length 1 is found with d . v > level for all v.

    Parameters
    ----------
    vectors : (N, n, m)
        m vectors on each of N cells.
    least, most : (N, n)
        Bounds of the components of d, each 0 or infinite.
    levels : (N,)
        Zero or more.
    """
    found = np.zeros(len(vectors), dtype=bool)
    open_ = np.arange(len(vectors))
    each = np.moveaxis(units(np.moveaxis(vectors, 1, 2)), 2, 1)
    d = units(np.clip(mean(each, 2), least, most))
    for _ in range(_ROUNDS):
        products = total(d[:, :, None] * vectors, 1)
        separates = products.min(axis=1) > levels
        found[open_[separates]] = True
        left = ~separates
        if not left.any():
            break
        open_, d, each, vectors = open_[left], d[left], each[left], vectors[left]
        least, most, levels = least[left], most[left], levels[left]
        worst = np.argmin(total(d[:, :, None] * each, 1), axis=1)
        turned = d + each[np.arange(len(d)), :, worst]
        d = units(np.clip(turned, least, most))
    return found


def steepest(matrices: Array) -> Array:
    """Return unit vectors e (N, n) for which e' S e is about the greatest, S (N, n, n) symmetric.

    A shift makes S positive definite, and squaring it a few times leaves the eigenvector of its
    greatest eigenvalue in every column. What e is good for is checked by who asks for it.
    """
    n = matrices.shape[1]
    flat = matrices.reshape(len(matrices), -1)
    scale = np.sqrt(dots(flat, flat))
    scale = np.where(scale > 0.0, scale, 1.0)[:, None, None]
    power = matrices / scale + 1.5 * np.eye(n)
    for _ in range(8):
        power = total(power[:, :, :, None] * power[:, None], 2)
        largest = np.abs(power).reshape(len(power), -1).max(axis=1)
        power = power / largest[:, None, None]
    column = np.argmax(np.abs(np.diagonal(power, axis1=1, axis2=2)), axis=1)
    return units(power[np.arange(len(power)), :, column])
