import numpy as np
import pytest

from handsim.errors import InputError, UnknownNameError
from handsim.hand.anthropometry import HandGeometry
from handsim.hand.population import POPULATIONS, PRESETS, preset, sample_sizes


def test_presets_are_percentiles_of_their_population():
    for name, size in PRESETS.items():
        sex, percentile = name.split("-")
        people = POPULATIONS[sex]
        deviations = {"5": -1.645, "50": 0.0, "95": 1.645}[percentile]
        assert size.length == pytest.approx(np.dot(people.hand_length, [1, deviations]), abs=1.5e-3)
        assert size.breadth == pytest.approx(
            np.dot(people.hand_breadth, [1, deviations]), abs=1.5e-3
        )
        assert HandGeometry(preset(name)).mass > 0.2
    assert len(PRESETS) == 6


@pytest.mark.parametrize("sex", POPULATIONS)
def test_samples_have_the_moments_of_their_population(sex):
    sizes = np.array([(size.length, size.breadth) for size in sample_sizes(20_000, sex, seed=3)])
    people = POPULATIONS[sex]
    means, deviations = np.array([people.hand_length, people.hand_breadth]).T
    assert sizes.shape == (20_000, 2)
    assert np.allclose(sizes.mean(axis=0), means, atol=4 * deviations.max() / np.sqrt(20_000))
    assert np.allclose(sizes.std(axis=0), deviations, rtol=0.03)
    assert np.corrcoef(sizes.T)[0, 1] == pytest.approx(people.correlation, abs=0.03)


def test_same_seed_same_bits():
    assert sample_sizes(50, "man", 1) == sample_sizes(50, "man", 1)
    assert sample_sizes(50, "man", 1) != sample_sizes(50, "man", 2)


def test_unknown_names_are_errors_that_offer_the_nearest():
    with pytest.raises(UnknownNameError, match="man-95"):
        preset("man-96")
    with pytest.raises(UnknownNameError, match="woman"):
        sample_sizes(1, "women", 0)
    with pytest.raises(InputError, match="-1"):
        sample_sizes(-1, "man", 0)
