"""`handsim recordings`: other people's files in, a summary out."""

from pathlib import Path
from typing import Annotated

import typer

from handsim.cli.console import Folder, JsonFlag, note, say, say_json, say_table

app = typer.Typer()


@app.command("import")
def import_(
    files: Annotated[list[Path], typer.Argument(help="Files as published.")],
    format: Annotated[str, typer.Option(help="Layout of the files, such as west-rtg.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder to write.")],
    subject: Annotated[int, typer.Option(help="Number of the subject, from 1.")] = 1,
) -> None:
    """Turn published recordings into a folder of CSV files."""
    from handsim.recordings.folder import write_recordings
    from handsim.recordings.importers.import_files import import_recordings

    recordings = import_recordings(files, format, subject)
    write_recordings(recordings, output)
    note(f"wrote {len(recordings)} recordings to {output}")


@app.command()
def info(folder: Folder = None, json: JsonFlag = False) -> None:
    """Show what a folder of recordings holds."""
    from handsim.cli.defaults import recordings_or_built_in
    from handsim.recordings.phases import summarise

    summary = summarise(recordings_or_built_in(folder))
    if json:
        say_json(summary)
        return
    ranges = summary.pop("out_of_range")
    for key, value in summary.items():
        say(f"{key:>16}  {value}")
    say_table(
        ("joint out of range", "frames", "least [deg]", "greatest [deg]"),
        [
            (name, joint["n_frames"], f"{joint['least_deg']:.1f}", f"{joint['greatest_deg']:.1f}")
            for name, joint in ranges.items()
        ],
    )
