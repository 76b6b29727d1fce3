"""The task of raising an object that is not in the table."""

from dataclasses import replace

import numpy as np

from handsim.objects.grasp import Grasp
from handsim.objects.mirror import mirrored, mirrored_grasp
from handsim.objects.object import GraspObject
from handsim.objects.proposals import propose_grasps
from handsim.tasks.task import PassRule, Step, Task
from handsim.types import Side


def lift_task(
    grasp_object: GraspObject, grasp: Grasp | None = None, *, side: Side = "right"
) -> Task:
    """Return the task of raising an object that is not in the table.

    Parameters
    ----------
    grasp_object
        Such as `handsim.objects.mjcf.object_from_mesh` gives.
    grasp
        In the object frame, for the hand of ``side``; by default the best that `propose_grasps`
        finds for it.
    side
        Of the hand that is to grasp.

    Returns
    -------
    Task
        With number 0. The object is turned so that the forearm comes as it does for the tasks of
        the table, 30 deg to the left of straight ahead. Like every task it is written for the right
        hand: for the left it is that of the object's mirror image, which `Task.for_side` mirrors
        back, so that the hand meets the object as it is.
    """
    grasp = grasp or propose_grasps(grasp_object, side)[0].grasp
    if side == "left":
        grasp_object = replace(mirrored(grasp_object), handed=True)
        grasp = mirrored_grasp(grasp)
    azimuth = np.rad2deg(np.arctan2(grasp.opposition[1], grasp.opposition[0]))
    return Task(
        number=0,
        name=f"{grasp_object.name}-lift",
        object_name=grasp_object.name,
        grasp=grasp,
        action="raise",
        steps=(Step(0.8, shift=(0.0, 0.0, 0.12)),),
        rule=PassRule("carry"),
        yaw_deg=float(30.0 - azimuth),
        own_object=grasp_object,
    )
