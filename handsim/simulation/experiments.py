"""The built-in experiments: the demonstrator's reaches as a virtual data glove reads them.

They stand in for the paper's 24 recordings, which were not published, and are synthetic: made by
script and simulation, not by a person.

``python -m handsim.simulation.experiments FOLDER`` makes them again.
"""

import sys
from pathlib import Path

from handsim.hand.grasp_task import Task
from handsim.hand.tasks import task_by_name
from handsim.motion.recording import Recording, RecordingSet, write_recordings
from handsim.simulation.conditions import Conditions
from handsim.simulation.demonstrator import demonstrate
from handsim.simulation.plan import schedule_for
from handsim.simulation.rollout import Rollout

SUBJECT = "synthetic"
"""What the recordings call the person."""


DEMONSTRATED: tuple[str, ...] = (
    "tall-glass-drink",
    "tall-glass-side-move",
    "tall-glass-top-move",
    "tall-glass-side-rotate",
    "cube-raise",
    "jar-move",
)
"""Tasks whose scripted grasp holds."""


def demonstrated_tasks() -> tuple[Task, ...]:
    """Return the tasks that the demonstrator performs, in the order of Table I."""
    return tuple(task_by_name(name) for name in DEMONSTRATED)


def record(task: Task, rollout: Rollout) -> Recording:
    """Return what the glove read during the reach, from rest to touch."""
    reaching = rollout.time <= schedule_for(task).reach + 1e-9
    return Recording(
        name=task.name,
        time=rollout.time[reaching],
        q=rollout.reading[reaching],
        number=task.number,
        subject=SUBJECT,
        object=task.object_name,
        task=task.name,
        hand_length=rollout.conditions.hand_length,
        hand_breadth=rollout.conditions.hand_breadth,
    )


def built_in_experiments() -> RecordingSet:
    """Make the recordings; each task has the seed of its number in Table I."""
    return RecordingSet(
        tuple(
            record(task, demonstrate(task, Conditions(seed=task.number)))
            for task in demonstrated_tasks()
        )
    )


if __name__ == "__main__":
    write_recordings(built_in_experiments(), Path(sys.argv[1]))
