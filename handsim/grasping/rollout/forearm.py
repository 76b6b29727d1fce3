"""How the palm gets to where it is to be: its forearm is put there, or an arm carries it."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Sequence

import mujoco
import numpy as np

from handsim.arm.arm_geometry import ArmGeometry
from handsim.arm.arm_joints import N_ARM
from handsim.arm.arm_strength import leading_targets
from handsim.arm.reaching_arm import ArmPosture
from handsim.joints import JOINT_INDEX
from handsim.types import Array

WRIST = ("wrist_flexion", "wrist_deviation")
"""The wrist's joints, the proximal one first."""
WRIST_COLUMNS = slice(JOINT_INDEX[WRIST[0]], JOINT_INDEX[WRIST[-1]] + 1)
"""Of the wrist's joints in postures: one after the other, in this order."""

FEELING = 0.25
"""Time constant with which an arm that carries something is put where it was to be [s]: people see
and feel that it sags, and lift more."""
MOST_FELT = 0.3
"""Most that targets are moved for it [rad]: half of what a joint's greatest torque asks for."""

_Parts = Sequence[float | Array]
"""Components of vectors or quaternions: numbers of one, or arrays (n,) of several."""


class Wrist:
    """Finds the forearm's pose for a palm pose and wrist angles.

    MuJoCo moves the forearm, while plans say where the palm is to be. Wrist angles that differ from
    the plan's would otherwise carry the palm away.

    Parameters
    ----------
    model
        A model with a hand in it.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        palm, joints = model.body("palm"), [model.joint(name) for name in WRIST]
        self._pos, self._quat = palm.pos.tolist(), palm.quat.tolist()
        self._axes = [joint.axis.tolist() for joint in joints]

    def forearm(self, palm_pos: Array, palm_quat: Array, q: Array) -> tuple[Array, Array]:
        """Return positions (..., 3) [m] and orientations (..., 4) of the forearm.

        Parameters
        ----------
        palm_pos, palm_quat : (..., 3) [m], (..., 4)
            Poses of the palm.
        q : (..., 22) [rad]
            Postures, of which only the wrist angles count.
        """
        half = 0.5 * q[..., WRIST_COLUMNS]
        cosines, sines = _parts(np.cos(half)), _parts(np.sin(half))
        bent: _Parts = self._quat  # palm in the forearm's frame
        for cosine, sine, axis in zip(cosines, sines, self._axes, strict=True):
            bent = _product(bent, [cosine, *(sine * along for along in axis)])
        w, x, y, z = bent
        quat = _product(_parts(palm_quat), [w, -x, -y, -z])
        turned = _rows(quat, palm_quat.shape)
        if not any(self._pos):  # whatever the orientation is, undefined numbers included
            return palm_pos.copy(), turned
        return palm_pos - _rows(_turned(self._pos, quat), palm_pos.shape), turned


def _parts(rows: Array) -> _Parts:
    """Return the components of vectors (..., n): numbers, which are faster, where there is one."""
    n = rows.shape[-1]
    return rows.ravel().tolist() if rows.size == n else list(rows.reshape(-1, n).T)


def _rows(parts: _Parts, shape: tuple[int, ...]) -> Array:
    """Return vectors of a shape (..., n) from their components."""
    return np.array(parts).T.reshape(shape)


def _product(a: _Parts, b: _Parts) -> _Parts:
    """Multiply quaternions, rounded as by MuJoCo's function."""
    (aw, ax, ay, az), (bw, bx, by, bz) = a, b
    return [
        (aw * bw - ax * bx) - (ay * by + az * bz),
        (aw * bx + ax * bw) + (ay * bz - az * by),
        (aw * by - ax * bz) + (ay * bw + az * bx),
        (aw * bz + ax * by) - (ay * bx - az * bw),
    ]


def _turned(vector: Sequence[float], quat: _Parts) -> _Parts:
    """Turn a vector by quaternions, rounded as by MuJoCo's function."""
    w, x, y, z = quat
    a, b, c = vector
    i, j, k = w * a + y * c - z * b, w * b + z * a - x * c, w * c + x * b - y * a
    return [a + 2 * (y * k - z * j), b + 2 * (z * i - x * k), c + 2 * (x * j - y * i)]


class CarryingArms:
    """What the arms of n runs are commanded: where they are to be, and more where they sag.

    Parameters
    ----------
    postures
        Of the arms along the palms' paths, at equal steps of time.
    step
        Between them [s].
    geometry
        Of all of them.
    at : (n, 5) [rad]
        Where the arms' joints are, a live view.
    ctrl : (n_readings, n, 5) [rad]
        Where commands go: targets that lead as compliant joints need it.

    Attributes
    ----------
    wrist : (n_readings, n, 2) [rad]
        Angles of the wrists.
    """

    def __init__(
        self,
        postures: Sequence[ArmPosture],
        step: float,
        geometry: ArmGeometry,
        at: Array,
        ctrl: Array,
    ) -> None:
        self.wrist = np.stack([each.wrist for each in postures], axis=1)
        path = np.stack([each.arm for each in postures], axis=1)
        leading = np.stack([leading_targets(each.arm, step, geometry) for each in postures], axis=1)
        self._at, self._ctrl, self._share = at, ctrl, step / FEELING
        self._path, self._sags = path, np.zeros(path.shape[1:])
        ctrl[:] = leading
        # Of one run numbers are faster than arrays of five.
        self._numbers = [each[:, 0].ravel().tolist() for each in (self.wrist, path, leading)]
        self._own_sags = [0.0] * N_ARM

    def wrist_of_first(self, row: int) -> list[float]:
        """Return the angles of the first run's wrist at a reading, (2,) [rad]."""
        return self._numbers[0][len(WRIST) * row : len(WRIST) * (row + 1)]

    def lift(self, row: int) -> None:
        """Move the targets of a reading by how far arms that carry something have sagged."""
        share, most = self._share, MOST_FELT
        if len(self._at) > 1:
            self._sags += self._path[row] - self._at
            self._ctrl[row] += np.minimum(np.maximum(share * self._sags, -most), most)
            return
        (at,), sags, lifted = self._at.tolist(), self._own_sags, []
        _, path, leading = self._numbers
        place = N_ARM * row
        for joint, now in enumerate(at):
            sags[joint] += path[place] - now
            felt = share * sags[joint]
            felt = -most if felt < -most else most if felt > most else felt
            lifted.append(leading[place] + felt)
            place += 1
        self._ctrl[row, 0] = lifted
