"""`handsim hand`: models of the hand as files, and robot hands as users bring them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from handsim.cli.console import check_gl, help_where_alone, note, say, writable, writable_folder
from handsim.cli.waiting import fraction_done
from handsim.wording import number_of

if TYPE_CHECKING:
    from handsim.grasping.conditions import Conditions
    from handsim.grasping.planning.grasper import Grasper
    from handsim.grasping.robots.robot_grasper import RobotGrasper
    from handsim.retargeting.robot_hand import RobotHand
    from handsim.types import Base

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
    for line in robot.notes:
        note(line)
    moving = number_of(len(robot.lower), "coordinate moves", "coordinates move")
    say(f"{robot.side} hand, {moving} {number_of(len(robot.joint_names), 'joint')}")
    say(f"palm: {robot.frames.palm.name}")
    for finger, frame in robot.frames.fingertips.items():
        say(f"{finger}: {frame.name}")
    write_image(picture, output)
    note(f"wrote {output}")
    if not kept:
        write_text(proposal, frames_as_toml(robot.frames))
        note(f"wrote {proposal}; correct it where the picture is wrong, and give it by --map")


@app.callback(invoke_without_command=True)
def _group(context: typer.Context) -> None:
    """Build hand models; inspect robot hands."""
    help_where_alone(context)


def robot_that_grasps(
    file: Path | None, folders: Sequence[Path], *, protocol: str, replay: bool
) -> "RobotHand | None":
    """Read a robot hand, if one is asked for and can do the rest, and say what was mended."""
    from handsim.errors import InputError

    if file is None:
        if folders:
            raise InputError("--folder is about meshes of a robot hand; give its file by --hand")
        return None

    from handsim.grasping.robots.robot_movement import check_opposing
    from handsim.retargeting.robot_hand import RobotHand

    refused = {
        "--replay takes a person's destination": replay,
        "--protocol six-axis pulls at a person's grasp": protocol != "lift",
    }
    for reason in (reason for reason, asked in refused.items() if asked):
        raise InputError(f"{reason}, --hand names a robot's; drop one of the two")
    robot = RobotHand(file, folders=folders)
    check_opposing(robot)
    for line in robot.notes:
        note(line)
    return robot


def base_for(asked: "Base | None", hand: Path | None) -> "Base":
    """Return what carries the hand, a person's or a robot's."""
    from handsim.errors import InputError

    base = asked or ("arm" if hand is None else "free")
    if base == "arm" and hand is not None:
        raise InputError("--base arm is a person's, --hand names a robot's; give free or mounted")
    if base == "mounted" and hand is None:
        raise InputError("--base mounted carries robot hands alone; name one by --hand")
    return base


def say_base(base: "Base") -> None:
    """Say what it means that a hand is on another base than an arm."""
    if base == "free":
        note("the hand flies: a free base moves it with a force that no arm has")
    if base == "mounted":
        from handsim.grasping.robots.robot_mount import MOST_FORCE, MOST_TORQUE, PAYLOAD

        note(
            f"the hand is mounted as on an arm for {PAYLOAD:g} kg: at most {MOST_FORCE:g} N and "
            f"{MOST_TORQUE:g} N m carry it"
        )


def person_beside(robot: "RobotHand", conditions: "Conditions") -> "Conditions":
    """Return conditions for the person whose hand the robot follows."""
    return replace(conditions, hand=replace(conditions.hand, side=robot.side), base="arm")


def robot_grasper(robot: "RobotHand", people: "Grasper", name: str | None) -> "RobotGrasper":
    """Return a grasper with a robot hand; its plans lie where those of the controller do.

    Those by script lie where the built-in controller's do.
    """
    from handsim.cli.defaults import plan_folder
    from handsim.grasping.planning.grasper import ControllerGrasper
    from handsim.grasping.planning.trials.scripted_trials import ScriptedGrasper
    from handsim.grasping.robots.robot_grasper import RobotGrasper
    from handsim.grasping.robots.robot_lead import LearnedLead, ScriptedLead
    from handsim.grasping.sweep.spec import DEMONSTRATOR

    folder = plan_folder(None if name in (None, DEMONSTRATOR) else Path(name))
    if isinstance(people, ControllerGrasper):
        return RobotGrasper(LearnedLead(people), robot, folder, note)
    offsets = people.offsets if isinstance(people, ScriptedGrasper) else None
    return RobotGrasper(ScriptedLead(offsets, fraction_done), robot, folder, note)


def robot_as_dict(robot: "RobotHand", file: Path | None) -> dict[str, Any]:
    """Return what results say of a robot hand."""
    return {
        "robot_hand": {
            "file": str(file),
            "side": robot.side,
            "fingers": list(robot.fingers),
            "joints": len(robot.joint_names),
            "actuators": len(robot.actuator_names),
            "notes": list(robot.notes),
        }
    }
