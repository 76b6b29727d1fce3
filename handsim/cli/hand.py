"""`handsim hand`: models of the hand as files, and robot hands as users bring them."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from handsim.cli.console import check_gl, help_where_alone, note, say, writable, writable_folder
from handsim.cli.waiting import fraction_done

app = typer.Typer()


@app.command()
def build(
    output: Annotated[Path, typer.Option("-o", "--output", help="Folder for the model.")],
    hand_length: Annotated[float | None, typer.Option(help="Hand length in m.")] = None,
    hand_breadth: Annotated[float | None, typer.Option(help="Hand breadth in m.")] = None,
    side: Annotated[Literal["right", "left"], typer.Option(help="Which hand.")] = "right",
) -> None:
    """Write the hand as MJCF that plain MuJoCo loads."""
    if output.exists() or output.parent.exists():  # folders above it are made, too
        writable_folder(output)
    check_gl()

    from handsim.cli.defaults import hand_size
    from handsim.hand.export import write_hand

    size = hand_size(hand_length, hand_breadth, side)
    with fraction_done("building"):
        written = write_hand(size, output)
    note(f"wrote {written}")


@app.command()
def inspect(
    file: Annotated[Path, typer.Argument(help="Robot hand: MJCF (.xml, .mjcf) or URDF.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="Picture, .png.")],
    map_: Annotated[
        Path | None,
        typer.Option("--map", help="TOML with palm and fingertips, instead of proposals."),
    ] = None,
    folder: Annotated[
        list[Path] | None,
        typer.Option("--folder", help="Folder of package:// meshes; may be repeated."),
    ] = None,
) -> None:
    """Read a robot hand, and draw where palm and fingertips seem to be.

    A .toml beside the picture holds the same, to be corrected and given by --map.
    """
    writable(output, ".png")
    check_gl(draws=True)

    from handsim.files import write_text
    from handsim.retargeting.robot_hand import RobotHand
    from handsim.robot_hands.hand_frames import frames_as_toml
    from handsim.viewing.film.video import write_image
    from handsim.viewing.robot_hand_sheet import robot_hand_sheet

    with fraction_done("reading"):
        robot = RobotHand(file, frames=map_, folders=folder or ())
    with fraction_done("drawing"):
        picture = robot_hand_sheet(robot)
    proposal = output.with_suffix(".toml")
    kept = map_ is not None or proposal.exists()
    if not kept:
        writable(proposal)
    write_image(picture, output)
    for line in robot.notes:
        note(line)
    say(f"{robot.side} hand, {len(robot.lower)} coordinates move {len(robot.joint_names)} joints")
    say(f"palm: {robot.frames.palm.name}")
    for finger, frame in robot.frames.fingertips.items():
        say(f"{finger}: {frame.name}")
    note(f"wrote {output}")
    if not kept:
        write_text(proposal, frames_as_toml(robot.frames))
        note(f"wrote {proposal}; correct it where the picture is wrong, and give it by --map")


@app.callback(invoke_without_command=True)
def _group(context: typer.Context) -> None:
    """Build hand models; inspect robot hands."""
    help_where_alone(context)
