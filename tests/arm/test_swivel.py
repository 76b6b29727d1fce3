import numpy as np
import pytest

from handsim.arm.arm_geometry import ArmGeometry
from handsim.arm.chain import angles_at
from handsim.arm.swivel import MOUTH_OF_STATURE, SwivelLaw, fit_swivel, towards_mouth

ARM = ArmGeometry()


def test_towards_the_mouth_four_places_lie_in_a_plane() -> None:
    rng = np.random.default_rng(0)
    wrist = rng.uniform([0.2, -0.2, -0.3], [0.5, 0.2, 0.1], (20, 3))
    swivel = towards_mouth(wrist, ARM.stature)
    elbow = angles_at(wrist, np.eye(3), swivel, ARM.upper_arm, ARM.forearm)[1]
    mouth = np.tile(ARM.stature * np.array(MOUTH_OF_STATURE), (20, 1))
    assert np.linalg.det(np.stack([wrist, elbow, mouth], axis=1)) == pytest.approx(
        np.zeros(20), abs=1e-12
    )
    assert ((elbow * mouth).sum(axis=1) < (wrist * mouth).sum(axis=1)).all()  # away from it


def test_a_fitted_law_has_the_mean_and_most_of_the_slope() -> None:
    rng = np.random.default_rng(1)
    wrists = [rng.uniform(-0.5, 0.5, (40, 3)) for _ in range(200)]
    law = fit_swivel(wrists, [0.4 + each @ [0.3, 0.0, -0.2] for each in wrists])
    assert law.slope == pytest.approx((0.3, 0.0, -0.2), abs=0.02)
    assert law.constant == pytest.approx(0.4, abs=0.02)
    place = np.array([[0.1, 0.2, 0.3]])
    assert law.swivel(place * ARM.reach, ARM) == pytest.approx([0.4 + 0.03 - 0.06], abs=0.02)


def test_few_reaches_tell_the_mean_alone() -> None:
    wrists = [np.array([[0.5, 0.0, 0.0], [0.6, 0.0, 0.0]])]
    law = fit_swivel(wrists, [np.array([0.2, 0.4])])
    assert law.constant == pytest.approx(0.3)
    assert 0 < law.slope[0] < 2.0 * 0.5
    assert law.slope[1] == 0


def test_the_usual_law_is_constant() -> None:
    places = np.array([[0.3, 0.0, 0.0], [0.5, 0.1, -0.2]])
    assert SwivelLaw(0.25).swivel(places, ARM).tolist() == [0.25, 0.25]
