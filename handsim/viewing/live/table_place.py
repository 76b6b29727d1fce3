"""Where an object stands on the table, and how a pointer moves it there.

Nothing here knows of a page, so that all of it can be tried without a browser.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

from handsim.tasks.task import Task
from handsim.types import Array

X_RANGE, Y_RANGE, TURN_RANGE = (-150.0, 150.0), (-200.0, 200.0), (-90.0, 90.0)
"""Where objects can be put: away from the person, to the person's left [mm], and turned [deg]."""


@dataclass(frozen=True)
class TablePlace:
    """Displacement of an object from its usual place.

    Attributes
    ----------
    x, y
        Away from the person and to the person's left [mm].
    turn
        About the vertical, counter-clockwise as seen from above [deg].
    """

    x: float = 0.0
    y: float = 0.0
    turn: float = 0.0

    def within(self) -> "TablePlace":
        """Return the nearest place that objects can be put at, in whole mm and deg."""
        numbers = [
            float(np.clip(round(value), *limits))
            for value, limits in (
                (self.x, X_RANGE), (self.y, Y_RANGE), (self.turn, TURN_RANGE),
            )
        ]  # fmt: skip
        return TablePlace(*numbers)

    def of(self, task: Task) -> Task:
        """Return the task with its object at this place."""
        x, y = task.place
        return replace(
            task,
            place=(x + 0.001 * self.x, y + 0.001 * self.y),
            yaw_deg=task.yaw_deg + self.turn,
        )

    def moved_pose(self, pose: Array) -> Array:
        """Return the pose (7,) of an object at this place, from that at its usual place."""
        turn = Rotation.from_euler("z", self.turn, degrees=True)
        quat = (turn * Rotation.from_quat(pose[3:], scalar_first=True)).as_quat(scalar_first=True)
        return np.array([pose[0] + 0.001 * self.x, pose[1] + 0.001 * self.y, pose[2], *quat])


USUAL_PLACE = TablePlace()


def on_plane(camera: Array, through: Array, height: float) -> Array | None:
    """Return where the ray from a camera through a point meets a horizontal plane, (3,) [m].

    None if it does not meet it before the camera.
    """
    ray = through - camera
    if ray[2] == 0.0 or (height - camera[2]) / ray[2] <= 0.0:
        return None
    return camera + (height - camera[2]) / ray[2] * ray


def dragged(
    before: TablePlace, middle: Array, grabbed: Array, pointer: Array, turning: bool
) -> TablePlace:
    """Return the place of an object that a pointer has moved.

    Parameters
    ----------
    before
        Its place when the pointer took hold.
    middle : (2,) or more [m]
        Where it stood then.
    grabbed, pointer : (2,) or more [m]
        Where the pointer took hold, and where it is now, at the same height.
    turning
        Whether the object turns about its middle and stays where it is.
    """
    if not turning:
        away = 1000.0 * (pointer - grabbed)
        return replace(before, x=before.x + float(away[0]), y=before.y + float(away[1])).within()
    first, second = (np.arctan2(*(each[:2] - middle[:2])[::-1]) for each in (grabbed, pointer))
    turn = (np.rad2deg(second - first) + 180.0) % 360.0 - 180.0
    return replace(before, turn=before.turn + float(turn)).within()
