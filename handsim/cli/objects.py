"""`handsim object`: users' own things, looked at before they are grasped."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from handsim.cli.console import JsonFlag, check_gl, note, say, say_json, say_table, writable

if TYPE_CHECKING:
    from handsim.objects.mesh_import import OwnObject

app = typer.Typer()

UpOption = Annotated[
    Literal["x", "y", "z"] | None,
    typer.Option("--up", help="Axis of the file that points up; its most stable side if left out."),
]
ScaleOption = Annotated[
    float | None, typer.Option("--scale", help="Metres in the file's unit; guessed if left out.")
]
MassOption = Annotated[
    float | None, typer.Option("--mass", help="Mass in kg; that of water of its volume if left out.")
]
PiecesOption = Annotated[
    Path | None, typer.Option("--pieces", help="Folder of ready convex pieces, one mesh each.")
]


@app.command()
def check(
    file: Annotated[Path, typer.Argument(help="Mesh: .obj, .stl, .ply or .off.")],
    up: UpOption = None,
    scale: ScaleOption = None,
    mass: MassOption = None,
    pieces: PiecesOption = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="Picture of the ways to rest, .png.")
    ] = None,
    json: JsonFlag = False,
) -> None:
    """Say whether a mesh can be grasped: closed or mended, its pieces, mass and ways to rest."""
    if output is not None:
        writable(output, ".png")
    check_gl(draws=output is not None)

    from handsim.objects.mesh_import import read_object

    own = read_object(file, mass=mass, scale=scale, up=up, pieces=pieces)
    if output is not None:
        _draw(own, output)
    if json:
        say_json(_as_dict(own))
    else:
        _show(own)


def _as_dict(own: "OwnObject") -> dict[str, Any]:
    return {
        "name": own.object.name,
        "watertight": own.watertight,
        "mended": list(own.mended),
        "guessed": list(own.guessed),
        "scale": own.scale,
        "mass_kg": own.object.mass,
        "volume_m3": own.volume,
        "size_m": list(own.size),
        "n_pieces": len(own.object.colliders),
        "up": list(own.up),
        "resting_poses": [
            {
                "up": list(pose.up),
                "name": pose.name,
                "rise_m": pose.rise,
                "tips_at_deg": pose.tips_at_deg,
            }
            for pose in own.resting
        ],
    }


def _show(own: "OwnObject") -> None:
    size = " x ".join(f"{1000 * side:.0f}" for side in own.size)
    pieces = f"{len(own.object.colliders)} convex piece{'s' * (len(own.object.colliders) != 1)}"
    say(f"{own.object.name}: {size} mm as it stands, {own.object.mass:.3g} kg, {pieces}")
    say("watertight" if own.watertight else "not watertight as it is given")
    for phrase in own.mended:
        say(f"mended: {phrase}")
    for phrase in own.guessed:
        say(f"guessed: {phrase}")
    say_table(
        ("rests with", "tips at [deg]", "rise to tip [mm]"),
        [
            (f"{pose.name} up", f"{pose.tips_at_deg:.0f}", f"{1000 * pose.rise:.2f}")
            for pose in own.resting
        ],
    )


def _draw(own: "OwnObject", output: Path) -> None:
    from handsim.viewing.opengl.backend import choose_backend

    choose_backend()

    from handsim.viewing.film.video import write_image
    from handsim.viewing.resting_sheet import resting_sheet

    write_image(resting_sheet(own), output)
    note(f"wrote {max(1, len(own.resting))} pictures to {output}")


@app.callback()
def _group() -> None:
    """Look at own objects."""
