"""All counterparts of the paper's figures, drawn from a controller and its recordings."""

from pathlib import Path

import numpy as np

from handsim.learning.controller import GraspController
from handsim.learning.direction.learner import DirectionLearner
from handsim.learning.scores import roll_out
from handsim.learning.subspace import PostureSubspace
from handsim.navigation.flow import follow
from handsim.navigation.paths import arc_length
from handsim.recordings.recording import SYNTHETIC, RecordingSet
from handsim.types import Progress
from handsim.viewing.figures.field_figures import field_figure, level_sets_figure
from handsim.viewing.figures.fit_figure import learning_figure
from handsim.viewing.figures.path_figures import (
    components_figure,
    draw_eigengrasps,
    paths_figure,
)
from handsim.viewing.figures.style import save_figure
from handsim.viewing.figures.variance_figure import variance_figure


def make_figures(
    controller: GraspController,
    recordings: RecordingSet,
    folder: Path,
    progress: Progress | None = None,
) -> list[Path]:
    """Draw all figures into a folder, each as PNG and SVG; those that need a plane from 2 up.

    The 2-dimensional ones (1b and 3) show a fit of two components to the same recordings, as the
    paper's do, without refinements: those add samples, and costs before and after do not compare.

    Figures of synthetic recordings say so.

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
    paths = [controller.subspace.transform(recording.q) for recording in recordings]
    followed = [
        roll_out(controller, path, recording.object).points
        for path, recording in zip(paths, recordings, strict=True)
    ]
    lengths = [arc_length(path)[-1] for path in paths]
    shown = int(np.argsort(lengths)[len(lengths) // 2])  # neither the longest nor the shortest
    q = np.vstack([recording.q for recording in recordings])
    plane = PostureSubspace(2).fit(q)
    flat = [plane.transform(recording.q) for recording in recordings]
    learner = DirectionLearner(k=controller.navigation.k, n_refinements=0, n_iterations=150).fit(
        flat
    )
    flat_run = follow(learner.navigation_.directions, flat[shown][:1], flat[shown][-1:])[0]
    reach = 2.0
    figures = {
        "fig1b_level_sets": lambda: level_sets_figure(
            learner.navigation_, flat[shown], flat_run.points
        ),
        "fig3_learning": lambda: learning_figure(learner.navigation_, learner.history_),
        "fig4_field": lambda: field_figure(controller.navigation, followed[shown]),
        "fig5_variance": lambda: variance_figure(q, controller.navigation.n_dimensions),
        "fig6_paths": lambda: paths_figure(paths, followed),
        "fig7_components": lambda: components_figure(
            paths, followed, draw_eigengrasps(controller.subspace, reach), reach
        ),
    }
    if controller.navigation.n_dimensions == 1:  # neither a plane to slice nor paths in one
        del figures["fig4_field"], figures["fig6_paths"]
    synthetic = all(recording.subject == SYNTHETIC for recording in recordings)
    written: list[Path] = []
    for i, (name, make) in enumerate(figures.items()):
        figure = make()
        if synthetic:
            figure.suptitle("synthetic recordings", x=0.99, ha="right", size=7, color="#6B7280")
        written += save_figure(figure, folder, name)
        if progress:
            progress((i + 1) / len(figures))
    return written
