"""`handsim recordings cut`: reaches out of continuous recordings."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from handsim.cli.console import JsonFlag, note, say_json, say_table, writable
from handsim.cli.waiting import fraction_done
from handsim.wording import number_of

if TYPE_CHECKING:
    from handsim.recordings.cutting.reach import Reach

PICTURES = (".png", ".svg")


def cut(
    folder: Annotated[Path, typer.Argument(help="Folder of continuous recordings.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder to write.")],
    plot: Annotated[Path | None, typer.Option(help="Picture of what was cut.")] = None,
    channel: Annotated[
        str | None, typer.Option(help="Channel whose first movement ends a reach.")
    ] = None,
    times: Annotated[
        Path | None, typer.Option(help="Table file,start_s,end_s of reaches given by hand.")
    ] = None,
    rest_speed: Annotated[
        float | None,
        typer.Option(help="Share of peak speed that is rest; 0.2 for palms, 0.08 for joints."),
    ] = None,
    longest_pause: Annotated[
        float, typer.Option(help="Longest stop on the way that is no grasp, s.")
    ] = 1.0,
    json: JsonFlag = False,
) -> None:
    """Cut the reaches out of continuous recordings.

    In them rest, reach, hold and return follow one another.
    """
    from handsim.errors import InputError
    from handsim.recordings.cutting.cut import cut_out, find_all
    from handsim.recordings.cutting.reach import CutOptions
    from handsim.recordings.cutting.times import read_times
    from handsim.recordings.folder import check_folder_target, read_recordings, write_recordings
    from handsim.viewing.figures.cutting_figure import cutting_figure
    from handsim.viewing.figures.style import save_picture

    if output.resolve() == folder.resolve():
        raise InputError(f"{output}: holds the recordings to be cut; name another folder with -o")
    check_folder_target(output)
    options = CutOptions(rest_speed, longest_pause, channel)
    if plot is not None:
        writable(plot, *PICTURES)
    with fraction_done("reading") as progress:
        recordings = read_recordings(folder, progress)
    given = () if times is None else read_times(times, recordings)
    with fraction_done("cutting") as progress:
        reaches = find_all(recordings, options, given, progress)
    _say(reaches, json=json)
    _note_doubtful(reaches, with_times=times is not None)
    with fraction_done("writing"):
        parts = cut_out(recordings, reaches, given)
        figure = None if plot is None else cutting_figure(recordings, reaches)
        write_recordings(parts, output)
        if figure is not None and plot is not None:
            save_picture(figure, plot)
    without = len(recordings) - len({reach.recording for reach in reaches})
    if without:
        note(f"no reach found in {without} of {len(recordings)} recordings")
    note(f"wrote {number_of(len(parts), 'recording')} to {output}")


def _say(reaches: "tuple[Reach, ...]", *, json: bool) -> None:
    if json:
        say_json({"reaches": [_as_json(reach) for reach in reaches]})
        return
    say_table(
        ("recording", "start [s]", "end [s]", "hold to [s]", "confidence", "cut", "why"),
        [
            (
                reach.recording,
                f"{reach.start_s:.2f}",
                f"{reach.end_s:.2f}",
                f"{reach.hold_end_s:.2f}",
                f"{reach.confidence:.2f}",
                "yes" if reach.certain else "no",
                reach.reason,
            )
            for reach in reaches
        ],
    )


def _as_json(reach: "Reach") -> dict[str, Any]:
    return {
        "recording": reach.recording,
        "start_s": reach.start_s,
        "end_s": reach.end_s,
        "hold_end_s": reach.hold_end_s,
        "confidence": reach.confidence,
        "cut": reach.certain,
        "reason": reach.reason,
        "second": reach.second,
    }


def _note_doubtful(reaches: "tuple[Reach, ...]", *, with_times: bool) -> None:
    """Say which reaches were not cut, and the rows of a table that would settle them."""
    from handsim.recordings.cutting.cut import other_reading

    doubtful = [reach for reach in reaches if not reach.certain]
    for reach in doubtful:
        note(
            f"not cut: {reach.recording} from {reach.start_s:.2f} to {reach.end_s:.2f} s"
            f"{other_reading(reach)}: {reach.reason}"
        )
    if not doubtful:
        return
    where = "the table" if with_times else "a table"
    note(f"to settle this, correct these rows of {where} and give it with --times:")
    note("file,start_s,end_s")
    names = {reach.recording for reach in doubtful}
    for reach in reaches:
        if reach.recording in names:
            note(f"{reach.recording}.csv,{reach.start_s:.2f},{reach.end_s:.2f}")
