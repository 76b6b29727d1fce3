"""`handsim object`: users' own things, looked at before they are grasped."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from handsim.cli.console import (
    JsonFlag,
    check_gl,
    help_where_alone,
    note,
    say,
    say_json,
    say_table,
    writable,
)
from handsim.cli.waiting import fraction_done
from handsim.wording import number_of

if TYPE_CHECKING:
    from handsim.grasping.conditions import Conditions
    from handsim.grasping.planning.grasper import ControllerGrasper
    from handsim.grasping.planning.trials.own_object import OwnGrasp
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
    float | None,
    typer.Option("--mass", help="Mass in kg; that of water of its volume if left out."),
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
    """Say whether a mesh can be grasped, and how it would lie.

    It is closed or mended; its pieces, mass and ways to rest are shown.
    """
    if output is not None:
        writable(output, ".png")
    check_gl(draws=output is not None)

    from handsim.objects.mesh_import import read_object

    with fraction_done("reading"):
        own = read_object(file, mass=mass, scale=scale, up=up, pieces=pieces)
    if json:
        say_json(as_dict(own))
    else:
        _show(own)
    if output is not None:
        _draw(own, output)


def as_dict(own: "OwnObject") -> dict[str, Any]:
    """Return what `handsim object check --json` says."""
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

    with fraction_done("drawing"):
        choose_backend()

        from handsim.viewing.film.video import write_image
        from handsim.viewing.resting_sheet import resting_sheet

        write_image(resting_sheet(own), output)
    note(f"wrote {number_of(max(1, len(own.resting)), 'picture')} to {output}")


MOST_JOBS = 4
"""Processes that choose a grasp where none are asked for."""


def default_jobs() -> int:
    """Return one process for each processor, up to `MOST_JOBS`."""
    return min(MOST_JOBS, os.cpu_count() or 1)


def choose_grasp(
    own: "OwnObject", grasper: "ControllerGrasper | None", conditions: "Conditions", jobs: int
) -> "OwnGrasp":
    """Choose a grasp of an own object, by script where no grasper is given, and say which."""
    from handsim.grasping.planning.trials.own_object import grasp_by_controller, grasp_by_script

    with fraction_done("choosing a grasp") as progress:
        if grasper is None:
            chosen = grasp_by_script(own.object, conditions, n_jobs=jobs, progress=progress)
        else:
            chosen = grasp_by_controller(
                grasper, own.object, conditions, n_jobs=jobs, progress=progress
            )
    note(f"chosen: {in_words(chosen)}")
    return chosen


def say_assumed(own: "OwnObject") -> None:
    """Say on standard error what was mended and guessed of an own object."""
    for phrase in own.mended:
        note(f"{own.object.name}: mended: {phrase}")
    for phrase in own.guessed:
        note(f"{own.object.name}: guessed: {phrase}")


_WAYS = {
    "side": "from the side",
    "handle": "by a bar, from the side",
    "edge": "by an upright, from the side",
    "tripod": "from above with three fingertips",
}


def in_words(chosen: "OwnGrasp") -> str:
    """Return which grasp was chosen, and of how many."""
    grasp = chosen.proposal.grasp
    way = _WAYS.get(grasp.kind, "from above")
    said = (
        f"{chosen.task.object_name} {way}, thumb against {number_of(len(grasp.fingers), 'finger')},"
        f" {1000 * grasp.width:.0f} mm apart, {1000 * grasp.point[2]:.0f} mm above the table"
    )
    if not chosen.n_tried:
        return f"{said}, as planned before"
    return f"{said}; {chosen.n_held} of {chosen.n_tried} grasps held when tried by script"


def grasp_as_dict(chosen: "OwnGrasp") -> dict[str, Any]:
    """Return what `handsim grasp --object --json` says beside the verdict."""
    grasp = chosen.proposal.grasp
    return {
        "grasp": {
            "kind": grasp.kind,
            "fingers": ["thumb", *grasp.fingers],
            "width_m": grasp.width,
            "point_m": list(grasp.point),
            "opposition": list(grasp.opposition),
            "approach": list(grasp.approach),
            "firmness": chosen.proposal.firm,
        },
        "grasps_tried": chosen.n_tried,
        "grasps_held_by_script": chosen.n_held,
    }


@app.callback(invoke_without_command=True)
def _group(context: typer.Context) -> None:
    """Look at own objects."""
    help_where_alone(context)
