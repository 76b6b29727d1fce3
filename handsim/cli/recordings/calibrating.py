"""`handsim recordings map` and `calibrate`: what columns are, and from counts to angles."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from handsim.cli.console import note, say_table, writable

if TYPE_CHECKING:
    from handsim.recordings.glove.calibration import GloveCalibration


def map_(
    file: Annotated[Path, typer.Argument(help="Table of joint angles or of counts.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Map to write (.toml).")],
    side: Annotated[
        Literal["right", "left"] | None, typer.Option(help="Which hand, if there are two.")
    ] = None,
    units: Annotated[
        Literal["deg", "rad", "counts"] | None, typer.Option(help="Units of the angles.")
    ] = None,
) -> None:
    """Draft what each column of a table is, to be corrected.

    Columns are recognised by the likeness of their names.
    """
    from handsim.files import write_text
    from handsim.recordings.columns.draft import draft_map

    writable(output, ".toml")
    text = draft_map(file, side, units)
    write_text(output, text)
    for line in text.splitlines():
        if line.startswith("# to decide: "):
            note(line.removeprefix("# "))
    note(f"wrote {output}")


def calibrate(
    files: Annotated[list[Path], typer.Argument(help="Raw files of the glove.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Calibration to write (.toml).")],
    postures: Annotated[
        Path | None, typer.Option(help="TOML file that states the angles of each file.")
    ] = None,
    ranges: Annotated[
        bool, typer.Option("--ranges", help="By the whole range of every joint; cruder.")
    ] = False,
) -> None:
    """Calibrate a glove by held postures or by ranges of motion.

    Files of postures are named after them: flat.txt, fist.txt ...
    """
    from handsim.errors import InputError
    from handsim.recordings.glove.calibrate import (
        calibrate_postures,
        calibrate_ranges,
        counts_of_files,
        postures_of_files,
        postures_of_table,
    )
    from handsim.recordings.glove.calibration import write_calibration

    if ranges and postures is not None:
        raise InputError("--ranges and --postures exclude each other; give one of them")
    writable(output, ".toml")
    if ranges:
        names = ", ".join(file.name for file in files)
        made = calibrate_ranges(counts_of_files(files), f"ranges of {names}")
    elif postures is not None:
        made = calibrate_postures(postures_of_table(postures, files))
    else:
        made = calibrate_postures(postures_of_files(files))
    write_calibration(made, output)
    _show(made)
    note(f"wrote {output}: {made.summary}")


def _show(made: "GloveCalibration") -> None:
    from handsim.joints import JOINTS

    rows = [
        (
            joint.name,
            made.how[i],
            *(("", "") if made.how[i] == "none" else
              (f"{made.gain[i]:.3f}", f"{made.offset[i]:.1f}")),
            "" if made.residual[i] != made.residual[i] else f"{made.residual[i]:.2f}",
            "" if made.counts[i, 0] != made.counts[i, 0] else
            f"{made.counts[i, 0]:g} to {made.counts[i, 1]:g}",
        )
        for i, joint in enumerate(JOINTS)
    ]  # fmt: skip
    say_table(
        ("joint", "by", "gain [deg/count]", "offset [deg]", "residual [deg]", "counts seen"), rows
    )
