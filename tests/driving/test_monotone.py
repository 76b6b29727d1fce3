"""Monotone regression against worked examples and scikit-learn's."""

import numpy as np
from sklearn.isotonic import IsotonicRegression

from handsim.driving.monotone import isotonic, isotonic_fit


def test_violators_are_pooled_by_weight() -> None:
    assert isotonic(np.array([1.0, 3.0, 2.0, 4.0])).tolist() == [1.0, 2.5, 2.5, 4.0]
    assert isotonic(np.array([3.0, 0.0, 6.0]), np.array([1.0, 2.0, 1.0])).tolist() == [
        1.0,
        1.0,
        6.0,
    ]
    assert isotonic(np.array([3.0, 2.0, 1.0])).tolist() == [2.0, 2.0, 2.0]


def test_as_scikit_learn_does() -> None:
    rng = np.random.default_rng(0)
    x = np.round(rng.normal(size=300), 1)  # with ties
    y = x + rng.normal(size=300)
    knots, values = isotonic_fit(x, y)
    theirs = IsotonicRegression().fit(x, y)
    np.testing.assert_allclose(values, theirs.predict(knots), atol=1e-12)
    assert (np.diff(knots) > 0).all()
    assert (np.diff(values) >= 0).all()
