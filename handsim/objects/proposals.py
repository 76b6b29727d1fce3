"""Where an object that nobody has grasped before can be taken between thumb and fingers.

Opposed surfaces are found by rays through the object's contact pieces: level lines through the
upright through its centre of mass, all around and at several heights, across the whole object and
across the wall of a hollow one. A line is a candidate where both surfaces face it within the
friction angle, no further apart than a hand grasps, and the fingers can reach it from above or
from the side.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from dataclasses import dataclass
from typing import Literal

import mujoco
import numpy as np

from handsim.errors import InputError
from handsim.joints import FINGERS
from handsim.objects.grasp import Grasp
from handsim.objects.mjcf import COLLISION_GROUP, add_object
from handsim.objects.object import GraspObject, Vec3
from handsim.types import Array

WIDTH_RANGE = (0.004, 0.10)
"""Between opposed pads [m]; people open to about 0.15 m and grasp well below that."""

FACING = np.deg2rad(30.0)
"""Largest angle between a surface's normal and the opposition [rad]: friction 0.6."""

REACH = 0.05
"""How far beyond an object's nearest surface the pads of a hand reach [m]."""

PALM_ROOM = 0.045
"""Height above the table that half a hand needs when it comes from the side [m]."""

TIP_ROOM = 0.007
"""Height above the table that a fingertip needs [m]."""

STEP = 0.001
"""Distance of the rays that feel how a surface lies [m]."""

SHARP = 0.7
"""How far a surface may fall off over one step, in steps: an edge of 90 deg falls off by 1."""


@dataclass(frozen=True)
class Proposal:
    """A grasp and what speaks for it.

    Attributes
    ----------
    grasp
        In the object frame.
    facing_deg
        Angle between opposition and surface normals, the larger of two [deg].
    lever
        Distance of the centre of mass from the grasp point [m].
    """

    grasp: Grasp
    facing_deg: float
    lever: float

    @property
    def cost(self) -> float:
        """Least for surfaces that face each other, near the centre of mass, not too wide."""
        return self.facing_deg / 15.0 + self.lever / 0.02 + self.grasp.width / 0.06


def propose_grasps(grasp_object: GraspObject) -> tuple[Proposal, ...]:
    """Return grasps between opposed surfaces, the most promising first.

    Raises
    ------
    InputError
        If the object offers none.
    """
    spec = mujoco.MjSpec()
    add_object(spec, grasp_object)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    centre = data.subtree_com[model.body("object").id].copy()
    top = _top(model, data, centre)
    lowest = min(TIP_ROOM, top / 2)
    levels = np.array([centre[2], *(np.array([0.3, 0.5, 0.7, 0.85]) * top)])
    heights = np.unique(np.round(np.maximum(levels, lowest), 4))
    found = []
    for height in heights:
        middle = np.array([centre[0], centre[1], height])
        for azimuth in np.deg2rad(np.arange(0.0, 360.0, 15.0)):
            axis = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
            beyond, before = middle + axis, middle - axis
            for start in (before, middle):  # across the whole, or the wall of something hollow
                hits = _opposed(model, data, (start, beyond), axis)
                if hits is not None:
                    found += _grasps(model, data, hits, axis, centre)
    if not found:
        raise InputError(
            f"object '{grasp_object.name}' has no two opposed surfaces up to"
            f" {1000 * WIDTH_RANGE[1]:g} mm apart; set it down another way or scale it"
        )
    return tuple(sorted(found, key=lambda proposal: proposal.cost))


def _ray(
    model: mujoco.MjModel, data: mujoco.MjData, start: Array, direction: Array
) -> Array | None:
    """Return where a ray first meets the object's contact pieces, (3,) [m]."""
    groups = np.zeros(mujoco.mjNGROUP, np.uint8)
    groups[COLLISION_GROUP] = 1
    hit = np.zeros(1, np.int32)
    distance = mujoco.mj_ray(model, data, start, direction, groups, 1, -1, hit)
    return None if distance < 0 else start + distance * direction


def _top(model: mujoco.MjModel, data: mujoco.MjData, centre: Array) -> float:
    """Return the height of the object at or around its centre of mass [m]."""
    steps = np.linspace(-0.05, 0.05, 11)
    down = np.array([0.0, 0.0, -1.0])
    hits = [
        _ray(model, data, np.array([centre[0] + x, centre[1] + y, 2.0]), down)
        for x in steps
        for y in steps
    ]
    return max((float(hit[2]) for hit in hits if hit is not None), default=2 * float(centre[2]))


def _opposed(
    model: mujoco.MjModel, data: mujoco.MjData, starts: tuple[Array, Array], axis: Array
) -> tuple[Array, Array, float] | None:
    """Return what is met between two points of a line, and how far it is from facing it [rad]."""
    across, up = np.cross([0.0, 0.0, 1.0], axis), np.array([0.0, 0.0, 1.0])
    shifts = (0 * axis, STEP * across, -STEP * across, STEP * up, -STEP * up)
    ends, worst = [], 0.0
    for start, direction in zip(starts, (axis, -axis), strict=True):
        around = [_ray(model, data, start + shift, direction) for shift in shifts]
        points = [point for point in around if point is not None]
        if len(points) < len(around):
            return None
        end, left, right, above, below = points
        normal = np.cross(left - right, above - below)
        normal /= np.linalg.norm(normal)
        ridge = np.array([(left + right) / 2 - end, (above + below) / 2 - end])
        if np.linalg.norm(ridge, axis=1).max() > SHARP * STEP:
            return None
        worst = max(worst, float(np.arccos(min(1.0, abs(normal @ axis)))))
        ends.append(end)
    if worst > FACING:
        return None
    return ends[0], ends[1], worst


def _grasps(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    hits: tuple[Array, Array, float],
    axis: Array,
    centre: Array,
) -> list[Proposal]:
    """Return the grasps from above and from the side along one line."""
    start, end, facing = hits
    width, middle = float((end - start) @ axis), (start + end) / 2
    if not WIDTH_RANGE[0] <= width <= WIDTH_RANGE[1]:
        return []
    lever = float(np.linalg.norm(middle - centre))
    leftward = np.cross([0.0, 0.0, 1.0], axis)  # where a right palm faces with the thumb up
    ways: list[tuple[Literal["top", "side"], Array]] = [("top", np.array([0.0, 0.0, -1.0]))]
    if middle[2] >= PALM_ROOM:
        ways.append(("side", leftward))
    proposals = []
    for kind, approach in ways:
        sides = [middle + part * width * axis for part in (-0.49, 0.0, 0.49)]
        met = [_ray(model, data, side - approach, approach) for side in sides]
        if any(hit is not None and (middle - hit) @ approach > REACH for hit in met):
            continue
        grasp = Grasp(kind, _vec(middle), _vec(axis), _vec(approach), width, FINGERS[1:])
        proposals.append(Proposal(grasp, float(np.rad2deg(facing)), lever))
    return proposals


def _vec(array: Array) -> Vec3:
    x, y, z = (float(value) + 0.0 for value in np.round(array, 9))
    return (x, y, z)
