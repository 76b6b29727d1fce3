"""Families of grasps of an object: which opposed surfaces which hand could take hold of, and how.

Level lines through the object, all around, at many heights and side by side, meet pairs of opposed
surfaces: across the whole, across a handle, across the wall of something hollow. Each pair that has
room for fingers is taken from above or from the side, with as many fingers as fit.
"""

from dataclasses import dataclass

import numpy as np

from handsim.joints import FINGERS, Finger
from handsim.objects.convex_solid import ConvexSolid
from handsim.objects.grasp import Grasp, GraspKind
from handsim.objects.object import Vec3
from handsim.types import Array, Index, Mask

WIDTH_RANGE = (0.0015, 0.10)
"""Between opposed pads [m]; people open to about 0.15 m and grasp well below that."""
FACING = np.deg2rad(30.0)
"""Largest angle between a surface's normal and the opposition [rad]: friction 0.6."""
REACH = 0.05
"""How far beyond an object's nearest surface the pads of a hand reach [m]."""
PALM_ROOM = 0.045
"""Height above the table that a hand of four fingers needs when it comes from the side [m]."""
TWO_FINGER_ROOM = 0.028
"""The same of thumb and two fingers [m]."""
TIP_ROOM = 0.007
"""Height above the table that a fingertip needs, where the object is as high [m]."""
FINGER = 0.016
"""Thickness of a finger [m]: of the index finger's middle segment of a man's hand."""
RIM = 0.010
"""How far below an upper edge fingertips take hold of a rim [m]."""
NARROW = 0.030
"""Width up to which a bar is taken as a handle or by a tripod [m]."""
THIN = 0.015
"""Width below which an object is pinched between fingertips [m]."""

N_AZIMUTHS = 12
N_LEVELS = 10
ALL: tuple[Finger, ...] = FINGERS[1:]
TWO, THREE = ALL[:2], ALL[:3]
_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class Opposed:
    """Pairs of opposed surfaces on level lines.

    Attributes
    ----------
    point : (n, 3) [m]
        Half-way between them.
    axis : (n, 3)
        Unit direction from the thumb's surface to the fingers'.
    width : (n,) [m]
    facing : (n,) [rad]
        Angle between the axis and the surface normals, the larger of two.
    """

    point: Array
    axis: Array
    width: Array
    facing: Array

    def where(self, chosen: Mask | Index) -> "Opposed":
        """Return the chosen pairs."""
        return Opposed(
            self.point[chosen], self.axis[chosen], self.width[chosen], self.facing[chosen]
        )


def opposed_surfaces(solid: ConvexSolid, centre: Array) -> Opposed:
    """Return all pairs within `WIDTH_RANGE` that face each other and leave room for fingers.

    Parameters
    ----------
    solid
        In the object frame, z up, the table at 0.
    centre : (3,) [m]
        Centre of mass, through which lines are laid at any rate.
    """
    found: list[Opposed] = []
    heights = _levels(solid, centre)
    for axis in _directions(solid):
        across = np.cross(_UP, axis)
        aside = solid.points @ across - centre @ across
        step = np.clip((aside.max() - aside.min()) / 24, 0.003, 0.010)
        shifts = step * np.arange(np.ceil(aside.min() / step), np.floor(aside.max() / step) + 1)
        height, shift = (each.ravel() for each in np.meshgrid(heights, shifts, indexing="ij"))
        origins = centre * [1.0, 1.0, 0.0] + shift[:, None] * across + height[:, None] * _UP
        spans = solid.spans(origins, np.broadcast_to(axis, origins.shape))
        first, last = _ends(spans.line)
        width = spans.leave[last] - spans.enter[first]
        faces = (-spans.normal_in[first] @ axis, spans.normal_out[last] @ axis)
        facing = np.arccos(np.clip(np.minimum(*faces), -1.0, 1.0))
        room = np.minimum(spans.room_before[first], spans.room_after[last])
        good = (WIDTH_RANGE[0] <= width) & (width <= WIDTH_RANGE[1])
        good &= (facing <= FACING) & (room >= FINGER)
        along = (spans.enter[first] + spans.leave[last]) / 2
        middle = origins[spans.line[first]] + along[:, None] * axis
        for sign in (1.0, -1.0):  # thumb on either side
            axes = np.broadcast_to(sign * axis, middle.shape)
            found.append(Opposed(middle, axes, width, facing).where(good))
    return Opposed(
        *(
            np.concatenate([getattr(each, name) for each in found])
            for name in ("point", "axis", "width", "facing")
        )
    )


def _ends(line: Index) -> tuple[Index, Index]:
    """Return numbers of stretches that a grasp may begin and end with.

    Each by itself, and of a line that passes through hollows the first with the last.
    """
    each = np.arange(len(line))
    _, first, count = np.unique(line, return_index=True, return_counts=True)
    hollow = count > 1
    return (
        np.concatenate([each, first[hollow]]),
        np.concatenate([each, (first + count - 1)[hollow]]),
    )


def _levels(solid: ConvexSolid, centre: Array) -> Array:
    """Return heights at which fingertips may take hold [m]."""
    top = float(solid.points[:, 2].max())
    lowest = min(TIP_ROOM, top / 2)
    n = max(N_LEVELS, int(top / 0.02))
    spread = top * (np.arange(n, dtype=np.float64) + 0.5) / n
    levels = np.array([centre[2], top - RIM, *spread], dtype=np.float64)
    raised: Array = np.maximum(levels, lowest)
    return np.unique(np.round(raised, 4))


def _directions(solid: ConvexSolid) -> list[Array]:
    """Return level unit vectors: evenly spread, and across and along the footprint."""
    plan = solid.points[:, :2] - solid.points[:, :2].mean(axis=0)
    _, vectors = np.linalg.eigh(plan.T @ plan)
    main = float(np.arctan2(vectors[1, 1], vectors[0, 1])) % (np.pi / 2)
    angles = np.pi * np.arange(N_AZIMUTHS) / N_AZIMUTHS
    step = np.pi / N_AZIMUTHS
    if min(main % step, step - main % step) > np.deg2rad(1.0):
        angles = np.concatenate([angles, [main, main + np.pi / 2]])
    return [np.array([np.cos(angle), np.sin(angle), 0.0]) for angle in angles]


def grasps_of(solid: ConvexSolid, pairs: Opposed) -> list[tuple[Grasp, int]]:
    """Return the grasps that a hand has room for, each with the number of its pair."""
    found: list[tuple[Grasp, int]] = []
    down = np.broadcast_to(-_UP, pairs.point.shape)
    leftward = np.cross(_UP, pairs.axis)  # where a right palm faces with the thumb up
    open_above = _reachable(solid, pairs, down)
    open_aside = _reachable(solid, pairs, leftward)
    for i in np.nonzero(open_above)[0].tolist():
        found += [(_grasp(pairs, i, kind, down[i], of), i) for kind, of in _from_above(pairs, i)]
    for i in np.nonzero(open_aside)[0].tolist():
        found += [
            (_grasp(pairs, i, kind, leftward[i], of), i) for kind, of in _from_the_side(pairs, i)
        ]
    return found


def _from_above(pairs: Opposed, i: int) -> list[tuple[GraspKind, tuple[Finger, ...]]]:
    width = float(pairs.width[i])
    ways: list[tuple[GraspKind, tuple[Finger, ...]]] = [("top", TWO), ("top", THREE)]
    if width >= THIN:
        ways.append(("top", ALL))
    if width <= NARROW:
        ways.append(("tripod", TWO))
    return ways


def _from_the_side(pairs: Opposed, i: int) -> list[tuple[GraspKind, tuple[Finger, ...]]]:
    width, height = float(pairs.width[i]), float(pairs.point[i, 2])
    ways: list[tuple[GraspKind, tuple[Finger, ...]]] = []
    if width <= NARROW and height >= TWO_FINGER_ROOM:
        ways.append(("handle", TWO))
    if height >= PALM_ROOM:
        ways.append(("edge", ALL) if width <= NARROW else ("side", ALL))
    return ways


def _grasp(
    pairs: Opposed, i: int, kind: GraspKind, approach: Array, fingers: tuple[Finger, ...]
) -> Grasp:
    return Grasp(
        kind,
        _vec(pairs.point[i]),
        _vec(pairs.axis[i]),
        _vec(approach),
        float(pairs.width[i]),
        fingers,
    )


def _reachable(solid: ConvexSolid, pairs: Opposed, approach: Array) -> Mask:
    """Return whether a hand that comes along ``approach`` (n, 3) gets its pads to each pair.

    Between the pads it may stand out by `REACH`; where the fingers pass nothing may.
    """
    free = np.ones(len(pairs.point), dtype=bool)
    for part in (-0.49, 0.0, 0.49):
        starts = pairs.point + part * pairs.width[:, None] * pairs.axis
        free &= _farthest(solid, starts, -approach) <= REACH
    for side in (-1.0, 1.0):
        out = (pairs.width / 2 + FINGER / 2)[:, None] * side * pairs.axis
        free &= _farthest(solid, pairs.point + out, -approach) <= 0.0
    return free


def _farthest(solid: ConvexSolid, starts: Array, directions: Array) -> Array:
    """Return how far from each start, in its direction, the solid still is, (n,) [m]."""
    spans = solid.spans(starts, directions)
    farthest = np.full(len(starts), -np.inf)
    np.maximum.at(farthest, spans.line, spans.leave)
    return farthest


def _vec(array: Array) -> Vec3:
    x, y, z = (float(value) + 0.0 for value in np.round(array, 9))
    return (x, y, z)
