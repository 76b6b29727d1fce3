import numpy as np
import pytest

from handsim.errors import InputError
from handsim.learning.learn import learn_controller
from handsim.navigation.function import NavigationFunction
from handsim.recordings.recording import RecordingSet
from handsim.types import Array
from handsim.viewing.figures.slices import slice_through


@pytest.fixture(scope="module")
def learned(recordings: RecordingSet) -> tuple[NavigationFunction, Array]:
    """A 3-dimensional navigation function and a destination."""
    controller = learn_controller(recordings, n_components=3).controller
    return controller.navigation, controller.demonstrations[0].z_goal


@pytest.mark.parametrize("components", [(0, 2), (2, 1)])
def test_slices_hold_the_fields(
    learned: tuple[NavigationFunction, Array], components: tuple[int, int]
) -> None:
    navigation, goal = learned
    plane = slice_through(navigation, goal, components, resolution=15)
    phi, flow = plane.phi(navigation, goal), plane.flow(navigation, goal)
    ln_beta = plane.ln_beta(navigation)
    assert phi.shape == ln_beta.shape == (15, 15) and flow.shape == (15, 15, 2)
    z = goal.copy()
    z[list(components)] = plane.first[4], plane.second[9]
    value, gradient = navigation.value_and_gradient(z, goal)
    assert phi[9, 4] == pytest.approx(value)
    downhill = -gradient[list(components)] / np.linalg.norm(gradient)
    np.testing.assert_allclose(flow[9, 4], downhill)
    assert ln_beta[9, 4] == pytest.approx(
        navigation.obstacle.evaluator(navigation.k)(z.tolist())[0]
    )


def test_slices_span_the_workspace(learned: tuple[NavigationFunction, Array]) -> None:
    navigation, goal = learned
    plane = slice_through(navigation, goal, (2, 0), resolution=5)
    low, high = navigation.obstacle.lower, navigation.obstacle.upper
    np.testing.assert_array_equal(plane.points[0], [low[0], goal[1], low[2]])
    np.testing.assert_array_equal(plane.points[-1], [high[0], goal[1], high[2]])


@pytest.mark.parametrize("components", [(0, 0), (0, 3), (-1, 0)])
def test_slices_along_what_is_no_plane(
    learned: tuple[NavigationFunction, Array], components: tuple[int, int]
) -> None:
    with pytest.raises(InputError, match="two different"):
        slice_through(*learned, components)
