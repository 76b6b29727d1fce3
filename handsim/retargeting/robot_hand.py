"""Fingertips of any hand given as MJCF or URDF, in the frame of its palm, with their Jacobians.

The user says which sites or bodies are the palm and the fingertips, or they are proposed from the
file (`handsim.robot_hands`); everything else (which joints move them, their ranges and couplings,
where fingers begin and how long they are) is read from the model. The human hand of this package
is described in the same way.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from handsim.content import ByContent
from handsim.errors import InputError, UnknownNameError
from handsim.joints import FINGERS, Finger
from handsim.retargeting._finger_joints import check_joints, joints_between, own_joints, place_of
from handsim.retargeting._joint_map import JointMap
from handsim.retargeting._links import LinkFrames, Links
from handsim.robot_hands.finger_lines import finger_line, length_of
from handsim.robot_hands.hand_frames import AttachedFrame, HandFrames, read_frames
from handsim.robot_hands.hand_proposals import propose_frames
from handsim.robot_hands.reading.hand_alone import hand_alone
from handsim.robot_hands.reading.hand_file import HandFile, read_hand_file
from handsim.types import Array, Index, Side

__all__ = ["AttachedFrame", "Fingertips", "RobotHand"]

_SLIDE = mujoco.mjtJoint.mjJNT_SLIDE.value


@dataclass(frozen=True, eq=False)
class Fingertips(ByContent):
    """Where k fingertips are in the palm's frame, and how they move with ``x``.

    Of one posture, or of several: then a leading axis counts them.

    Attributes
    ----------
    points : (..., k, 3)
        Where they touch [m].
    directions : (..., k, 3)
        Unit vectors out of the fingers.
    backs : (..., k, 3)
        Unit vectors out of the backs of the fingertips.
    d_points, d_directions, d_backs : (..., k, 3, m)
        Derivatives by the m coordinates [m/rad, 1/rad; per m for slides].
    """

    points: Array
    directions: Array
    backs: Array
    d_points: Array
    d_directions: Array
    d_backs: Array


class RobotHand:
    """The fingers of a hand, from a file or spec.

    Coordinates ``x`` are the joints on the ways from palm to fingertips that are free: neither
    moved by another joint (``<equality><joint>``, a mimic of URDF, or a tendon whose one actuator
    moves both) nor part of the wrist or the arm, which stay in the model's reference posture.

    Parameters
    ----------
    source
        An MJCF or URDF file, or a spec.
    palm
        The palm's `AttachedFrame`, or the name of a site or body: x distal, z dorsal. Left out,
        palm and fingertips are proposed from the file; ``handsim hand inspect`` shows them.
    fingertips
        For each finger that the hand has a counterpart of, its fingertip's `AttachedFrame`, or the
        name of a site or body. A hand with fewer fingers leaves some out.
    knuckles
        Name of the joint at which a finger begins, where that is not the first joint that moves
        this fingertip alone: for a little finger whose metacarpal moves with it.
    frames
        Instead of these three: `HandFrames`, or a TOML file that ``handsim hand inspect`` wrote and
        the user corrected. A file that is beside the hand's, ``NAME.toml``, is taken by itself.
    folders
        Where meshes of ``package://`` may be besides the folders about the hand's file.

    Attributes
    ----------
    spec, model
        The hand, and the compiled model.
    frames
        Palm and fingertips.
    side
        Which human hand it resembles.
    notes
        What was mended or left out of the file, and where the frames come from.
    fingers
        Those given, thumb first; the order of all arrays over fingers.
    joint_names
        All joints between palm and fingertips, (n_joints,), those that follow others included.
    actuator_names
        Of the actuators that move these joints, (n_actuators,).
    lower, upper, reference : (m,)
        Range and reference value of each coordinate [rad, or m for slides], in which the joints
        that follow it stay in their ranges too, and actuators in theirs; without a range, half a
        turn (or 0.1 m) about the reference.
    speed : (m,)
        Largest speed that the file says [rad/s, m/s for slides]; infinite where it says none.
    slides : (m,)
        Which coordinates are slides.
    roots : (n, 3)
        Where the fingers begin, reference posture, palm frame [m].
    reach : (n,)
        Length of the finger from there over its joints to the tip [m].

    Raises
    ------
    FileError
        If the file is missing or MuJoCo cannot read it.
    UnknownNameError
        If a name is neither a site nor a body, a knuckle no joint of its finger, or a key not a
        finger.
    InputError
        If no finger is given or found, a fingertip has no joint of its own, or joints are balls or
        bound together otherwise than by ``<equality><joint>``.
    """

    def __init__(
        self,
        source: mujoco.MjSpec | Path | str,
        palm: AttachedFrame | str | None = None,
        fingertips: Mapping[Finger, AttachedFrame | str] | None = None,
        knuckles: Mapping[Finger, str] | None = None,
        *,
        frames: HandFrames | Path | str | None = None,
        folders: Sequence[Path] = (),
    ) -> None:
        self._given = source, palm, fingertips, knuckles, frames, folders
        if (palm is None) != (fingertips is None) or (palm is not None and frames is not None):
            raise InputError("give palm and fingertips, or frames, or none of them")
        file = (
            HandFile(source, source.compile(), {}, ())
            if isinstance(source, mujoco.MjSpec)
            else read_hand_file(source, folders)
        )
        if palm is not None and fingertips is not None:
            frames = _given(palm, fingertips, knuckles or {})
        elif frames is None and isinstance(source, Path | str):
            beside = Path(source).with_suffix(".toml")
            frames = beside if beside.is_file() else None
        if frames is None:
            frames = propose_frames(file.model, file.placeholders)
        elif isinstance(frames, Path | str):
            frames = read_frames(frames)
        file = hand_alone(file, frames)
        self.spec, self.model, self.placeholders = file.spec, file.model, file.placeholders
        self.frames = frames
        self.side: Side = frames.side
        self.notes = (*file.notes, f"palm and fingertips: {frames.origin}")
        self._set_up(frames, file)

    def __reduce__(self) -> tuple[Any, ...]:
        """Let another process read the same file; a hand from a spec cannot be passed on."""
        *given, frames, folders = self._given
        return partial(RobotHand, frames=frames, folders=folders), tuple(given)

    def _set_up(self, frames: HandFrames, file: HandFile) -> None:
        """Find joints, couplings and ranges, and measure the fingers."""
        model, given = self.model, frames.fingertips
        self.fingers: tuple[Finger, ...] = tuple(f for f in FINGERS if f in given)
        if not self.fingers:
            raise InputError("no fingertip is given; name the site or body of one or more")
        self._palm = place_of(model, frames.palm)
        self._tips = [place_of(model, given[finger]) for finger in self.fingers]
        ways = [joints_between(model, self._palm[0], body) for body, _, _ in self._tips]
        own = own_joints(model, self.fingers, ways, frames.knuckles)
        joints = sorted(set[int]().union(*ways))
        check_joints(model, joints)
        self.joint_ids: Index = np.array(joints, dtype=np.int64)
        self.joint_map = JointMap(model, joints, file.speeds)
        self.joint_names, self.actuator_ids = self.joint_map.names, self.joint_map.actuators
        self.actuator_names = tuple(model.actuator(i).name for i in self.actuator_ids)
        self.lower, self.upper = self.joint_map.lower, self.joint_map.upper
        self.speed = self.joint_map.speed
        self.reference: Array = self.joint_map.start[self.joint_map.free]
        self.slides = model.jnt_type[self.joint_ids[self.joint_map.free]] == _SLIDE
        moved = [b for b in range(model.nbody) if joints_between(model, 0, b)]
        inside = [b for b in moved if set(joints_between(model, 0, b)) & set(joints)]
        self.links = Links(model, joints, [self._palm[0], *(t[0] for t in self._tips), *inside])
        self._tip_rows = self.links.rows([t[0] for t in self._tips])
        self._palm_row = self.links.rows([self._palm[0]])
        self._own = [[joints.index(j) for j in each] for each in own]
        self.roots, self.reach = self._measure(self._own)

    def finger_of_coordinates(self) -> Index:
        """Return which finger each coordinate moves, (m,), as an index of `FINGERS`.

        -1 for those that move several.
        """
        of_joints = np.full(len(self.joint_names), -1)
        for finger, joints in zip(self.fingers, self._own, strict=True):
            of_joints[joints] = FINGERS.index(finger)
        return of_joints[self.joint_map.free]

    def first_bodies(self) -> dict[Finger, str]:
        """Return the names of the bodies at which the fingers begin."""
        first = (self.joint_ids[joints[0]] for joints in self._own)
        bodies = (self.model.body(self.model.jnt_bodyid[joint]).name for joint in first)
        return dict(zip(self.fingers, bodies, strict=True))

    def joint_positions(self, x: Array) -> Array:
        """Return the positions of all joints, (..., n_joints) [rad or m], from (..., m)."""
        return self.joint_map.positions(x)

    def commands(self, x: Array) -> Array:
        """Return the controls of position servos that hold postures, (..., n_actuators).

        Within the actuators' ranges; NaN for actuators that are no position servos.

        Parameters
        ----------
        x : (..., m)
        """
        return self.joint_map.commands(x)

    def palm_pose(self) -> tuple[Array, Array]:
        """Return the palm's origin, (3,) [m], and axes, (3, 3), in the world, reference posture."""
        origin, axes = self._palm_in(self.link_frames(self.reference[None]))
        return origin[0], axes[0]

    @property
    def pads_are_known(self) -> bool:
        """Whether the fingertips' z points out of their backs; in frames by name it is free."""
        return self.frames.origin != "given"

    @property
    def palm_body(self) -> int:
        """Id of the body that the palm's frame is on."""
        return self._palm[0]

    def link_frames(self, x: Array) -> LinkFrames:
        """Return where all links are in the world, coordinates (n, m) given."""
        return self.links.frames(self.joint_positions(x))

    def forward(self, x: Array) -> Fingertips:
        """Return the fingertips at coordinates (m,), or at (n, m) of several postures."""
        at = np.atleast_2d(np.asarray(x, dtype=float))
        poses, rates = self.fingertips_in(self.link_frames(at), at)
        parts = [*poses, *(rate.transpose(0, 2, 3, 1) for rate in rates)]
        return Fingertips(*(part[0] if np.ndim(x) == 1 else part for part in parts))

    def fingertips_in(
        self, frames: LinkFrames, x: Array
    ) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
        """Return points, directions and backs of the fingertips, and how they move.

        Parameters
        ----------
        frames
            Of the links at ``x``.
        x : (n, m)

        Returns
        -------
        poses
            Three of (n, k, 3), in the palm's frame.
        rates
            Three of (n, m, k, 3).
        """
        links, rows = self.links, self._tip_rows
        poses, inside = self.poses_in(frames)
        rates = [links.velocities(inside, rows, poses[0])]
        rates += [links.turns(inside, rows, direction) for direction in poses[1:]]
        palm = np.broadcast_to(self._palm_row, rows.shape)
        if links.moves[self._palm_row].any():
            # What the palm would do to the same point is taken off: the palm may move, too.
            rates[0] -= links.velocities(inside, palm, poses[0])
            for i in (1, 2):
                rates[i] -= links.turns(inside, palm, poses[i])
        return poses, tuple(self.joint_map.by_coordinate(rate, x) for rate in rates)

    def poses_in(self, frames: LinkFrames) -> tuple[tuple[Array, ...], LinkFrames]:
        """Return points, directions and backs of the fingertips, and joints in the palm's frame.

        Returns
        -------
        poses
            Three of (n, k, 3).
        inside
            The frames with anchors and axes as seen from the palm.
        """
        origin, axes = self._palm_in(frames)
        position, turned = self._posed(frames, self._tip_rows, self._tips)
        points = (position - origin[:, None]) @ axes
        anchor = (frames.anchor - origin[:, None]) @ axes
        inside = LinkFrames(frames.position, frames.rotation, anchor, frames.axis @ axes)
        return (points, turned[..., 0] @ axes, turned[..., 2] @ axes), inside

    def _palm_in(self, frames: LinkFrames) -> tuple[Array, Array]:
        """Return the palm's origin, (n, 3), and axes, (n, 3, 3), in the world."""
        origin, axes = self._posed(frames, self._palm_row, [self._palm])
        return origin[:, 0], axes[:, 0]

    def _posed(
        self, frames: LinkFrames, rows: Index, places: Sequence[tuple[int, Array, Array]]
    ) -> tuple[Array, Array]:
        """Return origins (n, k, 3) and axes (n, k, 3, 3) of frames fixed to links."""
        turned = frames.rotation[:, rows]
        pos, axes = np.array([p for _, p, _ in places]), np.array([a for _, _, a in places])
        return frames.position[:, rows] + (turned @ pos[..., None])[..., 0], turned @ axes

    def _measure(self, own: list[list[int]]) -> tuple[Array, Array]:
        """Return where the fingers begin, (n, 3), and how long they are, (n,), in the reference."""
        frames = self.link_frames(self.reference[None])
        origin, axes = self._palm_in(frames)
        tips, _ = self._posed(frames, self._tip_rows, self._tips)
        lines = [
            finger_line(
                frames.anchor[0, joints],
                frames.axis[0, joints],
                tips[0, i],
                self.links.slides[joints],
            )
            for i, joints in enumerate(own)
        ]
        roots = np.array([line[0] for line in lines])
        return (roots - origin[0]) @ axes[0], np.array([length_of(line) for line in lines])


def _given(
    palm: AttachedFrame | str,
    fingertips: Mapping[Finger, AttachedFrame | str],
    knuckles: Mapping[Finger, str],
) -> HandFrames:
    """Return the frames that the user names in words of his own."""
    for finger in (*fingertips, *knuckles):
        if finger not in FINGERS:
            raise UnknownNameError("finger", finger, FINGERS)

    def attached(frame: AttachedFrame | str) -> AttachedFrame:
        return AttachedFrame(frame) if isinstance(frame, str) else frame

    tips: dict[Finger, AttachedFrame] = {f: attached(frame) for f, frame in fingertips.items()}
    return HandFrames(attached(palm), tips, knuckles)
