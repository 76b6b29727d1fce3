"""Mixtures of Gaussians: fitted by scikit-learn, evaluated without its checks of each call."""

import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from sklearn.exceptions import ConvergenceWarning
from sklearn.mixture import GaussianMixture

from handsim.types import Array


@dataclass(frozen=True, eq=False)
class Mixture:
    """A mixture of k Gaussians in d dimensions.

    Attributes
    ----------
    weights : (k,), means : (k, d), covariances : (k, d, d)
    """

    weights: Array
    means: Array
    covariances: Array

    @classmethod
    def of(cls, x: Array, n: int, floor: float) -> Self:
        """Fit n Gaussians to points (N, d); ``floor`` is added to variances."""
        return cls._from(_fitted(x, n, floor))

    @classmethod
    def best(cls, x: Array, most: int) -> Self:
        """Fit 1 to ``most`` Gaussians; return what the Bayesian information criterion prefers."""
        floor = 1e-3 * float(np.mean(np.var(x, axis=0)))
        fits = [_fitted(x, n, floor) for n in range(1, most + 1)]
        return cls._from(min(fits, key=lambda model: model.bic(x)))

    @classmethod
    def _from(cls, model: GaussianMixture) -> Self:
        numbers = (model.weights_, model.means_, model.covariances_)
        return cls(*(np.asarray(each) for each in numbers))

    def over(self, chosen: slice) -> "Mixture":
        """Return the mixture over some of the dimensions."""
        return Mixture(self.weights, self.means[:, chosen], self.covariances[:, chosen, chosen])

    @cached_property
    def precisions(self) -> Array:
        """Inverses of the covariances (k, d, d)."""
        return np.asarray(np.linalg.inv(self.covariances), dtype=np.float64)

    @cached_property
    def _log_heights(self) -> Array:
        return np.log(self.weights) - 0.5 * np.linalg.slogdet(self.covariances)[1]

    def shares(self, x: Array) -> Array:
        """Return the posterior of each Gaussian (N, k) at points (N, d)."""
        away = x[:, None] - self.means
        squares = np.sum(np.einsum("nki,kij->nkj", away, self.precisions) * away, axis=2)
        log_shares = self._log_heights - 0.5 * squares
        shares = np.exp(log_shares - log_shares.max(axis=1, keepdims=True))
        return shares / shares.sum(axis=1, keepdims=True)


def _fitted(x: Array, n: int, floor: float) -> GaussianMixture:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return GaussianMixture(n, reg_covar=floor, random_state=0).fit(x)
