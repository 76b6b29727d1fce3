"""A solid made of convex pieces, and the stretches of lines that lie in it.

Every piece is the space on one side of some planes, so that its share of a line is one interval.
Thousands of lines are cut at once.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from handsim.objects.mjcf import points_of
from handsim.objects.object import Collider, GraspObject
from handsim.types import Array, Index, Mask

SIDES = 48
"""Sides of the prism that stands in for a cylinder: its surface is within 0.2 % of a radius."""
BALL_SIDES = 16
"""Sides of what stands in for a ball, and for the ends of a capsule: within 2 % of a radius."""
GAP = 2e-4
"""Pieces closer than this along a line count as one [m]: decomposition leaves seams."""
_AT_ONCE = 4_000_000
"""Crossings of lines and planes that are worked out at a time, for want of memory."""


@dataclass(frozen=True, eq=False)
class Spans:
    """Stretches of lines inside a solid, in order of line and of place on it.

    Attributes
    ----------
    line : (n,)
        Number of the line.
    enter, leave : (n,) [m]
        Where the stretch begins and ends, from the line's origin.
    normal_in, normal_out : (n, 3)
        Outward unit normals of the surface there.
    room_before, room_after : (n,) [m]
        Free way before and after it, to the stretch next on the line; infinite at the ends.
    """

    line: Index
    enter: Array
    leave: Array
    normal_in: Array
    normal_out: Array
    room_before: Array
    room_after: Array


@dataclass(frozen=True, eq=False)
class ConvexSolid:
    """The union of convex pieces.

    Attributes
    ----------
    normals : (n, 3), offsets : (n,) [m]
        Planes of all pieces: inside is where ``normals @ x <= offsets``.
    first : (n_pieces,)
        Number of the first plane of each piece.
    points : (m, 3) [m]
        Corners of all pieces.
    """

    normals: Array
    offsets: Array
    first: Index
    points: Array

    @classmethod
    def of(cls, grasp_object: GraspObject) -> "ConvexSolid":
        """Return the solid of an object's contact pieces, its hinges at 0."""
        colliders = [*grasp_object.colliders]
        for link in grasp_object.links:
            colliders += link.colliders
        return cls.of_hulls([corners(each) for each in colliders])

    @classmethod
    def of_hulls(cls, clouds: list[Array]) -> "ConvexSolid":
        """Return the union of the convex hulls of clouds of points, (n, 3) [m] each."""
        planes = [_planes(points) for points in clouds]
        sizes = [len(each) for each in planes]
        all_planes = np.concatenate(planes)
        return cls(
            all_planes[:, :3],
            -all_planes[:, 3],
            np.cumsum([0, *sizes[:-1]]),
            np.concatenate(clouds),
        )

    def spans(self, origins: Array, directions: Array) -> Spans:
        """Return the stretches of lines (n, 3) [m] along unit ``directions`` (n, 3) inside."""
        size = max(1, _AT_ONCE // len(self.offsets))
        parts = [
            self._spans(origins[i : i + size], directions[i : i + size], i)
            for i in range(0, max(len(origins), 1), size)
        ]
        return Spans(*(np.concatenate([getattr(each, name) for each in parts]) for name in _FIELDS))

    def contains(self, points: Array) -> Mask:
        """Return which points (n, 3) [m] lie inside."""
        outside = points @ self.normals.T > self.offsets
        return np.asarray(~np.logical_or.reduceat(outside, self.first, axis=1).all(axis=1))

    def _spans(self, origins: Array, directions: Array, number: int) -> Spans:
        enter, leave, plane_in, plane_out = self._cut(origins, directions)
        order = np.argsort(enter, axis=1, kind="stable")
        enter, leave = (np.take_along_axis(each, order, axis=1) for each in (enter, leave))
        plane_in, plane_out = (
            np.take_along_axis(each, order, axis=1) for each in (plane_in, plane_out)
        )
        farthest = np.maximum.accumulate(leave, axis=1)
        column = np.arange(enter.shape[1])
        latest = np.where(leave >= farthest, column, 0).astype(np.int64)
        farthest_at = np.maximum.accumulate(latest, axis=1)
        met = np.isfinite(enter)
        begins = met.copy()
        begins[:, 1:] &= enter[:, 1:] > farthest[:, :-1] + GAP
        ends = met.copy()  # the last piece before another stretch begins, or before none
        ends[:, :-1] &= begins[:, 1:] | ~met[:, 1:]
        line, start = np.nonzero(begins)
        _, stop = np.nonzero(ends)
        came, left = enter[line, start], farthest[line, stop]
        before = np.full(len(line), np.inf)
        same = line[1:] == line[:-1]
        before[1:][same] = (came[1:] - left[:-1])[same]
        after = np.full(len(line), np.inf)
        after[:-1][same] = before[1:][same]
        return Spans(
            line + number,
            came,
            left,
            self.normals[plane_in[line, start]],
            self.normals[plane_out[line, farthest_at[line, stop]]],
            before,
            after,
        )

    def _cut(self, origins: Array, directions: Array) -> tuple[Array, Array, Index, Index]:
        """Return where each line enters and leaves each piece, and through which planes.

        Pieces that are missed have ``enter`` inf and ``leave`` -inf.
        """
        slope = directions @ self.normals.T
        ahead = self.offsets - origins @ self.normals.T
        with np.errstate(divide="ignore", invalid="ignore"):
            at = ahead / slope
        level = np.abs(slope) < 1e-12
        coming = np.where(slope < 0, at, -np.inf)
        going = np.where(slope > 0, at, np.inf)
        coming[level] = np.where(ahead[level] < 0, np.inf, -np.inf)
        going[level] = np.inf
        shape = (len(origins), len(self.first))
        enter, leave = np.empty(shape), np.empty(shape)
        plane_in, plane_out = np.empty(shape, dtype=np.int64), np.empty(shape, dtype=np.int64)
        ends = [*self.first[1:], len(self.offsets)]
        for piece, (start, end) in enumerate(zip(self.first, ends, strict=True)):
            plane_in[:, piece] = start + coming[:, start:end].argmax(axis=1)
            plane_out[:, piece] = start + going[:, start:end].argmin(axis=1)
            enter[:, piece] = coming[:, start:end].max(axis=1)
            leave[:, piece] = going[:, start:end].min(axis=1)
        missed = ~(enter < leave)
        enter[missed], leave[missed] = np.inf, -np.inf
        return enter, leave, plane_in, plane_out


_FIELDS = ("line", "enter", "leave", "normal_in", "normal_out", "room_before", "room_after")


def corners(collider: Collider) -> Array:
    """Return the corners of a convex piece, (n, 3) [m]; round ones become prisms."""
    if collider.kind == "hull":
        return np.asarray(points_of(collider), dtype=float)
    turn = Rotation.from_quat(collider.quat, scalar_first=True)
    return turn.apply(_primitive(collider)) + np.array(collider.pos)


def _primitive(collider: Collider) -> Array:
    size = collider.size
    if collider.kind == "box":
        signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        return signs * np.array(size)
    if collider.kind == "cylinder":
        rim = _around(SIDES) * size[0]
        return np.vstack([np.column_stack([rim, np.full(SIDES, z)]) for z in (-size[1], size[1])])
    half = size[1] if collider.kind == "capsule" else 0.0
    rises = np.linspace(0.0, np.pi / 2, BALL_SIDES // 4 + 1)
    cap = np.vstack(
        [
            np.column_stack([np.cos(rise) * _around(BALL_SIDES), np.full(BALL_SIDES, np.sin(rise))])
            for rise in rises
        ]
    )
    upper = np.unique(np.round(cap * size[0], 9), axis=0) + np.array([0.0, 0.0, half])
    return np.vstack([upper, upper * np.array([1.0, 1.0, -1.0])])


def _around(n: int) -> Array:
    """Return the corners of a polygon whose sides touch the unit circle, (n, 2)."""
    angles = (np.arange(n) + 0.5) * 2 * np.pi / n
    return np.column_stack([np.cos(angles), np.sin(angles)]) / np.cos(np.pi / n)


def _planes(points: Array) -> Array:
    """Return the planes of a convex hull, (n, 4): unit outward normal and offset [m]."""
    try:
        equations = ConvexHull(points).equations
    except QhullError:  # as flat as numbers can tell: moved about by the last digits
        equations = ConvexHull(points, qhull_options="QJ").equations
    return np.unique(np.round(equations, 9), axis=0)
