import numpy as np
import pytest

from handsim.joints import JOINT_INDEX, JOINT_NAMES, LOWER, UPPER
from handsim.simulation import manner
from handsim.simulation.closings import REST, posture
from handsim.simulation.manner import USUAL, manner_of

CURLS = [f"{f}_{j}" for f in ("index", "middle", "ring", "little") for j in ("mcp", "pip")]
ALONE = ("thumb_rotation", "thumb_abduction", "wrist_flexion")


@pytest.fixture(scope="module")
def manners():
    return [manner_of(seed) for seed in range(600)]


@pytest.fixture(scope="module")
def off(manners):
    """How far each joint is from rest, by name, (600,) [deg]."""
    rest = np.rad2deg(np.array([each.rest for each in manners]) - REST)
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


def test_reaches_last_as_long_as_peoples(manners):
    reaches = np.array([each.reach for each in manners])
    assert 1.0 <= reaches.min() < 1.02
    assert 1.43 < reaches.max() <= 1.45
    np.testing.assert_array_equal(reaches, np.round(reaches, 2))  # whole readings of the glove
    opened = np.array([each.opened for each in manners])
    assert 0.56 <= opened.min() < 0.57
    assert 0.67 < opened.max() <= 0.68
    assert abs(np.corrcoef(reaches, opened)[0, 1]) < 0.15


def test_a_manner_is_its_seeds_and_not_the_perturbations(manners):
    assert manner_of(5).reach == manners[5].reach
    np.testing.assert_array_equal(manner_of(5).rest, manners[5].rest)
    assert len({each.rest.tobytes() for each in manners}) == 600
    # Perturbations draw from the seed itself; were it the same, friction would follow the curl.
    first = [np.random.default_rng(seed).normal() for seed in range(600)]
    curl = [each.rest[JOINT_INDEX["index_mcp"]] for each in manners]
    assert abs(np.corrcoef(first, curl)[0, 1]) < 0.15


def test_postures_stay_within_the_joints_ranges(monkeypatch):
    monkeypatch.setattr(manner, "SPREAD_REST_DEG", dict.fromkeys(manner.SPREAD_REST_DEG, 90.0))
    rests = np.array([manner_of(seed).rest for seed in range(30)])
    assert (rests >= LOWER).all()
    assert (rests <= UPPER).all()


def test_the_usual_manner_is_rest(manners):
    relaxed = posture(
        (15, 25, 12), thumb_rotation=25, thumb_abduction=20, thumb_mcp=12, thumb_ip=10,
        palm_arch=3, wrist_flexion=5,
    )  # fmt: skip
    np.testing.assert_array_equal(USUAL.rest, relaxed)
    np.testing.assert_array_equal(REST, relaxed)
    assert (USUAL.reach, USUAL.opened) == (1.2, 0.62)
