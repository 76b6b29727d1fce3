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
        self._moving: list[_Moving] = []
        for i, body in enumerate(self.bodies):
            parent = self._row[int(model.body_parentid[body])]
            first = int(model.body_jntadr[body])
            own = [
                _hinge_or_slide(model, j, place[j])
                for j in range(first, first + int(model.body_jntnum[body]))
                if j in place
            ]
            if body:
                self.moves[i] = self.moves[parent]
            self.moves[i, [each.row for each in own]] = True
            if not self.moves[i].any():
                self._fixed[i] = data.xpos[body].copy(), data.xmat[body].reshape(3, 3).copy()
                continue
            self._moving.append(_Moving(i, parent, *_pose_of(model, body), tuple(own)))

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
        for body in self._moving:
            turned, at = rotation[:, body.parent], position[:, body.parent]
            if body.pos is not None:
                at = at + turned @ body.pos
            if body.turn is not None:
                turned = times(turned, body.turn)
            for joint in body.joints:
                k = joint.row
                axis[:, k] = turned @ joint.axis
                if self.slides[k]:
                    anchor[:, k] = at if joint.pos is None else at + turned @ joint.pos
                    at = at + axis[:, k] * moved[:, k, None]
                    continue
                pivot = at if joint.pos is None else at + turned @ joint.pos
                anchor[:, k] = pivot
                if joint.along is None:
                    turned = turned_about(turned, joint.axis, moved[:, k])
                else:
                    turned = _turned_about_own(turned, joint.along, moved[:, k] * joint.sign)
                at = pivot if joint.pos is None else pivot - turned @ joint.pos
            position[:, body.row], rotation[:, body.row] = at, turned
        return LinkFrames(position, rotation, anchor, axis)

    def velocities(self, frames: LinkFrames, rows: Index, points: Array) -> Array:
        """Return how points on bodies shift with the joints, (n, j, k, 3) [m/rad].

        Parameters
        ----------
        frames
        rows : (k,)
            Of the bodies that they are fixed to.
        points : (n, k, 3) [m]
        """
        made = np.zeros((len(points), len(self._start), *points.shape[1:]))
        point, joint = np.nonzero(self.moves[rows])
        turning = ~self.slides[joint]
        p, j = point[turning], joint[turning]
        made[:, j, p] = cross(frames.axis[:, j], points[:, p] - frames.anchor[:, j])
        p, j = point[~turning], joint[~turning]
        made[:, j, p] = frames.axis[:, j]
        return made

    def turns(self, frames: LinkFrames, rows: Index, directions: Array) -> Array:
        """Return how directions fixed to bodies turn with the joints, (n, j, k, 3) [1/rad]."""
        made = np.zeros((len(directions), len(self._start), *directions.shape[1:]))
        point, joint = np.nonzero(self.moves[rows] & ~self.slides)
        made[:, joint, point] = cross(frames.axis[:, joint], directions[:, point])
        return made


@dataclass(frozen=True)
class _Joint:
    """A joint by its row: axis and anchor in its body; None for what is at the origin.

    ``along`` is the number of the body's own axis that it turns about, forwards or backwards by
    ``sign``; None if it is none of them.
    """

    row: int
    axis: Array
    pos: Array | None
    along: int | None
    sign: float


@dataclass(frozen=True)
class _Moving:
    """A body that joints move: its pose in its parent, None for what leaves it as it is."""

    row: int
    parent: int
    pos: Array | None
    turn: Array | None
    joints: tuple[_Joint, ...]


def _pose_of(model: mujoco.MjModel, body: int) -> tuple[Array | None, Array | None]:
    pos, quat = model.body_pos[body].copy(), model.body_quat[body]
    turn = Rotation.from_quat(quat, scalar_first=True).as_matrix()
    same = np.abs(turn - np.eye(3)).max() < 1e-12
    return (pos if pos.any() else None), (None if same else turn)


def _hinge_or_slide(model: mujoco.MjModel, joint: int, row: int) -> _Joint:
    axis, pos = model.jnt_axis[joint].copy(), model.jnt_pos[joint].copy()
    along = int(np.argmax(np.abs(axis)))
    own = abs(abs(axis[along]) - 1) < 1e-12
    return _Joint(
        row, axis, pos if pos.any() else None, along if own else None, float(np.sign(axis[along]))
    )


def _turned_about_own(rotations: Array, along: int, angle: Array) -> Array:
    """Return rotations (n, 3, 3) turned about one of their own axes by angles (n,) [rad]."""
    i, j = (along + 1) % 3, (along + 2) % 3
    cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]
    first, second = rotations[:, :, i], rotations[:, :, j]
    made = rotations.copy()
    made[:, :, i] = cosine * first + sine * second
    made[:, :, j] = cosine * second - sine * first
    return made
