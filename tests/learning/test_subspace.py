"""Principal components of postures."""

import numpy as np
import pytest
from sklearn.decomposition import PCA

from handsim.errors import InputError
from handsim.learning.subspace import PostureSubspace


def postures(rank: int = 22, n: int = 60) -> np.ndarray:
    rng = np.random.default_rng(0)
    return rng.normal(size=(n, rank)) * np.arange(rank, 0, -1) @ rng.normal(size=(rank, 22))


def test_agrees_with_scikit_learn_and_keeps_lengths() -> None:
    q = postures()
    subspace, pca = PostureSubspace(3).fit(q), PCA(3).fit(q)
    np.testing.assert_allclose(np.abs(subspace.components_), np.abs(pca.components_), atol=1e-9)
    np.testing.assert_allclose(subspace.explained_variance_ratio_, pca.explained_variance_ratio_)
    np.testing.assert_allclose(subspace.components_ @ subspace.components_.T, np.eye(3), atol=1e-12)
    z = np.random.default_rng(1).normal(size=(5, 3))
    np.testing.assert_allclose(subspace.transform(subspace.inverse_transform(z)), z, atol=1e-12)
    lifted = subspace.inverse_transform(z)
    assert np.linalg.norm(lifted[0] - lifted[1]) == pytest.approx(np.linalg.norm(z[0] - z[1]))


def test_postures_of_low_rank_come_back_whole() -> None:
    q = postures(rank=2)
    subspace = PostureSubspace(2).fit(q)
    np.testing.assert_allclose(subspace.inverse_transform(subspace.transform(q)), q, atol=1e-9)
    assert subspace.explained_variance_ratio_.sum() == pytest.approx(1.0)


def test_arrays_round_trip() -> None:
    subspace = PostureSubspace(4).fit(postures())
    again = PostureSubspace.from_arrays(subspace.to_arrays())
    np.testing.assert_array_equal(again.transform(postures()), subspace.transform(postures()))
    assert again.n_components == 4


def test_a_constant_joint_does_no_harm_and_too_little_variation_is_named() -> None:
    q = postures()
    q[:, 7] = 0.3
    lifted = (
        PostureSubspace(3).fit(q).inverse_transform(np.random.default_rng(2).normal(size=(4, 3)))
    )
    np.testing.assert_allclose(lifted[:, 7], 0.3, atol=1e-9)
    with pytest.raises(InputError, match="vary in 2 directions"):
        PostureSubspace(3).fit(postures(rank=2))
    with pytest.raises(InputError, match="vary in 0 directions"):
        PostureSubspace(1).fit(np.tile(q[0], (40, 1)))
    with pytest.raises(InputError, match="vary in 0 directions"):
        PostureSubspace(1).fit(q[:1])
    for bad in (0, 6):
        with pytest.raises(InputError, match="1 to 5"):
            PostureSubspace(bad).fit(q)
    with pytest.raises(InputError, match="finite angles"):
        PostureSubspace(3).fit(q[:, :21])
