import re
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

import imageio.v3 as iio
import numpy as np
import pytest
from matplotlib.figure import Figure
from sklearn.decomposition import PCA

from handsim.joints import UPPER
from handsim.learning.controller import GraspController
from handsim.learning.demonstration import demonstrations_of
from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.learn import learn_controller
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.bspline import TensorBSpline
from handsim.navigation.function import NavigationFunction
from handsim.navigation.obstacle import ExponentialObstacle
from handsim.navigation.paths import at_arc_length
from handsim.navigation.workspace import lay_basis
from handsim.recordings.recording import Recording, RecordingSet
from handsim.types import HandSize
from handsim.viewing.figures import paper_figures
from handsim.viewing.figures.field_figures import SHELLS, field_figure, level_sets_figure
from handsim.viewing.figures.fit_figure import learning_figure
from handsim.viewing.figures.paper_figures import make_figures
from handsim.viewing.figures.paper_pdf import CAPTIONS, write_pages
from handsim.viewing.figures.path_figures import (
    components_figure,
    draw_eigengrasps,
    eigengrasps,
    paths_figure,
)
from handsim.viewing.figures.posture_figure import along_path, postures_figure
from handsim.viewing.figures.slices import level_shell
from handsim.viewing.figures.sphere_world import (
    CENTRES,
    DESTINATION,
    RADII,
    sphere_phi,
    sphere_world_figure,
)
from handsim.viewing.figures.style import BLUE, GREEN, VERMILION, save_figure
from handsim.viewing.figures.variance_figure import cumulative_variance, variance_figure


def closing(seed: int, n: int = 41) -> Recording:
    rng = np.random.default_rng(seed)
    time = np.linspace(0, 1, n)
    share = 10 * time**3 - 15 * time**4 + 6 * time**5
    q = np.outer(share, UPPER * rng.uniform(0.3, 0.7, 22))
    q += np.outer(np.sin(np.pi * share), 0.2 * rng.normal(size=22))
    return Recording(
        f"r{seed}", time, q, seed + 1, "synthetic", "cube", "cube-raise", HandSize(0.19, 0.085)
    )


@pytest.fixture(scope="module")
def recordings() -> RecordingSet:
    return RecordingSet(tuple(closing(seed) for seed in range(5)))


@pytest.fixture(scope="module")
def controller(recordings: RecordingSet) -> GraspController:
    return learn_controller(recordings, n_components=3).controller


@pytest.fixture(scope="module")
def flat(recordings: RecordingSet) -> tuple[DirectionLearner, list[np.ndarray]]:
    """A 2-dimensional fit and its paths."""
    postures = [recording.q for recording in recordings]
    pca = PCA(2).fit(np.vstack(postures))
    paths = [pca.transform(q) for q in postures]
    return DirectionLearner(n_refinements=0, n_iterations=20).fit(paths), paths


def labels(figure: Figure) -> set[str]:
    found = set()
    for axes in figure.axes:
        for name in ("x", "y", "z"):
            found |= (
                {getattr(axes, f"get_{name}label")()} if hasattr(axes, f"{name}axis") else set()
            )
    return found - {""}


def curves(figure: Figure, panel: int, colour: str) -> list[np.ndarray]:
    """Data of the lines of a colour, (n, 2) each; markers alone are left out."""
    lines = [line for line in figure.axes[panel].lines if line.get_color() == colour]
    return [line.get_xydata() for line in lines if line.get_linestyle() != "None"]


def points(figure: Figure, panel: int, colour: str) -> np.ndarray:
    lines = [line for line in figure.axes[panel].lines if line.get_color() == colour]
    return np.vstack([line.get_xydata() for line in lines if line.get_marker() not in ("None", "")])


def test_level_sets_show_both_paths_over_the_whole_workspace(
    flat: tuple[DirectionLearner, list[np.ndarray]],
) -> None:
    learner, paths = flat
    figure = level_sets_figure(learner.navigation_, paths[0], paths[1])
    axes = figure.axes[0]
    obstacle = learner.navigation_.obstacle
    np.testing.assert_allclose(axes.get_xlim(), np.rad2deg([obstacle.lower[0], obstacle.upper[0]]))
    np.testing.assert_allclose(axes.get_ylim(), np.rad2deg([obstacle.lower[1], obstacle.upper[1]]))
    (followed,) = curves(figure, 0, VERMILION)
    np.testing.assert_allclose(followed, np.rad2deg(paths[1]))
    np.testing.assert_allclose(points(figure, 0, VERMILION)[-1], np.rad2deg(paths[0][-1]))
    assert labels(figure) == {"PC 1 [deg]", "PC 2 [deg]", "φ"}
    lowest = axes.collections[0].get_paths()[0]  # of the filled levels
    assert lowest.contains_point(np.rad2deg(paths[0][-1]))


def test_learning_shows_every_iteration(flat: tuple[DirectionLearner, list[np.ndarray]]) -> None:
    learner, _ = flat
    history = learner.history_
    figure = learning_figure(learner.navigation_, history)
    for panel, values in ((1, history.cost), (2, history.gradient_norm), (3, history.change)):
        (curve,) = curves(figure, panel, BLUE)
        np.testing.assert_allclose(curve[:, 0], np.arange(1, len(values) + 1))
        np.testing.assert_allclose(curve[:, 1], values)
    assert {"cost J", "iteration", "ln β", "PC 1 [deg]"} <= labels(figure)


def test_field_shows_three_slices_through_the_destination(controller: GraspController) -> None:
    path = controller.path(*np.array([[d.z_start, d.z_goal] for d in controller.demonstrations])[0])
    recorded = path.points + 0.02
    figure = field_figure(controller.navigation, path.points, recorded)
    space = [axes for axes in figure.axes if hasattr(axes, "zaxis")]
    assert len(space) == 1, "beside a picture in space"
    lines = {line.get_color(): np.column_stack(line.get_data_3d()) for line in space[0].lines[:2]}
    np.testing.assert_allclose(lines["#56B4E9"], np.rad2deg(recorded))
    np.testing.assert_allclose(lines[VERMILION], np.rad2deg(path.points))
    assert len(space[0].collections) == len(SHELLS) + 1, "shells and arrows"
    for panel, pair in enumerate([(0, 1), (0, 2), (1, 2)]):
        goal = np.rad2deg(path.points[-1, pair])
        np.testing.assert_allclose(points(figure, panel, VERMILION)[-1], goal)
        axes = figure.axes[panel]
        assert (axes.get_xlabel(), axes.get_ylabel()) == tuple(f"PC {i + 1} [deg]" for i in pair)


def test_variance_is_that_of_scikit_learn(recordings: RecordingSet) -> None:
    q = np.vstack([recording.q for recording in recordings])
    figure = variance_figure(q, 3)
    heights = [bar.get_height() for bar in figure.axes[0].patches]
    expected = 100 * np.cumsum(PCA().fit(q).explained_variance_ratio_)
    np.testing.assert_allclose(heights, expected, rtol=1e-9)
    assert figure.axes[0].texts[0].get_text() == f"3 components: {expected[2]:.1f} %"


def test_variance_of_few_postures_is_explained_by_fewer_components() -> None:
    fractions = cumulative_variance(np.random.default_rng(0).normal(size=(5, 22)))
    assert fractions.shape == (22,)
    np.testing.assert_allclose(fractions[3:], 1.0)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_paths_are_shown_with_their_ends(n: int) -> None:
    rng = np.random.default_rng(n)
    recorded = [rng.normal(size=(20, n)) for _ in range(6)]
    followed = [path[::2] for path in recorded]
    figure = paths_figure(recorded, followed)
    flat = [i for i, axes in enumerate(figure.axes) if not hasattr(axes, "zaxis")]
    assert len(flat) == (1 if n == 2 else 3)
    for panel in flat:
        for colour, paths in ((BLUE, recorded), (VERMILION, followed)):
            shown = curves(figure, panel, colour)
            assert len(shown) == len(paths)
        pick = [
            int(text[3]) - 1
            for text in (figure.axes[panel].get_xlabel(), figure.axes[panel].get_ylabel())
        ]
        np.testing.assert_allclose(curves(figure, panel, BLUE)[0], np.rad2deg(recorded[0][:, pick]))
        starts = np.rad2deg([path[0, pick] for path in recorded])
        np.testing.assert_allclose(points(figure, panel, GREEN), starts)


def test_components_run_over_normalised_arc_length() -> None:
    rng = np.random.default_rng(0)
    recorded = [rng.normal(size=(20, 2)) for _ in range(3)]
    pictures = [[np.full((8, 8, 3), 40 * j, np.uint8) for j in range(3)] for _ in range(2)]
    figure = components_figure(recorded, recorded, pictures, reach=2.0)
    assert len(figure.axes) == 2 * 3 + 1
    for i in range(2):
        curve = curves(figure, 3 * i, BLUE)[1]
        expected = np.rad2deg(at_arc_length(recorded[1], curve[:, 0])[:, i])
        np.testing.assert_allclose(curve[:, 1], expected)
        assert curve[0, 0] == 0
        assert curve[-1, 0] == 1
        for place, j in ((1, 0), (2, 2)):
            shown = figure.axes[3 * i + place].images[0].get_array()
            np.testing.assert_array_equal(shown, pictures[i][j])
    np.testing.assert_array_equal(figure.axes[6].images[0].get_array(), pictures[0][1])
    titles = [axes.get_title() for axes in figure.axes]
    assert titles == ["", "−2 σ", "+2 σ", "", "", "", "mean"], "the mean is drawn once"


def test_eigengrasps_lie_at_both_ends_of_each_component(recordings: RecordingSet) -> None:
    subspace = PostureSubspace(3).fit(np.vstack([recording.q for recording in recordings]))
    postures = eigengrasps(subspace, 2.0)
    assert postures.shape == (3, 3, 22)
    np.testing.assert_allclose(postures[:, 1], np.tile(subspace.mean_, (3, 1)))
    np.testing.assert_allclose(postures[:, [0, 2]].mean(axis=1), postures[:, 1])
    spread = np.linalg.norm(postures[:, 2] - postures[:, 0], axis=1)
    np.testing.assert_allclose(spread, 4 * np.sqrt(subspace.explained_variance_))


def test_pictures_of_eigengrasps_go_both_ways_from_the_mean(
    rendering: str, controller: GraspController
) -> None:
    pictures = draw_eigengrasps(controller.subspace, size=64)
    assert len(pictures) == 3
    for below, mean, above in pictures:
        np.testing.assert_array_equal(mean, pictures[0][1])
        assert (below != above).any()
        assert (below != mean).any()


@pytest.mark.ci
@pytest.mark.slow
def test_all_figures_in_both_formats(
    rendering: str,
    controller: GraspController,
    recordings: RecordingSet,
    target: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    done: list[float] = []
    titles = []
    original = paper_figures.save_figure

    def save(figure: Figure, folder: Path, name: str, suffixes: Sequence[str]) -> list[Path]:
        titles.append(figure.get_suptitle())
        return original(figure, folder, name, suffixes)

    monkeypatch.setattr(paper_figures, "save_figure", save)
    pages = target / "all.pdf"
    written = make_figures(controller, recordings, target, done.append, pages=pages)
    assert titles[0] == "", "spheres are not recorded"
    assert all("synthetic recordings" in title for title in titles[1:])
    assert "refit of two components" in titles[2]
    assert pages.read_bytes().count(b"/Type /Page ") == 8
    written.remove(pages)
    pages.unlink()
    assert sorted(path.name for path in written) == sorted(path.name for path in target.iterdir())
    stems = {path.stem for path in written}
    assert {stem.split("_")[0] for stem in stems} == {
        *("fig1a", "fig1b", "fig3", "fig4", "fig5", "fig6", "fig7", "fig9"),
    }
    assert stems == set(CAPTIONS)
    assert {path.suffix for path in written} == {".png", ".svg"}
    assert done[-1] == 1.0
    for path in written:
        if path.suffix == ".png":
            image = iio.imread(path, plugin="pillow", mode="L")
            assert min(image.shape) > 400
            assert np.ptp(image) > 200
        else:
            assert ElementTree.parse(path).getroot().tag.endswith("svg")


@pytest.mark.ci
@pytest.mark.slow
def test_one_component_leaves_out_what_needs_a_plane(
    rendering: str, recordings: RecordingSet, target: Path
) -> None:
    subspace = PostureSubspace(1).fit(np.vstack([recording.q for recording in recordings]))
    basis, width = lay_basis([subspace.transform(r.q) for r in recordings], (7,))
    straight = ExponentialObstacle(TensorBSpline(basis, np.zeros(basis.n_coefficients)), width)
    controller = GraspController(
        subspace, NavigationFunction(straight, 4.0), demonstrations_of(recordings, subspace)
    )
    names = {path.stem.split("_")[0] for path in make_figures(controller, recordings, target)}
    assert names == {"fig1a", "fig1b", "fig3", "fig5", "fig7", "fig9"}


def test_same_figure_same_bytes(target: Path, recordings: RecordingSet) -> None:
    q = np.vstack([recording.q for recording in recordings])
    contents = []
    for _ in range(2):
        paths = save_figure(variance_figure(q, 2), target, "a")
        contents.append([path.read_bytes() for path in paths])
    assert contents[0] == contents[1]


def test_shells_are_where_phi_has_the_level(controller: GraspController) -> None:
    navigation, goal = controller.navigation, controller.demonstrations[0].z_goal
    shell = level_shell(navigation, goal, 0.1, 15)
    assert shell.shape == (15, 30, 3)
    phi = navigation.jets(shell.reshape(-1, 3), goal, 0)[0]
    low, high = navigation.obstacle.lower, navigation.obstacle.upper
    edge = 0.1 * (high - low)  # nearer to the walls phi rises within a step of the search
    inner = np.all((shell > low + edge) & (shell < high - edge), axis=-1).ravel()
    assert inner.mean() > 0.2
    np.testing.assert_allclose(phi[inner], 0.1, atol=0.01)
    assert np.all((shell >= low - 1e-9) & (shell <= high + 1e-9))


def test_phi_among_spheres_is_one_on_them_and_least_at_the_destination() -> None:
    assert sphere_phi(DESTINATION[None]) == pytest.approx(0.0)
    turn = np.linspace(0, 2 * np.pi, 50)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    for centre, radius in zip(CENTRES, RADII, strict=True):
        np.testing.assert_allclose(sphere_phi(centre + radius * (1 + 1e-12) * circle), 1, atol=1e-4)
        assert (sphere_phi(centre + 0.9 * radius * circle) == 1).all()
    assert (sphere_phi(1.01 * circle) == 1).all()
    side = np.linspace(-1, 1, 161)
    points = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    phi = sphere_phi(points).reshape(161, 161)
    inner = phi[1:-1, 1:-1]
    around = [phi[1 + i : 160 + i, 1 + j : 160 + j] for i in (-1, 0, 1) for j in (-1, 0, 1)]
    least = (inner == np.min(around, axis=0)) & (inner < 1 - 1e-9)
    assert least.sum() == 1, "there is no other minimum"


def test_pages_hold_figures_at_their_size_above_their_captions(
    target: Path, recordings: RecordingSet
) -> None:
    q = np.vstack([recording.q for recording in recordings])
    path = target / "a.pdf"
    figures = {"fig5_variance": variance_figure(q, 2), "fig1a_spheres": sphere_world_figure(41)}
    sizes = [tuple(figure.get_size_inches()) for figure in figures.values()]
    assert write_pages(figures.items(), path) == 2
    assert [tuple(figure.get_size_inches()) for figure in figures.values()] == sizes
    boxes = re.findall(rb"/MediaBox \[ 0 0 ([0-9.]+) ([0-9.]+) \]", path.read_bytes())
    assert [(round(float(w)), round(float(h))) for w, h in boxes] == [(595, 842)] * 2


def test_postures_stand_one_above_the_other_with_their_share_of_the_way() -> None:
    recorded, followed = (
        [np.full((20, 20, 3), start + i, np.uint8) for i in range(3)] for start in (10, 100)
    )
    figure = postures_figure(recorded, followed, "cup-drink")
    shown = [int(axes.images[0].get_array()[0, 0, 0]) for axes in figure.axes]
    assert shown == [10, 11, 12, 100, 101, 102]
    assert [axes.get_xlabel() for axes in figure.axes[3:]] == ["0.00", "0.50", "1.00"]
    assert [figure.axes[i].get_ylabel() for i in (0, 3)] == ["recording", "controller"]
    np.testing.assert_allclose(along_path(np.array([[0.0], [1], [4]]), 3), [[0], [2], [4]])
