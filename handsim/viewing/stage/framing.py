"""Where a camera stands so that a moving hand and what it grasps fill the picture.

The direction of sight stays; the camera moves along with what it frames, and comes nearer as hand
and object come together. What it frames is never cut off: the bounds are the greatest within a
window of time, and their mean over the same window, which cannot be less than those at its middle.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from handsim.types import Array

STEP_S = 0.1
"""Time between the states that are looked at [s]."""
WINDOW_S, ZOOM_WINDOW_S = 0.5, 1.1
"""Times over which the camera's way and its distance are smoothed [s]."""
APART_M = 0.55
"""Distance of the palm from what it let go, from which on that is not waited for [m]."""


@dataclass(frozen=True)
class Room:
    """Part of a picture that nothing else is drawn on: its edges as shares of width and height."""

    left: float = 0.05
    top: float = 0.10
    right: float = 0.95
    bottom: float = 0.95


@dataclass(frozen=True, eq=False)
class Framing:
    """The way of a camera: what it looks at, (n, 3) [m], and how far from it, (n,) [m], by time."""

    time: Array
    lookat: Array
    distance: Array

    def at(self, time: float) -> tuple[Array, float]:
        """Return point and distance at a time since the start [s]."""
        point = np.array([np.interp(time, self.time, axis) for axis in self.lookat.T])
        return point, float(np.interp(time, self.time, self.distance))


def frame_movement(
    model: mujoco.MjModel,
    time: Array,
    qpos: Array,
    axes: Array,
    aspect: float,
    room: Room,
    least: float = 0.24,
) -> Framing | None:
    """Lay the way of a camera by which hand and object stay within a room of the picture.

    Parameters
    ----------
    model
    time : (n,) [s]
    qpos : (n, nq)
    axes : (3, 3)
        Columns: the camera's right, its up, and away from what it looks at.
    aspect
        Width of the picture over its height.
    room
        Where in the picture they are to be.
    least
        Least height of what is seen about the hand [m]: a fist alone is not to fill the picture.

    Returns
    -------
    Framing or None
        None where the model has no palm or no object.
    """
    if min(_body(model, "palm"), _body(model, "object")) < 0:
        return None
    moments = np.linspace(0.0, float(time[-1] - time[0]), 2 + int((time[-1] - time[0]) / STEP_S))
    rows = np.clip(np.searchsorted(time - time[0], moments), 0, len(time) - 1)
    tangent = np.tan(np.deg2rad(model.vis.global_.fovy) / 2)
    right, left = (2 * room.right - 1) * tangent * aspect, (1 - 2 * room.left) * tangent * aspect
    up, down = (1 - 2 * room.top) * tangent, (2 * room.bottom - 1) * tangent
    bounds = np.array(
        [_bounds(points @ axes, right, left, up, down) for points in _outlines(model, qpos[rows])]
    )
    a, b, c, d, depth = _least_above(bounds, WINDOW_S).T
    nearest = depth + 0.5 * least / tangent
    back = np.maximum(np.maximum((a + b) / (right + left), (c + d) / (up + down)), nearest)
    distance = _least_above(back - depth, ZOOM_WINDOW_S)
    back = depth + distance
    x = 0.5 * ((a - right * back) + (left * back - b))
    y = 0.5 * ((c - up * back) + (down * back - d))
    lookat = np.column_stack([x, y, depth]) @ axes.T
    return Framing(moments, lookat, distance)


def _least_above(values: Array, window_s: float) -> Array:
    """Return what goes smoothly over time and is nowhere less than the values, (n, ...)."""
    n = 1 + 2 * round(0.5 * window_s / STEP_S)
    most = maximum_filter1d(values, n, axis=0, mode="nearest")
    return uniform_filter1d(most, n, axis=0, mode="nearest")


def _bounds(points: Array, right: float, left: float, up: float, down: float) -> Array:
    """Return the planes through the points' outermost ones, as seen, and their middle depth.

    A point at x and z, z towards the camera at (cx, cz), is left of the right edge where
    ``x + right z <= cx + right cz``: the greatest of the left sides is all that counts.
    """
    x, y, z = points.T
    return np.array(
        [
            (x + right * z).max(),
            (left * z - x).max(),
            (y + up * z).max(),
            (down * z - y).max(),
            0.5 * (z.max() + z.min()),
        ]
    )


def _outlines(model: mujoco.MjModel, qpos: Array) -> list[Array]:
    """Return corners of the boxes about the parts of hand and object in each state [m]."""
    data = mujoco.MjData(model)
    palm, target = _body(model, "palm"), _body(model, "object")
    hand, grasped = _geoms_of(model, palm), _geoms_of(model, target)
    outlines: list[Array] = []
    for state in qpos:
        data.qpos[:] = state
        mujoco.mj_kinematics(model, data)
        together = np.linalg.norm(data.xpos[target] - data.xpos[palm]) < APART_M
        outlines.append(_corners(model, data, [*hand, *(grasped if together else ())]))
    return outlines


def _geoms_of(model: mujoco.MjModel, body: int) -> list[int]:
    """Return the geoms of a body and of all that it carries."""
    carried = {body}
    for i in range(body + 1, model.nbody):
        if int(model.body_parentid[i]) in carried:
            carried.add(i)
    return [geom for geom in range(model.ngeom) if int(model.geom_bodyid[geom]) in carried]


def _corners(model: mujoco.MjModel, data: mujoco.MjData, geoms: list[int]) -> Array:
    """Return the corners of the boxes about geoms, (8 n, 3) [m] in the world."""
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    middle, half = model.geom_aabb[geoms, :3], model.geom_aabb[geoms, 3:]
    local = middle[:, None] + signs * half[:, None]
    turned = np.einsum("gij,gkj->gki", data.geom_xmat[geoms].reshape(-1, 3, 3), local)
    return (turned + data.geom_xpos[geoms][:, None]).reshape(-1, 3)


def _body(model: mujoco.MjModel, name: str) -> int:
    return mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY.value, name)
