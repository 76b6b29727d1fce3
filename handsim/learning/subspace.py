"""The subspace in which people move their hands: principal components of recorded postures.

The paper's Sec. VI-B. Coordinates z = (q - mean) components^T keep Euclidean lengths, so that
distances in the subspace are angles of the whole hand.

LAPACK returns components whose last bits depend on the processor (2e-15 between two kernels,
measured on people's recordings), and a fit would magnify the difference. They are rounded to
2^-30 = 1e-9: a hundred thousand times more than that difference, and a ten-thousandth of the
resolution of a data glove. All that follows is reproducible arithmetic. A number half-way between
two multiples of 2^-30 can still be rounded up on one kind of processor and down on another; this
happens in about one of ten thousand sets of recordings.
"""

from collections.abc import Mapping
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.joints import N_JOINTS
from handsim.learning.base import Estimator
from handsim.reproducible import dots, mean, total, units
from handsim.types import Array
from handsim.wording import number_of

_BITS = 30  # of components and mean, behind the binary point
_NAMES = ("components_", "mean_", "explained_variance_", "explained_variance_ratio_")


class PostureSubspace(Estimator):
    """Principal components of postures: a transformer with scikit-learn's contract.

    Parameters
    ----------
    n_components
        Dimensions of the subspace, 1 to 5.

    Attributes
    ----------
    components_ : (n_components, 22)
        Orthonormal eigengrasps, by falling variance.
    mean_ : (22,) [rad]
    explained_variance_ : (n_components,) [rad^2]
    explained_variance_ratio_ : (n_components,)

    Examples
    --------
    >>> import numpy as np
    >>> q = np.random.default_rng(0).normal(size=(50, 22))
    >>> PostureSubspace(2).fit(q).transform(q).shape
    (50, 2)
    """

    components_: Array
    mean_: Array
    explained_variance_: Array
    explained_variance_ratio_: Array

    def __init__(self, n_components: int = 3) -> None:
        self.n_components = n_components

    def fit(self, q: Array, y: None = None) -> Self:
        """Learn the subspace from postures (n, 22) [rad].

        Parameters
        ----------
        q
        y
            Ignored; pipelines of scikit-learn pass it.

        Raises
        ------
        InputError
            If the number of components is not 1 to 5, or the postures do not vary in as many
            directions.
        """
        self.check_parameters()
        if not 1 <= self.n_components <= 5:
            raise InputError(f"{self.n_components} components; give 1 to 5")
        postures = np.asarray(q, dtype=float)
        if postures.ndim != 2 or postures.shape[1] != N_JOINTS or not np.isfinite(postures).all():
            raise InputError(f"postures of shape {postures.shape}; give finite angles (n, 22)")
        # 1e-6 rad is far below what any glove resolves (1 deg = 1.7e-2 rad).
        deviation = postures - postures.mean(axis=0)
        rank = int(np.sum(np.linalg.svd(deviation, compute_uv=False) > 1e-6 * len(postures) ** 0.5))
        if rank < self.n_components:
            raise InputError(
                f"{len(postures)} postures vary in {number_of(rank, 'direction')}, fewer than the "
                f"{self.n_components} components asked for; record more movements or ask for fewer"
            )
        from sklearn.decomposition import PCA

        pca = PCA(n_components=self.n_components, svd_solver="full").fit(postures)
        self.mean_ = _rounded(mean(postures))
        deviation = postures - self.mean_
        self.components_ = _canonical(np.array(pca.components_, dtype=float), deviation)
        z = self.transform(postures)
        self.explained_variance_ = total(z * z) / (len(z) - 1)
        whole = total(dots(deviation, deviation)) / (len(z) - 1)
        self.explained_variance_ratio_ = self.explained_variance_ / whole
        return self

    def transform(self, q: Array) -> Array:
        """Project postures (..., 22) [rad] to coordinates (..., n_components) [rad].

        Raises
        ------
        NotFittedError
            Before `fit`; as all other use of what was learned.
        """
        deviation = np.asarray(q) - self.mean_
        return dots(deviation[..., None, :], self.components_)

    def inverse_transform(self, z: Array) -> Array:
        """Lift coordinates (..., n_components) [rad] to postures (..., 22) [rad], not clipped."""
        return np.asarray(z) @ self.components_ + self.mean_

    def to_arrays(self) -> dict[str, Array]:
        """Return what was learned, by name, for an archive."""
        return {f"subspace_{name.rstrip('_')}": getattr(self, name) for name in _NAMES}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, npt.NDArray[Any]]) -> "PostureSubspace":
        """Restore what `to_arrays` returned."""
        subspace = cls(len(arrays["subspace_components"]))
        for name in _NAMES:
            setattr(subspace, name, np.array(arrays[f"subspace_{name.rstrip('_')}"], dtype=float))
        return subspace


def _rounded(x: Array) -> Array:
    return np.ldexp(np.rint(np.ldexp(x, _BITS)), -_BITS)


def _canonical(components: Array, deviation: Array) -> Array:
    """Round components (n, 22), and take the tilt of rounding back in reproducible arithmetic.

    One power iteration with the deviations (N, 22) brings them back into the directions in which
    the postures vary, Gram and Schmidt's method makes them orthonormal. The greatest entry of each
    points upwards.
    """
    result = _rounded(components)
    for i, component in enumerate(result):
        greatest = component[np.argmax(np.abs(component))]
        shares = np.sign(greatest) * dots(deviation, component)
        drawn = units(total(shares[:, None] * deviation))
        for other in result[:i]:
            drawn -= dots(drawn, other) * other
        result[i] = units(drawn)
    return result
