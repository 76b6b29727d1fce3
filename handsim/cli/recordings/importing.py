"""`handsim recordings`: other people's files in, a summary out."""

import math
from pathlib import Path
from typing import Annotated, Any, Literal, cast

import typer

from handsim.cli.console import (
    Folder,
    JsonFlag,
    help_where_alone,
    note,
    say,
    say_json,
    say_table,
    say_wrapped,
    writable,
)
from handsim.cli.recordings.calibrating import calibrate, map_
from handsim.cli.recordings.cutting import PICTURES, cut
from handsim.cli.waiting import fraction_done
from handsim.wording import number_of

app = typer.Typer()
app.command("map")(map_)
app.command()(calibrate)
app.command()(cut)

_LIGHTS = {"green": "ok", "amber": "look", "red": "STOP"}


@app.command("import")
def import_(
    files: Annotated[list[Path], typer.Argument(help="Files as recorded or published.")],
    format: Annotated[
        str, typer.Option(help="Layout of the files; `handsim recordings formats` lists them.")
    ],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder to write.")],
    map: Annotated[
        Path | None, typer.Option("--map", help="TOML file that says what each column is.")
    ] = None,
    calibration: Annotated[
        Path | None, typer.Option(help="TOML file that turns counts of a glove into angles.")
    ] = None,
    subject: Annotated[
        int | None, typer.Option(help="Number of the subject, from 1; all if left out.")
    ] = None,
    side: Annotated[
        Literal["right", "left"] | None, typer.Option(help="Side of the recorded hand.")
    ] = None,
    units: Annotated[
        Literal["deg", "rad", "counts"] | None, typer.Option(help="Units of the angles.")
    ] = None,
    rate: Annotated[
        float | None, typer.Option(help="Frames a second, where the files hold no times.")
    ] = None,
    bridge: Annotated[
        float, typer.Option(help="Longest gap in a sensor to bridge, in s; none by default.")
    ] = 0.0,
    unwrap: Annotated[bool, typer.Option("--unwrap", help="Take out jumps of 360 deg.")] = False,
    object: Annotated[str, typer.Option(help="What was grasped, where no file says it.")] = "",
    task: Annotated[str, typer.Option(help="What for, where no file says it.")] = "",
    hand_length: Annotated[float | None, typer.Option(help="Of the recorded hand, in m.")] = None,
    hand_breadth: Annotated[float | None, typer.Option(help="Of the recorded hand, in m.")] = None,
) -> None:
    """Turn files of gloves, markers or keypoints into recordings."""
    from handsim.cli.defaults import hand_size, said_of
    from handsim.recordings.folder import check_folder_target, write_recordings
    from handsim.recordings.importers.import_files import import_recordings
    from handsim.recordings.importers.layout import ImportOptions
    from handsim.recordings.plausibility import anomalies, lines_of

    check_folder_target(output)
    sized = hand_length is not None or hand_breadth is not None
    options = ImportOptions(
        subject=subject,
        side=side,
        units=units,
        column_map=map,
        calibration=calibration,
        hand=hand_size(hand_length, hand_breadth, side or "right") if sized else None,
        bridge_s=bridge,
        rate_hz=rate,
        object=object,
        task=task,
        unwrap=unwrap,
    )
    with fraction_done("importing"):
        recordings = import_recordings(files, format, options=options)
        write_recordings(recordings, output)
    for line in (*said_of(recordings), *lines_of(anomalies(recordings))):
        note(line)
    note(f"wrote {number_of(len(recordings), 'recording')} to {output}")


@app.command()
def formats(json: JsonFlag = False) -> None:
    """List the layouts of files that can be imported."""
    from handsim.recordings.importers.import_files import layout_named, layouts

    known = [layout_named(name) for name in layouts()]
    if json:
        say_json(
            {
                "formats": [
                    {"name": each.name, "summary": each.summary, "options": sorted(each.options)}
                    for each in known
                ]
            }
        )
        return
    width = max(len(each.name) for each in known)
    for each in known:
        say(f"{each.name:<{width}}  {each.summary}")


@app.command()
def info(
    folder: Folder = None,
    plot: Annotated[Path | None, typer.Option(help="Picture of all joints to draw, .png.")] = None,
    json: JsonFlag = False,
) -> None:
    """Show what recordings hold, and whether it can be right."""
    from handsim.cli.defaults import folder_or_built_in
    from handsim.recordings.contents import summarise
    from handsim.recordings.folder import read_recordings

    if plot is not None:
        writable(plot, *PICTURES)
    with fraction_done("reading") as progress:
        recordings = read_recordings(folder_or_built_in(folder), progress)
    summary = summarise(recordings)
    if json:
        say_json(summary)
    else:
        _say_summary(summary)
    if plot is not None:
        from handsim.viewing.figures.recordings_figure import recordings_figure
        from handsim.viewing.figures.style import save_picture

        with fraction_done("drawing"):
            save_picture(recordings_figure(recordings), plot)
        note(f"wrote {plot}")


def _say_summary(summary: dict[str, Any]) -> None:
    ranges, rows = summary.pop("out_of_range"), summary.pop("recordings")
    medians = summary.pop("median_reach")
    for key, value in summary.items():
        say_wrapped(_in_words(value), indent=23, first=f"{key:>21}  ")
    known = [f"{name} {value:.3g}" for name, value in medians.items() if math.isfinite(value)]
    say(f"{'median_reach':>21}  {', '.join(known)}")
    outside = [
        (name, joint["n_frames"], f"{joint['least_deg']:.1f}", f"{joint['greatest_deg']:.1f}")
        for name, joint in ranges.items()
    ]
    if outside:
        say_table(("joint out of range", "frames", "least [deg]", "greatest [deg]"), outside)
    say("")
    say_table(
        ("recording", "frames", "duration [s]", "rate [Hz]", "side", "plausible", "found"),
        [
            (
                *(row["name"], row["frames"], f"{row['duration_s']:.2f}", f"{row['rate_hz']:.1f}"),
                *(row["side"], _LIGHTS[row["light"]]),
                ", ".join(dict.fromkeys(each["kind"] for each in row["warnings"])),
            )
            for row in rows
        ],
    )
    for row in rows:
        for said in row["notes"]:
            say(f"{row['name']}: {said}")
    seen: set[tuple[str, str | None]] = set()
    for row in rows:
        for each in row["warnings"]:
            if (each["kind"], each["joint"]) not in seen:
                seen.add((each["kind"], each["joint"]))
                joint = f", {each['joint']}" if each["joint"] else ""
                say(f"{row['name']}{joint}: {each['kind']}: {each['message']}")


def _in_words(value: object) -> str:
    """Return a value of the summary without brackets and quotes; how many of each in brackets."""
    if isinstance(value, dict):
        entries = cast("dict[object, object]", value).items()
        said = (f"{k} ({v})" if isinstance(v, int) else f"{k} {v}" for k, v in entries)
        return ", ".join(said) or "none"
    if isinstance(value, list | tuple):
        return ", ".join(map(str, cast("list[object]", value))) or "none"
    return str(value)


@app.callback(invoke_without_command=True)
def _group(context: typer.Context) -> None:
    """Import and inspect recordings."""
    help_where_alone(context)
