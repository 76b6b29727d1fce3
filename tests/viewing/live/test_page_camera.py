import numpy as np
import pytest

from handsim.viewing.live.page_camera import fitted

VIEW = ((1.0, 0.0, 0.5), (0.0, 0.0, 0.1))


def test_wide_windows_see_a_view_as_it_is() -> None:
    np.testing.assert_allclose(fitted(VIEW, 1.5), VIEW)


@pytest.mark.parametrize("aspect", [1.0, 0.5])
def test_narrow_windows_see_as_much_across_and_have_it_higher_up(aspect: float) -> None:
    (place, target), (near, middle) = (np.array(each) for each in (fitted(VIEW, aspect), VIEW))
    away = place - target
    np.testing.assert_allclose(away, 1.3 / aspect * (near - middle))
    np.testing.assert_allclose(target[:2], middle[:2])
    assert target[2] < middle[2]
    height = 2 * np.linalg.norm(away) * np.tan(np.deg2rad(18))
    assert (middle[2] - target[2]) / height == pytest.approx(0.24 * min(1.3 / aspect - 1, 1))
