"""`handsim objects`: the things that tasks are about."""

from typing import TYPE_CHECKING, Any

from handsim.cli.console import JsonFlag, say, say_json, say_wrapped

if TYPE_CHECKING:
    from handsim.objects.object import GraspObject
    from handsim.types import Array


def objects(json: JsonFlag = False) -> None:
    """List the objects: size, mass, pieces, and their tasks."""
    from handsim.objects.catalogue import OBJECTS
    from handsim.tasks.table_one import PHONE_TODAY_VIEW, TASKS

    known = [_as_dict(each) for each in OBJECTS.values()]
    of_table = {task.object_name for task in TASKS}
    for each in known:
        every = (*TASKS, PHONE_TODAY_VIEW)
        each["tasks"] = [task.name for task in every if task.object_name == each["name"]]
    table = [each for each in known if each["name"] in of_table]
    variants = [each for each in known if each["name"] not in of_table]
    if json:
        say_json({"objects": table, "variants": variants})
        return
    for each in table:
        _show(each)
    say("")
    say_wrapped("Not in the table:")
    for each in variants:
        _show(each)
    say("")
    say_wrapped(
        "Sizes are length x breadth x height as it stands or lies on the table; pieces are the "
        "convex ones that touch."
    )
    say_wrapped(
        "`handsim object check FILE` looks at a thing of your own, `handsim grasp --object FILE` "
        "grasps it."
    )


def _show(each: dict[str, Any]) -> None:
    size = " x ".join(f"{1000 * side:.0f}" for side in each["size_m"])
    n_pieces = each["n_pieces"]
    pieces = f"{n_pieces:>2} piece{'s' * (n_pieces != 1)}"
    hinges = f", hinges {', '.join(each['hinges'])}" if each["hinges"] else ""
    say(f"{each['name']:<12}{size:>14} mm {1000 * each['mass_kg']:>4.0f} g {pieces}{hinges}")
    say_wrapped(", ".join(each["tasks"]), indent=4)


def _as_dict(thing: "GraspObject") -> dict[str, Any]:
    """Return an object for JSON, in SI units."""
    linked = [each for link in thing.links for each in link.colliders]
    return {
        "name": thing.name,
        "size_m": _size(thing).tolist(),
        "mass_kg": thing.mass,
        "n_pieces": len(thing.colliders) + len(linked),
        "hinges": [link.hinge.name for link in thing.links],
        "front": thing.front,
        "source": thing.source,
        "tasks": [],
    }


def _size(thing: "GraspObject") -> "Array":
    """Return the sides (3,) [m] of the box around what is seen, hinges at 0."""
    import numpy as np

    from handsim.objects.meshes.shipped_mesh import surface_of

    pieces = (*thing.pieces, *(piece for link in thing.links for piece in link.pieces))
    return np.ptp(np.concatenate([surface_of(piece).vertices for piece in pieces]), axis=0)
