"""One HTML page that shows a controller: data, subspace, learning, proof, scores and grasps.

The page needs nothing but itself: pictures and videos are inside, and the same inputs give the
same page.
"""

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from handsim.files import write_text
from handsim.grasping.rollout.record import Rollout, current_versions
from handsim.learning.certification import certify
from handsim.learning.controller import GraspController
from handsim.learning.guide.choice import LeftOut
from handsim.learning.guide.predictor import GuideSettings
from handsim.learning.scores import evaluate
from handsim.recordings.contents import summarise
from handsim.recordings.recording import SYNTHETIC, RecordingSet
from handsim.types import Array, Progress
from handsim.viewing import html as page
from handsim.viewing.figures.paper_figures import make_figures
from handsim.viewing.figures.paper_pdf import CAPTIONS
from handsim.viewing.film.clips import render_clips
from handsim.viewing.film.offscreen import View
from handsim.viewing.film.rollout_clips import rollout_clip
from handsim.viewing.film.video import write_video
from handsim.wording import number_of

FILM = View(width=360, height=270, fps=12.0, quick=True)
"""Size and rate of the videos, no finer than the page shows them; two dozen of them make a few
megabytes. There is one view of each: a second one in a corner would be a thumbnail."""


def write_report(
    path: Path,
    controller: GraspController,
    recordings: RecordingSet,
    grasps: Sequence[Rollout] = (),
    commands: Sequence[str] = (),
    progress: Progress | None = None,
    planned: Array | None = None,
) -> None:
    """Write the page: verdict, videos and figures first, then tables.

    Parameters
    ----------
    path
        The ``.html`` file, written as a whole or not at all.
    controller, recordings
        What is shown, and what it is compared with.
    grasps
        Runs to be listed and shown as videos.
    commands
        Command lines that make the page, as text.
    progress
        Called with the fraction done.
    planned : (m, n_components) [rad]
        Destinations of plans, which the proof is to cover as well.

    Raises
    ------
    FileError
        If the file cannot be written.
    MissingToolError
        If nothing renders the hand or encodes videos.
    """
    n_steps = 2 + len(grasps)

    def done(steps: float) -> None:
        if progress:
            progress(steps / n_steps)

    found = evaluate(controller, recordings, progress=lambda fraction: done(0.5 * fraction))
    proved = certify(controller, progress=lambda f: done(0.5 + 0.5 * f), planned=planned)
    scores, proof = found.as_dict(), proved.as_dict()
    done(1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        make_figures(
            controller,
            recordings,
            folder,
            lambda fraction: done(1 + fraction),
            suffixes=(".svg",),
        )
        films: list[str] = []
        for i, grasp in enumerate(grasps):
            films.append(_film(grasp, folder))
            done(3 + i)
        sections = [
            ("verdict", "Verdict", _verdict(proof)),
            ("grasps", "Grasps in physics", _videos(grasps, films)),
            ("figures", "Figures", _figures(controller, folder)),
            ("scores", "Against the recordings", _scores(controller, recordings, scores)),
            *([("forces", "Grasps in numbers", _grasps(grasps))] if grasps else []),
            ("data", "Recordings", _data(summarise(recordings), recordings)),
            ("certificate", "Convergence", _certificate(proof)),
            ("subspace", "Subspace", _subspace(controller)),
            ("making", "How this page was made", _making(commands)),
        ]
    text = page.page(
        "Grasp controller", _lead(controller, recordings), _top(scores, proof, grasps), sections
    )
    write_text(path, text)


def _lead(controller: GraspController, recordings: RecordingSet) -> str:
    subspace = controller.subspace
    synthetic = all(recording.subject == SYNTHETIC for recording in recordings)
    beside = "with" if controller.guide and controller.guide.progress else "without"
    guided = f", guided {beside} progress as a coordinate" if controller.guide else ""
    return (
        f"Learned from {number_of(len(controller.demonstrations), 'recording')} by method "
        f"{controller.method}{guided}"
        f"{', certified' if controller.certified else ''}; "
        f"{number_of(len(subspace.components_), 'component')}, "
        f"k = {controller.navigation.k:g}. Compared with {number_of(len(recordings), 'recording')}"
        f"{', all synthetic' if synthetic else ''}."
    )


def _top(scores: dict[str, Any], proof: dict[str, Any], grasps: Sequence[Rollout]) -> str:
    held = sum(grasp.outcome.success for grasp in grasps)
    shown = [
        (f"{scores['n_arrived']} of {scores['n_recordings']}", "movements arrive"),
        (f"{scores['path_error_deg']:.1f}°", "mean path error"),
        (f"{scores['straight_error_deg']:.1f}°", "that of straight lines"),
        (f"{100 * scores['variance_explained']:.1f} %", "of variance in the subspace"),
        ("proven" if proof["certified"] else "not proven", "to arrive from every start"),
    ]
    return page.tiles([*shown, (f"{held} of {len(grasps)}", "grasps succeed")] if grasps else shown)


def _data(data: dict[str, Any], recordings: RecordingSet) -> str:
    durations = data["duration_s"]
    sizes = ", ".join(f"{1000 * a:.0f} × {1000 * b:.0f} mm" for a, b in data["hand_sizes_m"])
    outside = data["n_frames_out_of_range"]
    text = (
        f"{number_of(data['n_recordings'], 'movement')} in {number_of(data['n_frames'], 'frame')}; "
        f"subjects: {_listed(data['subjects'])}. They last {durations['least']:.2f} to "
        f"{durations['greatest']:.2f} s (median {durations['median']:.2f} s). Hand length × "
        f"breadth: {sizes}. {number_of(outside, 'frame')} with an angle outside its joint's range."
    )
    rows = [
        (r.name, r.object, r.task, r.subject, len(r.time), f"{r.duration:.2f}") for r in recordings
    ]
    header = ("recording", "object", "task", "subject", "frames", "duration [s]")
    ranges = [
        (joint, found["n_frames"], f"{found['least_deg']:.1f}", f"{found['greatest_deg']:.1f}")
        for joint, found in data["out_of_range"].items()
    ]
    beyond = ("joint beyond its range", "frames", "least [deg]", "greatest [deg]")
    return page.paragraph(text) + page.table(header, rows, n_text=4) + (
        page.table(beyond, ranges) if ranges else ""
    )  # fmt: skip


def _subspace(controller: GraspController) -> str:
    subspace = controller.subspace
    share = 100 * subspace.explained_variance_ratio_
    sigma = np.rad2deg(np.sqrt(subspace.explained_variance_))
    rows = [
        (f"PC {i + 1}", f"{sigma[i]:.1f}", f"{share[i]:.1f}", f"{share[: i + 1].sum():.1f}")
        for i in range(len(share))
    ]
    header = ("component", "standard deviation [deg]", "variance [%]", "cumulative [%]")
    told = page.paragraph(what_leads(controller.guide, controller.left_out))
    return page.table(header, rows) + told


def what_leads(guide: GuideSettings | None, left_out: LeftOut | None) -> str:
    """Say what a movement follows in the subspace, and why progress is a coordinate or is not.

    Parameters
    ----------
    guide
        Of a controller; None where it follows the flow of the obstacle.
    left_out
        Errors with and without progress as a coordinate; None where they were not compared.
    """
    if guide is None:
        return "A movement follows the flow of the learned obstacle; no path is predicted."
    told = (
        "Progress along it is a coordinate of the field beside the components: a movement may go "
        "back over the way that it came."
        if guide.progress
        else "Where the hand is between start and destination tells how far along it the movement "
        "is; progress is no coordinate of the field."
    )
    said = (
        "A movement follows a guide, which is the path predicted from the recordings for its "
        f"start, destination and object. {told}"
    )
    if left_out is None:
        return said
    return (
        f"{said} On recordings left out the guide is off by {left_out.with_progress:.3f} of a "
        f"straight line's error with that coordinate and by {left_out.without_progress:.3f} "
        "without it."
    )


def _figures(controller: GraspController, folder: Path) -> str:
    """Return the figures that were drawn: a subspace of one component has fewer."""
    other = "" if controller.method == "direction" else f", not {controller.method}"
    note = (
        "A controller file keeps what was learned and not the course of learning: Fig. 1b and 3 "
        "are of a fit of two components to the same recordings, made again for this page by "
        f"method direction{other}."
    )
    drawn = [(folder / f"{name}.svg", caption) for name, caption in CAPTIONS.items()]
    pictures = [page.picture(path, caption) for path, caption in drawn if path.is_file()]
    return page.paragraph(note) + page.figures(pictures)


def _verdict(proof: dict[str, Any]) -> str:
    said = (
        "Proven: from everywhere in the workspace the controller's flow leads to every recorded "
        "destination."
        if proof["certified"]
        else "Not proven: the sufficient condition for convergence everywhere does not hold. That "
        "proves nothing against it; what follows under Convergence was searched."
    )
    return page.paragraph(said, "good" if proof["certified"] else "bad")


def _certificate(proof: dict[str, Any]) -> str:
    k_min = proof["k_min"]
    said = {True: "proven", False: "not proven", None: "none"}
    covers = ", ".join(f"{name} {said[value]}" for name, value in proof["covers"].items())
    rows = [
        ("destinations", covers),
        ("condition for the flow of beta alone", proof["reason"]),
        ("exponent k", f"{proof['k']:g}"),
        ("least k with a proof", "none" if k_min is None else f"{k_min:.3f}"),
        (
            "starts on a grid that arrive by the flow of beta alone",
            f"{proof['arrivals']} of {proof['starts']}",
        ),
        ("minima other than the destinations", len(proof["other_minima"])),
        ("saddles", proof["n_saddles"]),
        ("maxima", proof["n_maxima"]),
    ]
    traps = [
        (trap["destination"], ", ".join(f"{angle:.0f}" for angle in trap["z_deg"]))
        for trap in proof["other_minima"]
    ]
    return page.table(("", "found"), rows, n_text=2) + (
        page.table(("minimum on the way to", "at [deg]"), traps, n_text=2) if traps else ""
    )


def _scores(controller: GraspController, recordings: RecordingSet, scores: dict[str, Any]) -> str:
    known = {demonstration.name for demonstration in controller.demonstrations}
    seen = sum(recording.name in known for recording in recordings)
    what = (
        "From each recording's start to its end: the root mean square distance in the subspace "
        "between the controller's path and the recorded one, at equal shares of arc length; the "
        "same for a straight line, and for the person's other trials with the same object. "
        f"By its name the controller was learned from {seen} of these {len(recordings)} recordings."
    )
    header = (
        *("arrived", "path error [deg]", "straight line [deg]", "people repeat [deg]"),
        "direction error [deg]",
    )
    objects = [
        (row["object"], f"{row['n_arrived']} of {row['n_recordings']}", *_errors(row))
        for row in [*scores["per_object"], {**scores, "object": "all"}]
    ]
    each = [(row["name"], bool(row["arrived"]), *_errors(row)) for row in scores["per_recording"]]
    return (
        page.paragraph(what)
        + page.table(("object", *header), objects)
        + page.table(("recording", *header), each)
    )


def _errors(row: dict[str, Any]) -> tuple[str, ...]:
    keys = ("path_error_deg", "straight_error_deg", "repeatability_deg", "direction_error_deg")
    return tuple("–" if row[key] is None else f"{row[key]:.1f}" for key in keys)


def _videos(grasps: Sequence[Rollout], films: Sequence[str]) -> str:
    if not grasps:
        return page.paragraph("No grasp was simulated for this page.")
    what = (
        "Each task once, without perturbations, in contact physics: the controller drives the 22 "
        "joints, and the task's own rule judges the outcome."
    )
    return page.paragraph(what) + page.films(films)


def _grasps(grasps: Sequence[Rollout]) -> str:
    rows = [
        (
            grasp.task,
            grasp.outcome.success,
            grasp.outcome.reason or "",
            f"{1000 * grasp.outcome.lift_m:.0f}",
            f"{1000 * grasp.outcome.peak_slip_m:.1f}",
            f"{grasp.outcome.peak_tilt_deg:.1f}",
            f"{grasp.outcome.hold_s:.2f}",
            grasp.outcome.contacts,
        )
        for grasp in grasps
    ]
    header = (
        *("task", "success", "reason", "lift [mm]", "slip [mm]", "tilt [deg]", "hold [s]"),
        "parts touching",
    )
    return page.table(header, rows)


def _film(grasp: Rollout, folder: Path) -> str:
    frames = list(render_clips([replace(rollout_clip(grasp), beside=())], FILM))
    path = folder / f"{grasp.task}.mp4"
    write_video(frames, path, FILM.fps)
    outcome = grasp.outcome
    caption = f"{grasp.task}: {'success' if outcome.success else f'failed, {outcome.reason}'}"
    return page.film(path, frames[-1], caption, outcome.success)


def _making(commands: Sequence[str]) -> str:
    versions = page.table(("", "version"), current_versions().items(), n_text=2)
    return (page.listing(commands) if commands else "") + versions


def _listed(counts: dict[str, int]) -> str:
    return ", ".join(f"{name} ({n})" for name, n in counts.items())
