"""The built-in experiments: the demonstrator's reaches as a virtual data glove reads them.

They stand in for the paper's 24 recordings, which were not published, and are synthetic: made by
script and simulation, not by a person.

``python -m handsim.simulation.experiments FOLDER`` makes them again.
"""

import sys
from pathlib import Path

from handsim.hand.grasp_task import Task
from handsim.hand.tasks import TASK_NAMES, TASKS
from handsim.motion.recording import Recording, RecordingSet, write_recordings
from handsim.simulation.conditions import Conditions
from handsim.simulation.demonstrator import demonstrate
from handsim.simulation.manner import manner_of
from handsim.simulation.rollout import Rollout

SUBJECT = "synthetic"
"""What the recordings call the person."""


DEMONSTRATED: tuple[str, ...] = TASK_NAMES
"""Tasks whose scripted grasp holds: all of Table I."""


def demonstrated_tasks() -> tuple[Task, ...]:
    """Return the tasks that the demonstrator performs, in the order of Table I."""
    return TASKS


def record(task: Task, rollout: Rollout) -> Recording:
    """Return what the glove read during the reach, from rest to touch."""
    reaching = rollout.time <= rollout.phases[1].start + 1e-9
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
    """Make the recordings; rest posture, timing and noise come from the task's number in Table I.

    A demonstration that does not hold is none and is left out.
    """
    runs = (
        (task, demonstrate(task, Conditions(seed=task.number), manner_of(task.number)))
        for task in demonstrated_tasks()
    )
    return RecordingSet(tuple(record(task, run) for task, run in runs if run.outcome.success))


if __name__ == "__main__":
    write_recordings(built_in_experiments(), Path(sys.argv[1]))
