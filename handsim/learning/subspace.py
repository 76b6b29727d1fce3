"""The subspace in which people move their hands: principal components of recorded postures.

The paper's Sec. VI-B. Coordinates z = (q - mean) components^T keep Euclidean lengths, so that
distances in the subspace are angles of the whole hand.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.joints import N_JOINTS

Array = npt.NDArray[np.float64]

_NAMES = ("components_", "mean_", "explained_variance_", "explained_variance_ratio_")


class PostureSubspace:
    """Principal components of postures, after scikit-learn's PCA.

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

    def fit(self, q: Array) -> "PostureSubspace":
        """Learn the subspace from postures (n, 22) [rad].

        Raises
        ------
        InputError
            If the number of components is not 1 to 5, or the postures do not vary in as many
            directions.
        """
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
                f"{len(postures)} postures vary in {rank} directions, fewer than the "
                f"{self.n_components} components asked for; record more movements or ask for fewer"
            )
        from sklearn.decomposition import PCA

        pca = PCA(n_components=self.n_components, svd_solver="full").fit(postures)
        for name in _NAMES:
            setattr(self, name, np.array(getattr(pca, name), dtype=float))
        return self

    def transform(self, q: Array) -> Array:
        """Project postures (..., 22) [rad] to coordinates (..., n_components) [rad]."""
        return (np.asarray(q) - self.mean_) @ self.components_.T

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
