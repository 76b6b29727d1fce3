"""Where a robot's palm goes first: its fingertips where a person's pads are, clear of the table."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from handsim.grasping.plan import GraspPlan, Pose
from handsim.grasping.robots.robot_clearance import depth_in_table
from handsim.grasping.robots.robot_movement import middle_between
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.rollout.commands import expected_object
from handsim.grasping.rollout.record import Rollout
from handsim.joints import FINGERS, Finger
from handsim.retargeting.retarget import Retargeter
from handsim.types import Array

WAY = 30
"""Postures on the way to a destination, with which it is mapped: as a movement, not by itself."""
TILTS_DEG = (0.0, 10.0, -10.0, 20.0, -20.0, 30.0, -30.0, 45.0, -45.0, 60.0, -60.0)
"""Turns about the line from thumb to fingers that are tried in turn until no part of the robot is
in the table: forearms of robots are thicker than a person's."""
ARRIVALS = (0.6, 0.85)
"""Fractions of the reach at which the palm is in place, each of which is tried."""
CLEAR = 0.001
"""Deepest overlap with the table that counts as none [m]."""
_ALONG = 0.005
"""Length on which directions and backs of fingertips count as much as their places [m]."""


def clear_of_table(retargeter: Retargeter, scene: RobotScene, plan: GraspPlan) -> GraspPlan:
    """Return a plan whose palm is turned so that the robot that follows is not in the table.

    It is turned about the line from thumb to fingers, so that these stay where they are.

    Parameters
    ----------
    retargeter
    scene
        Of the task.
    plan
        Of a person's hand of the robot's side.
    """
    person = retargeter.person.hand
    way = np.linspace(plan.q_start, plan.q_goal, WAY)
    x = retargeter.retarget(way).positions[-1, retargeter.robot.joint_map.free]
    q = plan.q_goal[retargeter.person.glove]
    between = middle_between(person, q[None], scene.gripping)[0]
    middle = plan.palm.pos + plan.palm.rotation.apply(between)
    line = np.array(scene.task.grasp.opposition) / np.linalg.norm(scene.task.grasp.opposition)
    found: list[tuple[float, GraspPlan]] = []
    for degrees in TILTS_DEG:
        turn = Rotation.from_rotvec(np.deg2rad(degrees) * line)
        tried = plan.palm.moved((middle - plan.palm.pos) - turn.apply(middle - plan.palm.pos), turn)
        palm = palm_for(retargeter, tried, plan.q_goal, x, scene.gripping)
        found.append((overlap_with_table(scene, palm, x), replace(plan, palm=tried)))
        if found[-1][0] <= CLEAR:
            break
    return min(found, key=lambda each: each[0])[1]


def palm_at_grasp(run: Rollout) -> Pose:
    """Return where a person's palm is when the squeeze begins, in the frame of the object.

    That is not quite where it was told to be: a hand that lies on its object, or an arm, gave way.
    """
    model = run.model()
    data = mujoco.MjData(model)
    start = next(phase.start for phase in run.phases if phase.name == "squeeze")
    data.qpos[:] = run.qpos[min(int(np.searchsorted(run.time, start)), len(run.time) - 1)]
    mujoco.mj_kinematics(model, data)
    grasped, palm = (
        Pose(data.body(name).xpos.copy(), data.body(name).xquat.copy())
        for name in ("object", "palm")
    )
    back = grasped.rotation.inv()
    turn = (back * palm.rotation).as_quat(scalar_first=True)
    return Pose(back.apply(palm.pos - grasped.pos), turn)


def palm_for(
    retargeter: Retargeter, palm: Pose, q: Array, x: Array, fingers: Sequence[Finger]
) -> Pose:
    """Return the pose of the robot's palm beside that of a person's.

    The robot's fingertips then lie, as well as they can, where the person's pads do, and point the
    same way.

    Parameters
    ----------
    retargeter
    palm, q
        Palm and posture (22,) [rad] of the person at the destination.
    x : (m,)
        Coordinates of the robot there.
    fingers
        Those that grasp, beside the thumb.
    """
    robot, person = retargeter.robot, retargeter.person
    mine, theirs = robot.forward(x), person.hand.forward(q[person.glove])
    chosen: list[Finger] = ["thumb", *fingers]
    own = [robot.fingers.index(finger) for finger in chosen]
    human = [FINGERS.index(finger) for finger in chosen]
    a = _corners(mine.points[own], mine.directions[own], mine.backs[own])
    b = _corners(theirs.points[human], theirs.directions[human], theirs.backs[human])
    turn = Rotation.align_vectors(b - b.mean(axis=0), a - a.mean(axis=0))[0]
    shift = b.mean(axis=0) - turn.apply(a.mean(axis=0))
    return palm @ Pose(shift, turn.as_quat(scalar_first=True))


def overlap_with_table(scene: RobotScene, palm: Pose, x: Array) -> float:
    """Return how deep a robot at the end of its reach is in the table [m].

    Parameters
    ----------
    scene
    palm
        The robot's, in the frame of the object.
    x : (m,)
        Its coordinates.
    """
    return depth_in_table(scene, expected_object(scene.task) @ palm, x)


def _corners(points: Array, directions: Array, backs: Array) -> Array:
    """Return points (3 n, 3) of which fingertips, their directions and backs consist [m]."""
    return np.vstack([points, points + _ALONG * directions, points + _ALONG * backs])
