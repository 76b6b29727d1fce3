import numpy as np
import pytest

from handsim.grasping.planning import trial_variation as variation
from handsim.grasping.planning.preshapes import REST, posture
from handsim.grasping.planning.trial_variation import USUAL, trial_variation
from handsim.joints import JOINT_INDEX, JOINT_NAMES, LOWER, UPPER

CURLS = [f"{f}_{j}" for f in ("index", "middle", "ring", "little") for j in ("mcp", "pip")]
ALONE = ("thumb_rotation", "thumb_abduction", "wrist_flexion")


@pytest.fixture(scope="module")
def variations():
    return [trial_variation(seed) for seed in range(600)]


@pytest.fixture(scope="module")
def off(variations):
    """How far each joint is from rest, by name, (600,) [deg]."""
    rest = np.rad2deg(np.array([each.rest for each in variations]) - REST)
    return dict(zip(JOINT_NAMES, rest.T, strict=True))


def test_fingers_curl_together_and_each_other_joint_varies_by_itself(off):
    for name in JOINT_NAMES:
        if name in CURLS:
            np.testing.assert_allclose(off[name], off["index_mcp"], atol=1e-9)
        elif name not in ALONE:
            np.testing.assert_allclose(off[name], 0.0, atol=1e-9)
    apart = np.corrcoef([off[name] for name in ("index_mcp", *ALONE)])
    assert np.abs(apart - np.eye(4)).max() < 0.15


@pytest.mark.parametrize(
    ("name", "spread"),
    [("ring_pip", 6), ("thumb_rotation", 7), ("thumb_abduction", 4), ("wrist_flexion", 5)],
)
def test_joints_vary_by_their_standard_deviations_about_rest(off, name, spread):
    assert off[name].std() == pytest.approx(spread, rel=0.1)
    assert off[name].mean() == pytest.approx(0.0, abs=0.15 * spread)


def test_reaches_last_as_long_as_peoples(variations):
    reaches = np.array([each.reach for each in variations])
    assert 1.0 <= reaches.min() < 1.02
    assert 1.43 < reaches.max() <= 1.45
    np.testing.assert_array_equal(reaches, np.round(reaches, 2))  # whole readings of the glove
    peak_aperture_at = np.array([each.peak_aperture_at for each in variations])
    assert 0.56 <= peak_aperture_at.min() < 0.57
    assert 0.67 < peak_aperture_at.max() <= 0.68
    assert abs(np.corrcoef(reaches, peak_aperture_at)[0, 1]) < 0.15


def test_a_variation_depends_on_its_seed_and_not_on_the_perturbations(variations):
    assert trial_variation(5).reach == variations[5].reach
    np.testing.assert_array_equal(trial_variation(5).rest, variations[5].rest)
    assert len({each.rest.tobytes() for each in variations}) == 600
    # Perturbations draw from the seed itself; were it the same, friction would follow the curl.
    first = [np.random.default_rng(seed).normal() for seed in range(600)]
    curl = [each.rest[JOINT_INDEX["index_mcp"]] for each in variations]
    assert abs(np.corrcoef(first, curl)[0, 1]) < 0.15


def test_postures_stay_within_the_joints_ranges(monkeypatch):
    monkeypatch.setattr(
        variation, "SPREAD_REST_DEG", dict.fromkeys(variation.SPREAD_REST_DEG, 90.0)
    )
    rests = np.array([trial_variation(seed).rest for seed in range(30)])
    assert (rests >= LOWER).all()
    assert (rests <= UPPER).all()


def test_the_usual_variation_begins_at_rest(variations):
    relaxed = posture(
        (15, 25, 12), thumb_rotation=25, thumb_abduction=20, thumb_mcp=12, thumb_ip=10,
        palm_arch=3, wrist_flexion=5,
    )  # fmt: skip
    np.testing.assert_array_equal(USUAL.rest, relaxed)
    np.testing.assert_array_equal(REST, relaxed)
    assert (USUAL.reach, USUAL.peak_aperture_at) == (1.2, 0.62)
