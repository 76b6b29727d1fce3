"""A picture of the ways in which an own object rests on the table, most stable first."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import math

import mujoco
import numpy as np

from handsim.objects.mesh_import import OwnObject
from handsim.objects.object import GraspObject
from handsim.tasks.scene import build_scene
from handsim.types import Frame
from handsim.viewing.film.offscreen import Offscreen, open_offscreen
from handsim.viewing.film.video import contact_sheet
from handsim.viewing.stage.lighting import light_from_the_camera

WIDTH, HEIGHT = 300, 260
MOST_COLUMNS = 4
MARGIN = 1.6
"""Distance of the camera, in diagonals of the object."""


def resting_sheet(own: OwnObject) -> Frame:
    """Return a picture of each way to rest; where there is none, of the object as it stands."""
    shown = [
        (own.standing(pose), f"{i}: {pose.name} up, tips at {pose.tips_at_deg:.0f} deg")
        for i, pose in enumerate(own.resting, start=1)
    ] or [(own.object, "rests on no side")]
    with open_offscreen(WIDTH, HEIGHT) as offscreen:
        frames = [_picture(offscreen, each) for each, _ in shown]
    n_rows = math.ceil(len(shown) / MOST_COLUMNS)
    columns = math.ceil(len(shown) / n_rows)  # as full as can be: six are three by two
    return contact_sheet(frames, [label for _, label in shown], columns)


def _picture(offscreen: Offscreen, grasp_object: GraspObject) -> Frame:
    model = build_scene(grasp_object, None).compile()
    light_from_the_camera(model)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    points = np.concatenate([np.array(each.points) for each in grasp_object.colliders])
    low, high = points.min(axis=0), points.max(axis=0)
    camera = mujoco.MjvCamera()
    camera.lookat[:] = (low + high) / 2
    camera.distance = MARGIN * float(np.linalg.norm(high - low))
    camera.azimuth, camera.elevation = 145.0, -22.0
    return offscreen.add(model).draw(data, camera)
