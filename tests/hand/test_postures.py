import numpy as np
import pytest

from handsim.errors import UnknownNameError
from handsim.hand.postures import POSTURES, posture
from handsim.joints import LOWER, UPPER


def test_postures_are_within_the_ranges_of_motion():
    assert set(POSTURES) >= {"flat", "rest", "fist", "pinch", "tripod"}
    for q in POSTURES.values():
        assert q.shape == (22,)
        assert np.all((q >= LOWER) & (q <= UPPER))


def test_postures_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        posture("rest")[0] = 1.0


def test_unknown_posture_offers_the_nearest():
    with pytest.raises(UnknownNameError, match="pinch"):
        posture("pinsh")
