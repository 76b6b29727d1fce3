"""`handsim render` and `figures`: what can be looked at."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from handsim.cli.console import (
    Accept,
    ControllerFile,
    Folder,
    check_gl,
    note,
    writable,
    writable_folder,
)
from handsim.cli.waiting import fraction_done, keeping
from handsim.wording import number_of

if TYPE_CHECKING:
    from handsim.viewing.film.clip import Clip


def render(
    sources: Annotated[
        list[Path],
        typer.Argument(help="Rollouts (.npz) or posture sequences (.csv); several make a grid."),
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="File: .mp4, .gif or .png.")],
    camera: Annotated[
        str,
        typer.Option(
            help="view, front, side, palm, top, chair, orbit, follow, or the model's own."
        ),
    ] = "view",
    size: Annotated[str, typer.Option(help="Width x height of a movement, in pixels.")] = "640x480",
    fps: Annotated[float, typer.Option(help="Frames a second.")] = 30.0,
    postures: Annotated[int, typer.Option(min=2, help="Pictures in a contact sheet.")] = 8,
    plain: Annotated[bool, typer.Option("--plain", help="Draw in no measurements.")] = False,
    shadows: Annotated[
        bool, typer.Option("--shadows", help="Draw shadows where the CPU draws, too: slower.")
    ] = False,
) -> None:
    """Render movements in true time, as a video or as pictures.

    A .png of one movement becomes its contact sheet.
    """
    writable(output, ".mp4", ".gif", ".png")
    check_gl(draws=True)

    from handsim.viewing.film.offscreen import parse_size
    from handsim.viewing.render import render as draw

    clips = (_clip(source, measurements=not plain) for source in sources)
    with fraction_done("drawing") as progress:
        n = draw(
            clips,
            output,
            camera=camera,
            size=parse_size(size),
            fps=fps,
            n_postures=postures,
            shadows=True if shadows else None,
            progress=progress,
        )
    note(f"wrote {n} {'pictures' if output.suffix.lower() == '.png' else 'frames'} to {output}")


def figures(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the pictures.")],
    controller: ControllerFile = None,
    folder: Folder = None,
    accept: Accept = None,
    paper: Annotated[
        Path | None, typer.Option(help="All of them with their captions, .pdf.")
    ] = None,
) -> None:
    """Draw the counterparts of the paper's figures as PNG and SVG."""
    writable_folder(output)
    if paper is not None:
        writable(paper, ".pdf")
    check_gl(draws=True)

    from handsim.cli.defaults import controller_or_built_in, recordings_or_built_in
    from handsim.viewing.opengl.backend import choose_backend

    learned = controller_or_built_in(controller)
    recordings = recordings_or_built_in(folder, accept, learned)
    choose_backend()

    from handsim.viewing.figures.paper_figures import make_figures

    output.mkdir(exist_ok=True)
    kept = f"figures that were drawn until then are in {output}"
    with keeping(kept), fraction_done("drawing") as progress:
        written = make_figures(learned, recordings, output, progress, pages=paper)
    pictures = [path for path in written if path != paper]
    note(
        f"wrote {number_of(len(pictures), 'picture')} to {output}"
        f"{f', and {paper}' if paper else ''}"
    )


def _clip(source: Path, *, measurements: bool) -> "Clip":
    from handsim.grasping.rollout_file import read_rollout
    from handsim.learning.controller import PostureSequence
    from handsim.recordings.posture_file import read_postures
    from handsim.viewing.render import clip_of

    if source.suffix.lower() == ".csv":
        sequence = PostureSequence(*read_postures(source), arrived=True, reason="")
        return clip_of(sequence, caption=source.stem)
    return clip_of(read_rollout(source), measurements=measurements)
