"""Where the parts of the hand are in a posture, for many postures at once, and the derivatives.

The compiled model gives the same places one posture at a time. Here they come from the same table,
`handsim.hand.skeleton.segments`, in NumPy alone, so that recordings can be fitted without MuJoCo.

Frame: that of the forearm, as in `handsim.hand.anthropometry`: origin at the wrist centre, +x
distal, +y to the thumb's side of a right hand, +z dorsal. With both wrist angles 0 it is the frame
of the palm. The left hand is the mirror image y -> -y, as in the compiled model.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from handsim.errors import InputError, UnknownNameError
from handsim.hand.anthropometry import LENGTHS, HandGeometry, segment_names
from handsim.hand.skeleton import Segment, segments
from handsim.joints import FINGERS, JOINT_INDEX, N_JOINTS
from handsim.types import MEDIAN_HAND, Array, HandSize, Index, Mask


@dataclass(frozen=True)
class BodyFrames:
    """Frames of the bodies and axes of the joints in n postures.

    Attributes
    ----------
    position : (n, 17, 3) [m]
        Origins of the bodies, which are joint centres.
    rotation : (n, 17, 3, 3)
        Columns are the bodies' axes.
    axis : (n, 22, 3)
        Unit vectors that a positive angle turns about, glove order.
    """

    position: Array
    rotation: Array
    axis: Array


@dataclass(frozen=True)
class PointsOnHand:
    """Points fixed to bodies.

    Attributes
    ----------
    body : (m,)
        Index of the body in `Kinematics.bodies`.
    place : (m, 3) [m]
        In the frame of the body.
    """

    body: Index
    place: Array


@dataclass(frozen=True)
class Kinematics:
    """The moving bodies of a hand of one size.

    Raises
    ------
    InputError
        If the size is outside what can be built.

    Examples
    --------
    >>> import numpy as np
    >>> hand = Kinematics()
    >>> tips = hand.points(hand.frames(np.zeros((1, 22))), hand.fingertips)
    >>> tips.shape
    (1, 5, 3)
    """

    size: HandSize = MEDIAN_HAND

    @cached_property
    def bodies(self) -> tuple[Segment, ...]:
        """The 17 bodies of the right hand of this size, parents first."""
        return segments(HandGeometry(self.size))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the bodies, in the order of `bodies`."""
        return tuple(body.name for body in self.bodies)

    @cached_property
    def fingertips(self) -> PointsOnHand:
        """The five fingertips, thumb first."""
        lengths = [LENGTHS[finger][2] * self.size.length for finger in FINGERS]
        return self.at(
            [segment_names(finger)[2] for finger in FINGERS],
            [[length, 0.0, 0.0] for length in lengths],
        )

    @cached_property
    def joint_centres(self) -> PointsOnHand:
        """Origins of all bodies, in the order of `bodies`."""
        return self.at(self.names, np.zeros((len(self.names), 3)))

    def aperture(self, q: Array) -> Array:
        """Return the distances of thumb tip and index tip (n,) [m] in postures (n, 22) [rad]."""
        tips = self.points(self.frames(q), self.fingertips)
        return np.asarray(np.linalg.norm(tips[:, 0] - tips[:, 1], axis=1))

    def at(self, bodies: Sequence[str], places: Array | Sequence[Sequence[float]]) -> PointsOnHand:
        """Return points fixed to bodies by name.

        Parameters
        ----------
        bodies
            m names.
        places : (m, 3) [m]
            In the frames of the bodies; of a left hand, in its own.
        """
        unknown = next((name for name in bodies if name not in self.names), None)
        if unknown is not None:
            raise UnknownNameError("body", unknown, self.names)
        index = np.array([self.names.index(name) for name in bodies], dtype=np.int64)
        return PointsOnHand(index, np.asarray(places, dtype=float).reshape(len(index), 3))

    def frames(self, q: Array, last: str | None = None) -> BodyFrames:
        """Return the frames of all bodies.

        Parameters
        ----------
        q : (n, 22) [rad], glove order
        last
            Name of a body: only it and those that carry it are placed, which takes less time.
        """
        if q.ndim != 2 or q.shape[1] != N_JOINTS:
            raise InputError(f"postures of shape {q.shape}; give (n, {N_JOINTS})")
        n = len(q)
        position = np.zeros((n, len(self.bodies), 3))
        rotation = np.zeros((n, len(self.bodies), 3, 3))
        axis = np.zeros((n, N_JOINTS, 3))
        for i in range(len(self.bodies)) if last is None else self._carrying(last):
            body = self.bodies[i]
            if body.parent in self.names:
                parent = self.names.index(body.parent)
                turned = times(rotation[:, parent], body.axes)
                position[:, i] = position[:, parent] + rotation[:, parent] @ body.origin
            else:
                turned = np.broadcast_to(body.axes, (n, 3, 3))
            for hinge in body.hinges:
                j = JOINT_INDEX[hinge.joint.name]
                axis[:, j] = turned @ hinge.axis
                turned = turned_about(turned, hinge.axis, q[:, j])
            rotation[:, i] = turned
        if self.size.side == "left":
            position, rotation = position * _MIRROR, _MIRROR[:, None] * rotation * _MIRROR
            axis = -axis * _MIRROR  # an axis is no arrow: its mirror image turns the other way
        return BodyFrames(position, rotation, axis)

    def _carrying(self, last: str) -> list[int]:
        """Return a body and those that carry it, parents first."""
        chain, name = [], last
        while name in self.names:
            chain.append(self.names.index(name))
            name = self.bodies[chain[-1]].parent
        return chain[::-1]

    def points(self, frames: BodyFrames, points: PointsOnHand) -> Array:
        """Return where points are, (n, m, 3) [m]."""
        turned = np.einsum("nmij,mj->nmi", frames.rotation[:, points.body], points.place)
        return frames.position[:, points.body] + turned

    def jacobian(self, frames: BodyFrames, points: PointsOnHand) -> Array:
        """Return the derivatives of `points` by the 22 angles, (n, m, 3, 22) [m/rad]."""
        point, joint = np.nonzero(self.moves[points.body])
        anchor = frames.position[:, self._body_of_joint[joint]]
        arm = self.points(frames, points)[:, point] - anchor
        made = np.zeros((len(arm), len(points.body), N_JOINTS, 3))
        made[:, point, joint] = cross(frames.axis[:, joint], arm)
        return made.swapaxes(2, 3)

    @cached_property
    def _body_of_joint(self) -> Index:
        places = {
            hinge.joint.name: i for i, body in enumerate(self.bodies) for hinge in body.hinges
        }
        return np.array([places[name] for name in JOINT_INDEX], dtype=np.int64)

    @cached_property
    def moves(self) -> Mask:
        """Whether a joint moves a body, (17, 22)."""
        moves = np.zeros((len(self.bodies), N_JOINTS), dtype=bool)
        for i, body in enumerate(self.bodies):
            if body.parent in self.names:
                moves[i] = moves[self.names.index(body.parent)]
            moves[i, [JOINT_INDEX[hinge.joint.name] for hinge in body.hinges]] = True
        return moves


_MIRROR = np.array([1.0, -1.0, 1.0])


def times(matrices: Array, constant: Array) -> Array:
    """Return matrices (n, 3, 3) times a constant one (3, 3), as one product of the whole stack."""
    return (matrices.reshape(-1, 3) @ constant).reshape(-1, 3, 3)


def turned_about(rotations: Array, axis: Array, angle: Array) -> Array:
    """Return rotations (n, 3, 3) times those about a unit vector (3,) by angles (n,) [rad].

    By Rodrigues' formula: 1 + sin K + (1 - cos) K^2, with K the cross product by the axis.
    """
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, rest = np.sin(angle)[:, None, None], (1 - np.cos(angle))[:, None, None]
    return rotations + sine * times(rotations, skew) + rest * times(rotations, skew @ skew)


def cross(a: Array, b: Array) -> Array:
    """Return the cross products of vectors (..., 3); NumPy's own takes several times as long."""
    made = np.empty(np.broadcast_shapes(a.shape, b.shape))
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        made[..., i] = a[..., j] * b[..., k] - a[..., k] * b[..., j]
    return made
