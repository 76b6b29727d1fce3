"""Fingertips of any hand given as MJCF, in the frame of its palm, with their Jacobians.

The user says which sites or bodies are the palm and the fingertips; everything else (which joints
move them, their ranges and couplings, where fingers begin and how long they are) is read from the
model. The human hand of this package is described in the same way.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from handsim.content import ByContent
from handsim.errors import FileError, InputError, UnknownNameError
from handsim.joints import FINGERS, Finger
from handsim.retargeting._actuation import commands, driving_actuators
from handsim.retargeting._couplings import find_couplings, offset_of, within_ranges
from handsim.types import Array

_SITE, _BODY = mujoco.mjtObj.mjOBJ_SITE.value, mujoco.mjtObj.mjOBJ_BODY.value
_HINGE, _SLIDE = mujoco.mjtJoint.mjJNT_HINGE.value, mujoco.mjtJoint.mjJNT_SLIDE.value
_CONNECT, _WELD = mujoco.mjtEq.mjEQ_CONNECT.value, mujoco.mjtEq.mjEQ_WELD.value
_TENDON = mujoco.mjtEq.mjEQ_TENDON.value


@dataclass(frozen=True)
class AttachedFrame:
    """A frame fixed to a site or body of the model.

    Attributes
    ----------
    name
        Of a site, or else of a body.
    pos, quat
        Pose in it: (3,) [m], (4,) w, x, y, z. A palm's x points distal and z dorsal; a fingertip's
        origin is where it touches things and x points out of the finger.
    """

    name: str
    pos: tuple[float, float, float] = (0.0, 0.0, 0.0)
    quat: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Fingertips(ByContent):
    """Where the fingertips are in the palm's frame, and how they move with ``x``.

    Attributes
    ----------
    points : (n, 3)
        Where they touch [m].
    directions : (n, 3)
        Unit vectors out of the fingers.
    d_points, d_directions : (n, 3, m)
        Derivatives by the m coordinates [m/rad, 1/rad; per m for slides].
    """

    points: Array
    directions: Array
    d_points: Array
    d_directions: Array


class RobotHand:
    """The fingers of a hand, from an MJCF file or spec.

    Coordinates ``x`` are the joints on the ways from palm to fingertips that are free: neither
    moved by another joint (``<equality><joint>``, or a tendon whose one actuator moves both) nor
    part of the wrist or the arm, which stay in the model's reference posture.

    Parameters
    ----------
    source
        An MJCF or URDF file, or a spec.
    palm
        The palm's `AttachedFrame`, or the name of a site or body: x distal, z dorsal.
    fingertips
        For each finger that the hand has a counterpart of, its fingertip's `AttachedFrame`, or the
        name of a site or body. A hand with fewer fingers leaves some out.
    knuckles
        Name of the joint at which a finger begins, where that is not the first joint that moves
        this fingertip alone: for a little finger whose metacarpal moves with it.

    Attributes
    ----------
    model
        The compiled model.
    fingers
        Those given, thumb first; the order of all arrays over fingers.
    joint_names
        All joints between palm and fingertips, (n_joints,), those that follow others included.
    actuator_names
        Of the actuators that move these joints, (n_actuators,).
    lower, upper, reference : (m,)
        Range and reference value of each coordinate [rad, or m for slides], in which the joints
        that follow it stay in their ranges too; without a range, half a turn (or 0.1 m) about the
        reference.
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
        If no finger is given, a fingertip has no joint of its own, or joints are balls or bound
        together otherwise than by ``<equality><joint>``.
    """

    def __init__(
        self,
        source: mujoco.MjSpec | Path | str,
        palm: AttachedFrame | str,
        fingertips: Mapping[Finger, AttachedFrame | str],
        knuckles: Mapping[Finger, str] | None = None,
    ) -> None:
        for finger in (*fingertips, *(knuckles or {})):
            if finger not in FINGERS:
                raise UnknownNameError("finger", finger, FINGERS)
        self.fingers: tuple[Finger, ...] = tuple(f for f in FINGERS if f in fingertips)
        if not self.fingers:
            raise InputError("no fingertip is given; name the site or body of one or more")
        self.model = _compile(source)
        self._data = mujoco.MjData(self.model)
        self._palm = self._place(palm)
        self._tips = [self._place(fingertips[finger]) for finger in self.fingers]
        ways = [self._joints_between(self._palm[0], body) for body, _, _ in self._tips]
        own = self._own_joints(ways, knuckles or {})
        joints = sorted(set().union(*ways))
        self._check_joints(joints)
        self.joint_names = tuple(self.model.joint(j).name for j in joints)
        self._qpos = self.model.jnt_qposadr[joints]
        self._dof = self.model.jnt_dofadr[joints]
        self._couplings = find_couplings(self.model, joints)
        self._actuators = driving_actuators(self.model, joints)
        self.actuator_names = tuple(self.model.actuator(i).name for i in self._actuators)
        led = {coupling.joint for coupling in self._couplings}
        self._free = np.array([i for i in range(len(joints)) if i not in led], dtype=int)
        self.reference: Array = self.model.qpos0[self._qpos][self._free]
        free = np.array(joints)[self._free]
        self.slides = self.model.jnt_type[free] == _SLIDE
        self.lower, self.upper = (ends[self._free] for ends in self._ranges(joints))
        self.roots, self.reach = self._measure(own)

    def joint_positions(self, x: Array) -> Array:
        """Return the positions of all joints, (..., n_joints) [rad or m], from (..., m)."""
        start = self.model.qpos0[self._qpos]
        positions = np.broadcast_to(start, (*np.shape(x)[:-1], len(start))).copy()
        positions[..., self._free] = x
        for coupling in self._couplings:
            ahead = offset_of(positions, coupling.leader, start)
            polynomial = np.polynomial.Polynomial(coupling.coefficients)
            positions[..., coupling.joint] = start[coupling.joint] + polynomial(ahead)
        return positions

    def commands(self, x: Array) -> Array:
        """Return the controls of position servos that hold postures, (..., n_actuators).

        Within the actuators' ranges; NaN for actuators that are no position servos.

        Parameters
        ----------
        x : (..., m)
        """
        positions = self.joint_positions(np.asarray(x, dtype=float))
        flat = positions.reshape(-1, positions.shape[-1])
        found = np.empty((len(flat), len(self._actuators)))
        for i, posture in enumerate(flat):
            self._data.qpos[self._qpos] = posture
            mujoco.mj_fwdPosition(self.model, self._data)
            found[i] = commands(self.model, self._data, self._actuators)
        return found.reshape(*positions.shape[:-1], -1)

    def palm_pose(self) -> tuple[Array, Array]:
        """Return the palm's origin, (3,) [m], and axes, (3, 3), in the world, reference posture."""
        self.forward(self.reference)
        origin, axes = self._pose(self._palm)
        return origin.copy(), axes

    def forward(self, x: Array) -> Fingertips:
        """Return the fingertips at coordinates (m,)."""
        positions = self.joint_positions(x)
        self._data.qpos[self._qpos] = positions
        mujoco.mj_kinematics(self.model, self._data)
        mujoco.mj_comPos(self.model, self._data)
        slopes = self._slopes(positions)
        origin, axes = self._pose(self._palm)
        n, m = len(self._tips), len(self._free)
        points, directions = np.empty((n, 3)), np.empty((n, 3))
        d_points, d_directions = np.empty((n, 3, m)), np.empty((n, 3, m))
        for i, tip in enumerate(self._tips):
            point, turned = self._pose(tip)
            # What the palm would do to the same point is taken off: the palm may move, too.
            shift, turn = self._jacobian(point, tip[0]) - self._jacobian(point, self._palm[0])
            direction = turned[:, 0]
            points[i], directions[i] = axes.T @ (point - origin), axes.T @ direction
            d_points[i] = axes.T @ shift @ slopes
            d_directions[i] = axes.T @ np.cross(turn.T, direction).T @ slopes
        return Fingertips(points, directions, d_points, d_directions)

    def _place(self, frame: AttachedFrame | str) -> tuple[int, Array, Array]:
        """Find a frame's body, and its origin (3,) and axes (3, 3) in it."""
        wanted = AttachedFrame(frame) if isinstance(frame, str) else frame
        turn = Rotation.from_quat(wanted.quat, scalar_first=True)
        pos = np.array(wanted.pos, dtype=float)
        model = self.model
        site = mujoco.mj_name2id(model, _SITE, wanted.name)
        if site >= 0:
            within = Rotation.from_quat(model.site_quat[site], scalar_first=True)
            pos, turn = model.site_pos[site] + within.apply(pos), within * turn
            return int(model.site_bodyid[site]), pos, turn.as_matrix()
        body = mujoco.mj_name2id(model, _BODY, wanted.name)
        if body < 0:
            sites = [model.site(i).name for i in range(model.nsite)]
            bodies = [model.body(i).name for i in range(model.nbody)]
            raise UnknownNameError("site or body", wanted.name, (*sites, *bodies))
        return body, pos, turn.as_matrix()

    def _joints_between(self, first: int, second: int) -> list[int]:
        apart = set(self._ancestors(first)) ^ set(self._ancestors(second))
        return [j for j in range(self.model.njnt) if self.model.jnt_bodyid[j] in apart]

    def _ancestors(self, body: int) -> list[int]:
        chain = [body]
        while chain[-1] > 0:
            chain.append(int(self.model.body_parentid[chain[-1]]))
        return chain

    def _check_joints(self, joints: list[int]) -> None:
        """Refuse what coordinates and couplings here cannot express."""
        for j in joints:
            if self.model.jnt_type[j] not in (_HINGE, _SLIDE):
                raise InputError(
                    f"joint '{self.model.joint(j).name}' is neither a hinge nor a slide; "
                    "split it into hinges"
                )
        moved = {int(self.model.jnt_bodyid[j]) for j in joints}
        for i in np.flatnonzero(self.model.eq_active0):
            kind, ends = self.model.eq_type[i], (self.model.eq_obj1id[i], self.model.eq_obj2id[i])
            if kind in (_CONNECT, _WELD):
                sites = self.model.eq_objtype[i] == _SITE
                bodies = {int(self.model.site_bodyid[end] if sites else end) for end in ends}
                bound = any(moved & set(self._ancestors(body)) for body in bodies)
            else:
                bound = kind == _TENDON
            if bound:
                raise InputError(
                    f"equality '{self.model.equality(i).name}' binds the fingers otherwise than "
                    "joint to joint; take it out of the file or give it active='false'"
                )

    def _slopes(self, positions: Array) -> Array:
        """Return the derivatives of all degrees of freedom by the coordinates, (nv, m)."""
        start = self.model.qpos0[self._qpos]
        slopes = np.zeros((len(positions), len(self._free)))
        slopes[self._free, np.arange(len(self._free))] = 1.0
        for coupling in self._couplings:
            if coupling.leader >= 0:
                ahead = offset_of(positions, coupling.leader, start)
                slope = np.polynomial.Polynomial(coupling.coefficients).deriv()(ahead)
                slopes[coupling.joint] = slope * slopes[coupling.leader]
        full = np.zeros((self.model.nv, len(self._free)))
        full[self._dof] = slopes
        return full

    def _ranges(self, joints: list[int]) -> tuple[Array, Array]:
        """Return the ends of all joints' ranges, (n_joints,) each, followers taken into account."""
        model, start = self.model, self.model.qpos0[self._qpos]
        half = np.where(model.jnt_type[joints] == _SLIDE, 0.1, np.pi)
        limited = model.jnt_limited[joints].astype(bool)
        lower = np.where(limited, model.jnt_range[joints, 0], start - half)
        upper = np.where(limited, model.jnt_range[joints, 1], start + half)
        return within_ranges(self._couplings, start, lower, upper)

    def _own_joints(self, ways: list[list[int]], knuckles: Mapping[Finger, str]) -> list[list[int]]:
        """Return the joints of each finger, from its knuckle to its tip."""
        own = []
        for i, (finger, way) in enumerate(zip(self.fingers, ways, strict=True)):
            if finger in knuckles:
                names = tuple(self.model.joint(j).name for j in way)
                if knuckles[finger] not in names:
                    raise UnknownNameError(f"joint of the {finger}", knuckles[finger], names)
                own.append(way[names.index(knuckles[finger]) :])
                continue
            shared = set().union(*ways[:i], *ways[i + 1 :])
            own.append([j for j in way if j not in shared])
            if not own[i]:
                raise InputError(
                    f"fingertip of the {finger} moves with no joint of its own; "
                    "name a site or body further out"
                )
        return own

    def _measure(self, own: list[list[int]]) -> tuple[Array, Array]:
        """Return where the fingers begin, (n, 3), and how long they are, (n,), in the reference."""
        points = self.forward(self.reference).points
        origin, axes = self._pose(self._palm)
        roots, reach = np.empty_like(points), np.empty(len(points))
        for i, joints in enumerate(own):
            places = np.vstack([(self._data.xanchor[joints] - origin) @ axes, points[i]])
            roots[i] = places[0]
            reach[i] = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
        return roots, reach

    def _pose(self, place: tuple[int, Array, Array]) -> tuple[Array, Array]:
        body, pos, axes = place
        rotation = self._data.xmat[body].reshape(3, 3)
        return self._data.xpos[body] + rotation @ pos, rotation @ axes

    def _jacobian(self, point: Array, body: int) -> Array:
        """Return how a point of a body shifts and turns with the degrees of freedom, (2, 3, nv)."""
        jacobian = np.zeros((2, 3, self.model.nv))
        mujoco.mj_jac(self.model, self._data, jacobian[0], jacobian[1], point, body)
        return jacobian


def _compile(source: mujoco.MjSpec | Path | str) -> mujoco.MjModel:
    if isinstance(source, mujoco.MjSpec):
        return source.compile()
    path = Path(source)
    if not path.is_file():
        raise FileError(f"{path}: no such file; give the robot hand as MJCF or URDF")
    try:
        return mujoco.MjSpec.from_file(str(path)).compile()
    except ValueError as error:
        reason = str(error).splitlines()[0]
        raise FileError(f"{path}: MuJoCo cannot read it ({reason}); correct the file") from error
