"""`handsim tasks`: what can be asked of `handsim grasp --task`."""

from typing import TYPE_CHECKING, Any

from handsim.cli.console import JsonFlag, say, say_json, say_wrapped

if TYPE_CHECKING:
    from handsim.tasks.task import Task


def tasks(json: JsonFlag = False) -> None:
    """List the tasks: what is grasped and how, and their rules."""
    from handsim.tasks.table_one import PHONE_TODAY_VIEW, TASKS

    if json:
        say_json(
            {
                "tasks": [_as_dict(task) for task in TASKS],
                "variants": [_as_dict(PHONE_TODAY_VIEW)],
            }
        )
        return
    for task in TASKS:
        _show(task, f"{task.number:>2}")
    say("")
    say_wrapped("Not in the table, but known by name:")
    _show(PHONE_TODAY_VIEW, " -")
    say("")
    say_wrapped(
        "Every grasp also has to be one: thumb and fingers press against each other, and nothing "
        "is pushed, crushed or leaned on. The hand is a right one; a left one does the mirror "
        "image."
    )
    say_wrapped("`handsim grasp --task NAME -o runs` does one, `--task all` all of them.")


def _show(task: "Task", number: str) -> None:
    from handsim.cli.listing.rule_words import rule_in_words

    fingers = ", ".join(("thumb", *task.grasp.fingers))
    say(f"{number}  {task.name:<23}{task.object_name:<12}{task.grasp.kind}: {fingers}")
    say_wrapped(rule_in_words(task), indent=4)


def _as_dict(task: "Task") -> dict[str, Any]:
    """Return a task for JSON: SI units, angles in degrees as their names say."""
    from handsim.cli.listing.rule_words import rule_in_words

    rule = task.rule
    return {
        "number": task.number,
        "name": task.name,
        "object": task.object_name,
        "action": task.action,
        "grasp": {
            "kind": task.grasp.kind,
            "fingers": ["thumb", *task.grasp.fingers],
            "width_m": task.grasp.width,
        },
        "rule": {
            "sentence": rule_in_words(task),
            "kind": rule.kind,
            "lift_m": rule.lift,
            "hold_s": rule.hold,
            "slip_m": rule.slip,
            "tilt_deg": rule.tilt_deg,
            "angle_deg": rule.angle_deg,
            "distance_m": rule.distance,
            "joint": rule.joint,
            "pressed": [{"body": p.body, "fingers": list(p.fingers)} for p in rule.pressed],
            "table_force_n": rule.table_force,
        },
    }


def asked_tasks(name: str, left_out: str | None) -> "list[Task]":
    """Return the task of a name, or all, or of these those of an object that is left out.

    Raises
    ------
    UnknownNameError
        If there is no such task or object.
    InputError
        If the task is not of the object.
    """
    from handsim.errors import InputError, UnknownNameError
    from handsim.tasks.table_one import TASKS, task_by_name

    tasks = list(TASKS) if name == "all" else [task_by_name(name)]
    if left_out is None:
        return tasks
    of_object = [task for task in TASKS if task.object_name == left_out]
    if not of_object:
        objects = dict.fromkeys(task.object_name for task in TASKS)
        raise UnknownNameError("object", left_out, tuple(objects))
    tasks = [task for task in tasks if task in of_object]
    if not tasks:
        named = ", ".join(task.name for task in of_object)
        raise InputError(
            f"task '{name}' is not of the object left out, {left_out}; give one of {named}, or all"
        )
    return tasks
