"""`handsim export`: movements to pandas, HDF5, LeRobot and rerun."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from handsim.cli.console import JsonFlag, check_gl, note, say_json, say_table, writable
from handsim.cli.waiting import fraction_done

if TYPE_CHECKING:
    from handsim.exports.episode import Episode
    from handsim.exports.export_format import ExportFormat
    from handsim.types import Progress

_OF_FILMS = "320x240"


def export(
    sources: Annotated[
        list[Path],
        typer.Argument(
            help="Rollouts (.npz), posture sequences (.csv), folders of recordings or rollouts."
        ),
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", help=".parquet, .csv, .h5, .rrd; a LeRobot folder.")
    ],
    to: Annotated[
        str | None,
        typer.Option(
            "--to",
            "--format",
            help="pandas (parquet, csv), hdf5, lerobot or rerun; by the name of the output if "
            "left out.",
        ),
    ] = None,
    fps: Annotated[
        int | None, typer.Option(help="Frames a second of a LeRobot data set; as recorded.")
    ] = None,
    video: Annotated[
        bool, typer.Option("--video", help="Film each movement into a LeRobot data set.")
    ] = False,
    camera: Annotated[
        str | None, typer.Option(help="Camera of the films, as of `render`; view if left out.")
    ] = None,
    size: Annotated[
        str | None, typer.Option(help=f"Their width x height in pixels; {_OF_FILMS} if left out.")
    ] = None,
    json: JsonFlag = False,
) -> None:
    """Hand movements on to pandas, HDF5, LeRobot or rerun."""
    from handsim.errors import InputError
    from handsim.exports.export_format import export_format

    chosen = export_format(output, to)
    filming = video or camera is not None or size is not None
    if chosen != "lerobot" and (fps is not None or filming):
        raise InputError(
            f"--fps, --video, --camera and --size are for LeRobot data sets, not for {chosen}; "
            "leave them out"
        )
    if (camera is not None or size is not None) and not video:
        raise InputError("--camera and --size are of films; add --video")
    _check_output(chosen, output)
    check_gl(draws=video)

    from handsim.exports.export_sources import read_sources

    with fraction_done("reading") as progress:
        episodes = read_sources(sources, progress)
    with fraction_done("drawing" if video else "writing") as progress:
        if chosen == "lerobot":
            from handsim.exports.lerobot.data_set import write_lerobot
            from handsim.viewing.film.offscreen import parse_size

            made = write_lerobot(
                episodes,
                output,
                fps=fps,
                camera=(camera or "view") if video else None,
                size=parse_size(size or _OF_FILMS),
                progress=progress,
            )
            more = made.as_dict()
        else:
            more = _write(chosen, episodes, output, progress)
    _say(chosen, episodes, output, more, json=json)


def _check_output(chosen: "ExportFormat", output: Path) -> None:
    """Check, before anything is read, that the output and the libraries are there."""
    from handsim.exports.libraries import library

    if chosen == "lerobot":
        from handsim.exports.lerobot.data_set_layout import check_data_set_folder

        check_data_set_folder(output)
    else:
        writable(output)
    needed = {
        "pandas": ("pandas", *(() if output.suffix.lower() == ".csv" else ("pyarrow",))),
        "hdf5": ("h5py",),
        "lerobot": ("pandas", "pyarrow"),
        "rerun": ("rerun",),
    }
    for name in needed[chosen]:
        library(name)


def _write(
    chosen: "ExportFormat", episodes: "tuple[Episode, ...]", output: Path, progress: "Progress"
) -> dict[str, Any]:
    """Write one file, and return what is to be said of its format alone."""
    if chosen == "pandas":
        from handsim.exports.data_frames import to_frame, write_frame

        frame = to_frame(episodes)
        write_frame(frame, output)
        return {"columns": list(frame.columns)}
    if chosen == "hdf5":
        from handsim.exports.hdf5_file import write_hdf5

        write_hdf5(episodes, output)
        return {"groups": [episode.name for episode in episodes]}
    from handsim.exports.rerun_file import write_rerun

    write_rerun(episodes, output, progress)
    return {}


def _say(
    chosen: "ExportFormat",
    episodes: "tuple[Episode, ...]",
    output: Path,
    more: dict[str, Any],
    *,
    json: bool,
) -> None:
    """Say what was exported; and of a data set, what was done to it."""
    if json:
        rows = [
            {
                "name": each.name,
                "kind": each.kind,
                "task": each.task,
                "sentence": each.sentence,
                "n_samples": len(each.time),
                "duration_s": each.duration,
                "success": each.success,
            }
            for each in episodes
        ]
        say_json({"format": chosen, "output": str(output), "episodes": rows, **more})
    else:
        say_table(
            ("movement", "kind", "task", "samples", "duration [s]", "success"),
            [
                (each.name, each.kind, each.task, len(each.time), f"{each.duration:.2f}",
                 "" if each.success is None else "yes" if each.success else "no")
                for each in episodes
            ],
        )  # fmt: skip
    if more.get("resampled"):
        names, n = more["resampled"], len(more["resampled"])
        note(f"resampled to {more['fps']} frames a second: {names[0]}{_and(n)}")
    if more.get("left_out"):
        names, n = more["left_out"], len(more["left_out"])
        note(f"left out, since not all have it without gaps: {names[0]}{_and(n)}")
    note(f"wrote {len(episodes)} movement{'s' * (len(episodes) != 1)} to {output}")


def _and(n: int) -> str:
    return f" and {n - 1} more" if n > 1 else ""
