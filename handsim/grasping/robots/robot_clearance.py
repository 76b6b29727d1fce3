"""How much higher a robot's palm goes than it was told, to keep all of the robot off the table.

Fingertips of robots are thicker than a person's: on their way to what lies flat, and as they close
round it, they would be pressed into the table with all the force of the base.
"""

from dataclasses import replace

import numpy as np

from handsim.grasping.plan import Pose
from handsim.grasping.robots.robot_movement import RobotMovement
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.grasping.rollout.commands import Commands
from handsim.types import Array

UP = np.array([0.0, 0.0, 1.0])
CLEARANCE = 0.003
"""How far above the table it stays: base and fingers swing by about as much [m]."""
RISES = 0.1
"""How fast the palm gives way upwards on its way, and comes down again [m/s]."""
EVERY = 3
"""Of so many readings one is looked at."""
_TOGETHER = 64


def cleared(
    scene: RobotScene, commands: Commands, movement: RobotMovement, arrival: float
) -> Commands:
    """Return commands whose palm stays up as far as keeps the robot off the table.

    From its arrival on the palm neither rises nor sinks: it is as much higher as is ever needed.

    Parameters
    ----------
    scene
    commands
        With the path of the robot's palm, undisturbed.
    movement
        What its coordinates are told, without what forces add.
    arrival
        When the palm is in place [s].
    """
    rows = np.unique(np.append(np.arange(0, commands.action, EVERY), commands.action))
    told = movement.told[rows] + commands.closed[rows, None] * movement.closing
    told = np.clip(told, scene.robot.lower, scene.robot.upper)
    low, turned = commands.palm_pos - CLEARANCE * UP, commands.palm_quat
    needed = np.array(
        [depth_in_table(scene, Pose(low[i], turned[i]), x) for i, x in zip(rows, told, strict=True)]
    )
    times = commands.times
    higher = np.interp(times, times[rows], needed)
    there = times >= arrival
    higher[there] = needed[times[rows] >= arrival].max()
    # Some readings at a time: slow hands have 20 000, and all pairs of them fill gigabytes.
    parts = np.array_split(times, len(times) // _TOGETHER + 1)
    higher = np.concatenate(
        [
            np.maximum(higher - RISES * np.abs(part[:, None] - times), 0.0).max(axis=1)
            for part in parts
        ]
    )
    return replace(commands, palm_pos=commands.palm_pos + higher[:, None] * UP)


def depth_in_table(scene: RobotScene, palm: Pose, x: Array) -> float:
    """Return how deep a robot is in the table [m].

    Parameters
    ----------
    scene
    palm
        The robot's, in the world.
    x : (m,)
        Its coordinates.
    """
    scene.pose(palm, x)
    sensors = scene.sensors
    return float(sensors.table(scene.data.sensordata[sensors.first :])[1])
