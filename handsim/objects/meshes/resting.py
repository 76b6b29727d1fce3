"""How a rigid body rests on a table, most stable first.

A body rests on a face of its convex hull where the centre of mass is above it. It tips over an edge
of that face once the centre of mass has risen to stand above the edge; the least rise over all
edges says how stable it is. Curved undersides and scans touch at several facets: all points within
a little of the lowest count as touching.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from handsim.errors import InputError
from handsim.objects.object import Vec3
from handsim.types import Array

Up = Literal["x", "y", "z"]

TOUCHING = 0.004
"""Height within which points touch the table, as a share of the longest side."""
ALIKE = np.deg2rad(8.0)
"""Poses nearer than this are one [rad]."""
MOST = 6
"""Poses that are kept."""
STEADY_DEG = 12.0
"""Tilt that a file's own way up has to stand, to come before its most stable way upside down."""
ROLLS_DEG = 3.0
"""Poses that tip more easily are rolling ones; they are kept where there are no others."""
TIE = 0.05
"""Relative difference of rises below which the file's own way up decides."""
MAX_POINTS = 1200
"""Corners of the hull that count; more only cost time."""


@dataclass(frozen=True)
class RestingPose:
    """One way to rest.

    Attributes
    ----------
    up
        What points up, in the axes of the file.
    rise
        How far the centre of mass has to rise to tip it over [m].
    tips_at_deg
        Least angle by which it has to be tilted for that [deg].
    """

    up: Vec3
    rise: float
    tips_at_deg: float

    @property
    def name(self) -> str:
        """The axis that points up, such as ``+z``, or the vector where it is none."""
        axis = int(np.abs(self.up).argmax())
        if abs(self.up[axis]) > np.cos(np.deg2rad(5.0)):
            return f"{'+' if self.up[axis] > 0 else '-'}{'xyz'[axis]}"
        return "({:.2f} {:.2f} {:.2f})".format(*self.up)


def resting_poses(points: Array, centre: Array) -> tuple[RestingPose, ...]:
    """Return the ways in which a body rests, the most stable first.

    Parameters
    ----------
    points : (n, 3) [m]
        Of its convex hull, or any that have the same hull.
    centre : (3,) [m]
        Of mass.

    Raises
    ------
    InputError
        If the points lie in a plane.
    """
    try:
        hull = ConvexHull(points)
        corners = points[hull.vertices]
        if len(corners) > MAX_POINTS:
            corners = corners[:: len(corners) // MAX_POINTS + 1]
            hull = ConvexHull(corners)
    except QhullError as error:
        raise InputError("the mesh is flat; give it some thickness") from error
    touching = TOUCHING * float(np.ptp(corners, axis=0).max())
    downs = np.unique(np.round(hull.equations[:, :3], 3), axis=0)
    downs /= np.linalg.norm(downs, axis=1, keepdims=True)
    poses = [pose for down in downs if (pose := _pose(corners, centre, down, touching))]
    poses.sort(key=lambda pose: -pose.rise)
    kept: list[RestingPose] = []
    for pose in poses:
        if all(np.dot(pose.up, other.up) < np.cos(ALIKE) for other in kept):
            kept.append(pose)
    steady = [pose for pose in kept if pose.tips_at_deg >= ROLLS_DEG]
    return tuple(_own_way_first(steady or kept)[:MOST])


def _pose(corners: Array, centre: Array, down: Array, touching: float) -> RestingPose | None:
    depth = corners @ down
    low = corners[depth >= depth.max() - touching]
    height = float(depth.max() - centre @ down)
    helper = np.eye(3)[np.abs(down).argmin()]
    first = np.cross(down, helper)
    first /= np.linalg.norm(first)
    plane = np.column_stack([first, np.cross(down, first)])
    try:
        base = ConvexHull((low - centre) @ plane)
    except (QhullError, ValueError):  # it stands on a line or a point
        return None
    inward = -base.equations[:, -1]  # of the centre of mass from each edge
    nearest = float(inward.min())
    if nearest <= 0 or height <= 0:
        return None
    x, y, z = (float(value) + 0.0 for value in -down)
    return RestingPose(
        (x, y, z),
        float(np.hypot(height, nearest) - height),
        float(np.rad2deg(np.arctan2(nearest, height))),
    )


def _own_way_first(poses: list[RestingPose]) -> list[RestingPose]:
    """Return poses as stable as the first in the order z up, y up, any other, then the rest.

    Where the first is upside down to the file, the file's own way comes before it if it is steady.
    """
    if not poses:
        return poses
    alike = [pose for pose in poses if pose.rise >= (1 - TIE) * poses[0].rise]
    alike.sort(key=lambda pose: (-round(pose.up[2], 2), -round(pose.up[1], 2)))
    ordered = [*alike, *(pose for pose in poses if pose not in alike)]
    if max(ordered[0].up) < -min(ordered[0].up):  # a cup on its rim: files have things upright
        over = [pose for pose in ordered if np.dot(pose.up, ordered[0].up) < -np.cos(ALIKE)]
        if over and over[0].tips_at_deg >= STEADY_DEG:
            ordered = [over[0], *(pose for pose in ordered if pose is not over[0])]
    return ordered


def turn_up(up: Up | Vec3) -> Rotation:
    """Return the turn that brings an axis of the file, or a direction in it, upright."""
    direction = np.eye(3)["xyz".index(up)] if isinstance(up, str) else np.array(up)
    axis = np.cross(direction, [0.0, 0.0, 1.0])
    length = np.linalg.norm(axis)
    if length < 1e-9:
        return Rotation.from_rotvec([np.pi if direction[2] < 0 else 0.0, 0.0, 0.0])
    angle = np.arctan2(length, direction[2])
    return Rotation.from_rotvec(axis / length * angle)
