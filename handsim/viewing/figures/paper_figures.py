"""All counterparts of the paper's figures, drawn from a controller and its recordings."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from handsim.learning.controller import GraspController
from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.scores import roll_out
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.flow import follow
from handsim.navigation.paths import arc_length
from handsim.recordings.recording import SYNTHETIC, Recording, RecordingSet
from handsim.types import Array, Progress
from handsim.viewing.figures.field_figures import field_figure, level_sets_figure
from handsim.viewing.figures.fit_figure import learning_figure
from handsim.viewing.figures.paper_pdf import write_pages
from handsim.viewing.figures.path_figures import (
    components_figure,
    draw_eigengrasps,
    paths_figure,
)
from handsim.viewing.figures.posture_figure import (
    N_POSTURES,
    along_path,
    draw_postures,
    postures_figure,
)
from handsim.viewing.figures.sphere_world import sphere_world_figure
from handsim.viewing.figures.style import SUFFIXES, save_figure
from handsim.viewing.figures.variance_figure import variance_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def make_figures(
    controller: GraspController,
    recordings: RecordingSet,
    folder: Path,
    progress: Progress | None = None,
    *,
    suffixes: Sequence[str] = SUFFIXES,
    pages: Path | None = None,
) -> list[Path]:
    """Draw all figures into a folder; those that need a plane from 2 components up.

    The 2-dimensional ones (1b and 3) show a fit of two components to the same recordings, as the
    paper's do, without refinements: those add samples, and costs before and after do not compare.

    Figures of synthetic recordings say so.

    Parameters
    ----------
    controller, recordings
    folder
    progress
        Called with the fraction done.
    suffixes
        Formats of each.
    pages
        A PDF of all of them with their captions.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    InputError
        If the recordings cannot be learned from.
    MissingToolError
        If nothing renders the hand.
    """
    makers = _makers(controller, recordings)
    written: list[Path] = []

    def made() -> Iterator[tuple[str, "Figure"]]:
        for i, (name, make) in enumerate(makers.items()):
            figure = make()
            if name != "fig1a_spheres" and all(r.subject == SYNTHETIC for r in recordings):
                _say_synthetic(figure)
            written.extend(save_figure(figure, folder, name, suffixes))
            yield name, figure
            if progress:
                progress((i + 1) / len(makers))

    if pages is None:
        for _ in made():
            pass
    else:
        write_pages(made(), pages)
        written.append(pages)
    return written


def _makers(
    controller: GraspController, recordings: RecordingSet
) -> "dict[str, Callable[[], Figure]]":
    """Return what draws each figure, by the names of their files."""
    paths = [controller.subspace.transform(recording.q) for recording in recordings]
    followed = [
        roll_out(controller, path, recording.object).points
        for path, recording in zip(paths, recordings, strict=True)
    ]
    lengths = [arc_length(path)[-1] for path in paths]
    shown = int(np.argsort(lengths)[len(lengths) // 2])  # neither the longest nor the shortest
    glass = next((i for i, r in enumerate(recordings) if r.object == "tall-glass"), shown)
    q = np.vstack([recording.q for recording in recordings])
    plane = PostureSubspace(2).fit(q)
    flat = [plane.transform(recording.q) for recording in recordings]
    learner = DirectionLearner(k=controller.navigation.k, n_refinements=0, n_iterations=150).fit(
        flat
    )
    flat_run = follow(learner.navigation_.directions, flat[shown][:1], flat[shown][-1:])[0]
    reach = 2.0
    figures: dict[str, Callable[[], Figure]] = {
        "fig1a_spheres": sphere_world_figure,
        "fig1b_level_sets": lambda: level_sets_figure(
            learner.navigation_, flat[shown], flat_run.points
        ),
        "fig3_learning": lambda: learning_figure(learner.navigation_, learner.history_),
        "fig4_field": lambda: field_figure(controller.navigation, followed[shown], paths[shown]),
        "fig5_variance": lambda: variance_figure(q, controller.navigation.n_dimensions),
        "fig6_paths": lambda: paths_figure(paths, followed),
        "fig7_components": lambda: components_figure(
            paths, followed, draw_eigengrasps(controller.subspace, reach), reach
        ),
        "fig9_postures": lambda: _postures(controller, recordings[glass], followed[glass]),
    }
    if controller.navigation.n_dimensions == 1:  # neither a plane to slice nor paths in one
        del figures["fig4_field"], figures["fig6_paths"]
    return figures


def _postures(controller: GraspController, recording: Recording, followed: Array) -> "Figure":
    """Draw a recording and the controller's movement posture by posture."""
    path = controller.subspace.transform(recording.q)
    share = arc_length(path) / arc_length(path)[-1]
    rows = [int(np.searchsorted(share, at)) for at in np.linspace(0, 1, N_POSTURES)]
    own = controller.subspace.inverse_transform(along_path(followed))
    pictures = draw_postures(np.vstack([recording.q[np.minimum(rows, len(path) - 1)], own]))
    return postures_figure(pictures[:N_POSTURES], pictures[N_POSTURES:], recording.name)


def _say_synthetic(figure: "Figure") -> None:
    said = figure.get_suptitle()
    if said:
        figure.suptitle(f"{said}; synthetic recordings", x=0.01, ha="left", size=8)
    else:
        figure.suptitle("synthetic recordings", x=0.99, ha="right", size=7, color="#6B7280")
