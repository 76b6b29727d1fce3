"""What a task asks for, as a sentence that a person would say to whom they hand the thing."""

from handsim.errors import UnknownNameError
from handsim.tasks.table_one import task_by_name
from handsim.tasks.task import Action

_DOES: dict[Action, str] = {
    "drink": "drink from it",
    "click": "click its button",
    "write": "write with it",
    "operate": "turn it",
    "unscrew": "unscrew its lid",
    "staple": "staple with it",
}
"""What is done, where it is not the action's name and "it"."""


def sentence_of(task: str, grasped: str = "") -> str:
    """Return a task as a sentence.

    Parameters
    ----------
    task
        Name of a task; any other word for what is done will do, or none.
    grasped
        Name of what is grasped, where the task is not one of Table I.
    """
    try:
        known = task_by_name(task)
    except UnknownNameError:
        return _of_words(task, grasped)
    thing = known.object_name.replace("-", " ")
    words = task.removeprefix(known.object_name).strip("-").split("-")[:-1]
    does = _DOES.get(known.action, f"{known.action} it")
    if known.action == "click":
        return f"Grasp the {thing} and click its {' '.join(words)} button."
    side = next((word for word in words if word in ("top", "side")), "")
    return f"Grasp the {thing}{f' from the {side}' if side else ''} and {does}."


def _of_words(task: str, grasped: str) -> str:
    thing, done = (text.replace("-", " ").replace("_", " ").strip() for text in (grasped, task))
    if not thing and not done:
        return "Move the hand."
    if not thing or thing in done:
        return f"{done[:1].upper()}{done[1:]}."
    return f"Grasp the {thing}{f': {done}' if done else ''}."
