"""Where the links of a robot hand are in many postures at once, and how points on them move.

MuJoCo computes one posture at a time. Here all postures of a movement go through each joint
together, which is what makes the fit of a movement fast.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from handsim.hand.kinematics import cross, times, turned_about
from handsim.types import Array, Index, Mask

_SLIDE = mujoco.mjtJoint.mjJNT_SLIDE.value


@dataclass(frozen=True)
class LinkFrames:
    """Frames of bodies and axes of joints in n postures.

    Attributes
    ----------
    position : (n, b, 3) [m]
    rotation : (n, b, 3, 3)
        Columns are the bodies' axes.
    anchor, axis : (n, j, 3)
        Of the joints [m; unit].
    """

    position: Array
    rotation: Array
    anchor: Array
    axis: Array


class Links:
    """The bodies of a model that given joints move.

    Parameters
    ----------
    model
    joints
        Ids of j hinges and slides; all others stay in the reference posture.
    bodies
        Ids of bodies asked for; those in between are found.
    """

    def __init__(self, model: mujoco.MjModel, joints: Sequence[int], bodies: Sequence[int]) -> None:
        self._start: Array = model.qpos0[model.jnt_qposadr[list(joints)]].copy()
        self.slides: Mask = model.jnt_type[list(joints)] == _SLIDE
        place = {j: i for i, j in enumerate(joints)}
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        wanted: set[int] = set()
        for body in (*bodies, *(int(model.jnt_bodyid[j]) for j in joints)):
            at = body
            while at > 0:
                wanted.add(at)
                at = int(model.body_parentid[at])
        self.bodies = sorted({0, *wanted})
        self._row = {body: i for i, body in enumerate(self.bodies)}
        self.moves: Mask = np.zeros((len(self.bodies), len(joints)), dtype=bool)
        self._fixed: dict[int, tuple[Array, Array]] = {}
        self._moving: list[tuple[int, int, Array, Array, list[tuple[int, Array, Array]]]] = []
        for i, body in enumerate(self.bodies):
            parent = self._row[int(model.body_parentid[body])]
            first = int(model.body_jntadr[body])
            own = [
                (place[j], model.jnt_pos[j].copy(), model.jnt_axis[j].copy())
                for j in range(first, first + int(model.body_jntnum[body]))
                if j in place
            ]
            if body:
                self.moves[i] = self.moves[parent]
            self.moves[i, [k for k, _, _ in own]] = True
            if not self.moves[i].any():
                self._fixed[i] = data.xpos[body].copy(), data.xmat[body].reshape(3, 3).copy()
                continue
            turn = Rotation.from_quat(model.body_quat[body], scalar_first=True).as_matrix()
            self._moving.append((i, parent, model.body_pos[body].copy(), turn, own))

    def rows(self, bodies: Sequence[int] | Index) -> Index:
        """Return the rows of bodies in frames; bodies that are not there are refused."""
        return np.array([self._row[int(body)] for body in bodies], dtype=np.int64)

    def moved_by(self, body: int) -> Mask:
        """Return which joints move a body, (j,); none of a body that is not there."""
        if body not in self._row:
            return np.zeros(len(self._start), dtype=bool)
        return self.moves[self._row[body]]

    def frames(self, positions: Array) -> LinkFrames:
        """Return all frames, positions (n, j) [rad, m for slides] given."""
        n = len(positions)
        count = len(self.bodies)
        position, rotation = np.empty((n, count, 3)), np.empty((n, count, 3, 3))
        anchor, axis = np.empty((2, n, len(self._start), 3))
        moved = positions - self._start
        for i, (place, turn) in self._fixed.items():
            position[:, i], rotation[:, i] = place, turn
        for i, parent, pos, turn, own in self._moving:
            above = rotation[:, parent]
            at, turned = position[:, parent] + above @ pos, times(above, turn)
            for k, off, about in own:
                axis[:, k] = turned @ about
                if self.slides[k]:
                    anchor[:, k] = at + turned @ off
                    at = at + axis[:, k] * moved[:, k, None]
                    continue
                pivot = at + turned @ off if off.any() else at
                anchor[:, k] = pivot
                turned = turned_about(turned, about, moved[:, k])
                at = pivot - turned @ off if off.any() else pivot
            position[:, i], rotation[:, i] = at, turned
        return LinkFrames(position, rotation, anchor, axis)

    def velocities(self, frames: LinkFrames, rows: Index, points: Array) -> Array:
        """Return how points on bodies shift with the joints, (n, k, j, 3) [m/rad].

        Parameters
        ----------
        frames
        rows : (k,)
            Of the bodies that they are fixed to.
        points : (n, k, 3) [m]
        """
        made = np.zeros((*points.shape[:2], len(self._start), 3))
        point, joint = np.nonzero(self.moves[rows])
        turning = ~self.slides[joint]
        p, j = point[turning], joint[turning]
        made[:, p, j] = cross(frames.axis[:, j], points[:, p] - frames.anchor[:, j])
        p, j = point[~turning], joint[~turning]
        made[:, p, j] = frames.axis[:, j]
        return made

    def turns(self, frames: LinkFrames, rows: Index, directions: Array) -> Array:
        """Return how directions fixed to bodies turn with the joints, (n, k, j, 3) [1/rad]."""
        made = np.zeros((*directions.shape[:2], len(self._start), 3))
        point, joint = np.nonzero(self.moves[rows] & ~self.slides)
        made[:, point, joint] = cross(frames.axis[:, joint], directions[:, point])
        return made
