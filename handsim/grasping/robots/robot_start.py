"""Where a robot's palm goes first: its fingertips where a person's pads are, clear of the table."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from handsim.grasping.plan import GraspPlan, Pose, schedule_for
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.rollout.commands import expected_path
from handsim.joints import FINGERS, Finger
from handsim.retargeting.retarget import Retargeter
from handsim.types import Array

WAY = 30
"""Postures on the way to a destination, with which it is mapped: as a movement, not by itself."""
TILTS_DEG = (0.0, 10.0, -10.0, 20.0, -20.0, 30.0, -30.0, 45.0, -45.0, 60.0, -60.0)
"""Turns about the line from thumb to fingers that are tried in turn until no part of the robot is
in the table: forearms of robots are thicker than a person's."""
CLEAR = 0.001
"""Deepest overlap with the table that counts as none [m]."""
_ALONG = 0.005
"""Length on which directions and backs of fingertips count as much as their places [m]."""


def robot_start(retargeter: Retargeter, scene: RobotScene, plan: GraspPlan) -> GraspPlan:
    """Return the plan of a person's hand with the palm of a robot.

    Parameters
    ----------
    retargeter
    scene
        Of the task.
    plan
        Of a person's hand of the robot's side.
    """
    way = np.linspace(plan.q_start, plan.q_goal, WAY)
    x = retargeter.retarget(way).positions[-1, retargeter.robot.joint_map.free]
    palm = palm_for(retargeter, plan, x, scene.gripping)
    robot = retargeter.robot
    tips = robot.forward(x).points
    others = [robot.fingers.index(finger) for finger in scene.gripping]
    middle = palm.pos + palm.rotation.apply(
        0.5 * (tips[robot.fingers.index("thumb")] + tips[others].mean(axis=0))
    )
    line = np.array(scene.task.grasp.opposition) / np.linalg.norm(scene.task.grasp.opposition)
    found: list[tuple[float, GraspPlan]] = []
    for degrees in TILTS_DEG:
        turn = Rotation.from_rotvec(np.deg2rad(degrees) * line)
        pos = middle + turn.apply(palm.pos - middle)
        tried = replace(plan, palm=Pose(pos, (turn * palm.rotation).as_quat(scalar_first=True)))
        found.append((overlap_with_table(scene, tried, x), tried))
        if found[-1][0] <= CLEAR:
            break
    return min(found, key=lambda each: each[0])[1]


def palm_for(
    retargeter: Retargeter, plan: GraspPlan, x: Array, fingers: Sequence[Finger]
) -> Pose:
    """Return the pose of the robot's palm for the plan of a person's hand.

    The robot's fingertips then lie, as well as they can, where the person's pads do, and point the
    same way.

    Parameters
    ----------
    retargeter
    plan
    x : (m,)
        Coordinates of the robot at the destination.
    fingers
        Those that grasp, beside the thumb.
    """
    robot, person = retargeter.robot, retargeter.person
    mine, theirs = robot.forward(x), person.hand.forward(plan.q_goal[person.glove])
    chosen: list[Finger] = ["thumb", *fingers]
    own = [robot.fingers.index(finger) for finger in chosen]
    human = [FINGERS.index(finger) for finger in chosen]
    a = _corners(mine.points[own], mine.directions[own], mine.backs[own])
    b = _corners(theirs.points[human], theirs.directions[human], theirs.backs[human])
    turn, _ = Rotation.align_vectors(b - b.mean(axis=0), a - a.mean(axis=0))
    shift = b.mean(axis=0) - turn.apply(a.mean(axis=0))
    return plan.palm @ Pose(shift, turn.as_quat(scalar_first=True))


def overlap_with_table(scene: RobotScene, plan: GraspPlan, x: Array) -> float:
    """Return how deep a robot at the end of its reach is in the table [m].

    Parameters
    ----------
    scene
    plan
    x : (m,)
        Its coordinates there.
    """
    model, data = scene.model, scene.data
    schedule = schedule_for(scene.task)
    palm = expected_path(plan, scene.task, schedule).at(schedule.reach)
    mujoco.mj_resetData(model, data)
    free = int(model.joint("forearm").qposadr[0])
    data.qpos[free : free + 7] = np.concatenate([palm.pos, palm.quat])
    data.qpos[scene.joint_index] = scene.robot.joint_positions(x)
    mujoco.mj_forward(model, data)
    table, hand = model.geom("table").id, model.body_rootid[model.body("forearm").id]
    contact = data.contact
    pairs = contact.geom
    roots = model.body_rootid[model.geom_bodyid[pairs]]
    touching = (pairs == table).any(axis=1) & (roots == hand).any(axis=1)
    return max(0.0, -float(contact.dist[touching].min(initial=0.0)))


def _corners(points: Array, directions: Array, backs: Array) -> Array:
    """Return points (3 n, 3) of which fingertips, their directions and backs consist [m]."""
    return np.vstack([points, points + _ALONG * directions, points + _ALONG * backs])
