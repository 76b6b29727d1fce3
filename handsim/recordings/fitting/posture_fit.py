"""The pose of the palm and the 20 angles of the hand, fitted to points in many frames at once.

Damped least squares (Levenberg-Marquardt) in which all frames take their steps together, each with
its own damping: per frame a system of 26 unknowns, three turns and three shifts of the palm and the
angles but the wrist's, which lie before the palm. Angles keep to the ranges of motion: one that
stands at an end and would leave it is left out of the step.

What the points leave open is decided by a prior: joints stay near the relaxed hand, DIP joints near
`DIP_PER_PIP` of the PIP joint. It is weak where all joints are seen, as with keypoints. Two markers
a finger leave more open, and their places on the skin are off by millimetres: there it is firm.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from handsim.hand.kinematics import cross
from handsim.joints import JOINT_INDEX, LOWER, N_JOINTS, UPPER
from handsim.recordings.fitting.hand_points import HandPoints, PalmPostures, are_seen
from handsim.recordings.fitting.rigid import apply, rotations_of
from handsim.recordings.fitting.start import rest_posture
from handsim.types import Array, Index, Mask

N_ANGLES = N_JOINTS - 2
"""Angles of the hand without the wrist's two, which are the last."""
N_UNKNOWNS = 6 + N_ANGLES
DIP_PER_PIP = 0.67
"""Flexion of a DIP joint for one of its PIP joint, in hands that hold nothing."""
WEAK_SD_DEG = {
    "mcp": 90.0, "pip": 90.0, "ip": 60.0, "abduction": 20.0, "rotation": 90.0,
    "dip": 15.0, "arch": 5.0,
}  # fmt: skip
"""Standard deviation of angles about the relaxed hand, by the last part of their names; of a DIP
joint about `DIP_PER_PIP` of its PIP joint [deg]."""
FIRM_SD_DEG = {
    "mcp": 18.0, "pip": 18.0, "ip": 12.0, "abduction": 4.0, "rotation": 18.0,
    "dip": 3.0, "arch": 2.0,
}  # fmt: skip
"""The same where markers on the skin are all that is seen. Chosen on one person's 20 reaches, of
which those left out are then learned better (0.96 of the straight line's error instead of 1.02), at
2.4 mm instead of 1.2 mm left over."""
CHUNK = 2048
"""Frames that are fitted together; more would take memory and not be faster."""
MAX_STEPS = 40
ENOUGH = 1e-4
"""Relative fall of the cost below which a frame is done."""


@dataclass(frozen=True)
class Prior:
    """The prior |C q - d|^2 as a quadratic: C'C, C'd and d'd.

    Attributes
    ----------
    matrix : (20, 20) [1/rad2]
    vector : (20,) or (n, 20) [1/rad]
    constant : () or (n,)
    """

    matrix: Array
    vector: Array
    constant: Array

    def cost(self, q: Array) -> Array:
        """Return the cost of angles (n, 20), (n,)."""
        return ((q @ self.matrix - 2 * self.vector) * q).sum(axis=1) + self.constant

    def slope(self, q: Array) -> Array:
        """Return half the derivative of the cost, (n, 20)."""
        return q @ self.matrix - self.vector

    def at(self, frames: slice | Index) -> "Prior":
        """Return the prior of some frames."""
        if not self.constant.ndim:
            return self
        return Prior(self.matrix, self.vector[frames], self.constant[frames])

    def with_pull(self, towards: Array, sd: float) -> "Prior":
        """Return the prior with a pull of each frame's angles to a posture (n, 20) of its own."""
        matrix = self.matrix + np.eye(N_ANGLES) / sd**2
        constant = self.constant + (towards**2).sum(axis=1) / sd**2
        return Prior(matrix, self.vector + towards / sd**2, constant)


def prior_of(sd_deg: Mapping[str, float]) -> Prior:
    """Return the prior of the module's docstring.

    Parameters
    ----------
    sd_deg
        `WEAK_SD_DEG` or `FIRM_SD_DEG`.
    """
    rows, wanted = np.zeros((N_ANGLES, N_ANGLES)), np.zeros(N_ANGLES)
    rest = rest_posture()
    for name, j in list(JOINT_INDEX.items())[:N_ANGLES]:
        kind = name.rsplit("_", maxsplit=1)[1]
        sd = sd_deg[kind]
        rows[j, j], wanted[j] = 1.0, rest[j]
        if kind == "dip":
            rows[j, JOINT_INDEX[name.replace("dip", "pip")]], wanted[j] = -DIP_PER_PIP, 0.0
        rows[j], wanted[j] = rows[j] / np.deg2rad(sd), wanted[j] / np.deg2rad(sd)
    return Prior(rows.T @ rows, rows.T @ wanted, np.array(wanted @ wanted))


def weak_prior() -> Prior:
    """Return the prior for points that show all joints."""
    return prior_of(WEAK_SD_DEG)


def fit_postures(
    points: HandPoints, seen: Array, start: PalmPostures, prior: Prior | None = None
) -> PalmPostures:
    """Fit every frame by itself.

    Parameters
    ----------
    points
    seen : (n, m, 3) [m]
        NaN where a point is not seen; at least three should be in every frame.
    start
        n postures, from `handsim.recordings.fitting.start`.
    prior
        By default `weak_prior`.
    """
    prior = prior or weak_prior()
    chunks = [slice(i, i + CHUNK) for i in range(0, len(seen), CHUNK)]
    parts = [_fit_chunk(points, seen[each], start.at(each), prior.at(each)) for each in chunks]
    return PalmPostures(
        np.concatenate([part.q for part in parts]),
        np.concatenate([part.rotation for part in parts]),
        np.concatenate([part.position for part in parts]),
    )


def predicted(points: HandPoints, postures: PalmPostures) -> Array:
    """Return where the points are in those postures, (n, m, 3) [m]."""
    hand = points.kinematics
    in_palm = hand.points(hand.frames(postures.q), points.on_hand)
    return apply(postures.rotation, in_palm) + postures.position[:, None]


@dataclass
class _State:
    """Where the frames of a chunk stand; changed in place."""

    postures: PalmPostures
    cost: Array
    damping: Array


def _fit_chunk(points: HandPoints, seen: Array, start: PalmPostures, prior: Prior) -> PalmPostures:
    q = np.clip(start.q, LOWER, UPPER)
    q[:, N_ANGLES:] = 0.0
    postures = PalmPostures(q, start.rotation.copy(), start.position.copy())
    state = _State(postures, frame_costs(points, seen, postures, prior), np.full(len(seen), 1e-3))
    active: Index = np.arange(len(seen))
    for _ in range(MAX_STEPS):
        if not len(active):
            break
        done = _step(points, seen, state, prior, active)
        active = active[~done]
    return state.postures


def _step(points: HandPoints, seen: Array, state: _State, prior: Prior, active: Index) -> Mask:
    """Let the active frames take a step; return which of them are done."""
    now, prior = state.postures.at(active), prior.at(active)
    matrix, down = step_equations(
        *linearised(points, seen[active], now), now, prior, state.damping[active]
    )
    step = np.asarray(np.linalg.solve(matrix, down[..., None])[..., 0], dtype=float)
    tried = moved(now, step)
    cost = frame_costs(points, seen[active], tried, prior)
    before = state.cost[active]
    better = cost < before
    taken = active[better]
    state.postures.q[taken] = tried.q[better]
    state.postures.rotation[taken] = tried.rotation[better]
    state.postures.position[taken] = tried.position[better]
    state.cost[taken] = cost[better]
    state.damping[active] *= np.where(better, 0.2, 8.0)
    small = better & (before - cost <= ENOUGH * before + 1e-12)
    return small | (state.damping[active] > 1e6)


def moved(postures: PalmPostures, step: Array) -> PalmPostures:
    """Return postures after a step (n, 26), angles clipped to their ranges."""
    q = postures.q.copy()
    q[:, :N_ANGLES] = np.clip(q[:, :N_ANGLES] + step[:, 6:], LOWER[:N_ANGLES], UPPER[:N_ANGLES])
    return PalmPostures(
        q,
        postures.rotation @ rotations_of(step[:, :3]),
        postures.position + apply(postures.rotation, step[:, 3:6]),
    )


def frame_costs(points: HandPoints, seen: Array, postures: PalmPostures, prior: Prior) -> Array:
    """Return the cost of each frame: squares in units of the noise, and the prior, (n,)."""
    off = np.nan_to_num(seen - predicted(points, postures)) / points.noise[:, None]
    return (off**2).sum(axis=(1, 2)) + prior.cost(postures.q[:, :N_ANGLES])


def linearised(points: HandPoints, seen: Array, postures: PalmPostures) -> tuple[Array, Array]:
    """Return residuals (n, 3 m) and their derivatives (n, 3 m, 26), in units of the noise.

    In the palm's frame, where the derivatives by its pose are simple: the pose changes to
    ``rotation @ exp(turn)``, ``position + rotation @ shift``.
    """
    hand = points.kinematics
    frames = hand.frames(postures.q)
    place = hand.points(frames, points.on_hand)
    n, m = place.shape[:2]
    off = apply(postures.rotation.swapaxes(1, 2), seen - postures.position[:, None]) - place
    there = are_seen(off) / points.noise
    slope = np.zeros((n, m, 3, N_UNKNOWNS))
    for axis in range(3):
        slope[..., axis] = cross(np.eye(3)[axis], place)
        slope[:, :, axis, 3 + axis] = 1.0
    slope[..., 6:] = hand.jacobian(frames, points.on_hand)[..., :N_ANGLES]
    slope *= there[..., None, None]
    return (np.nan_to_num(off) * there[..., None]).reshape(n, -1), slope.reshape(n, 3 * m, -1)


def step_equations(
    off: Array, slope: Array, postures: PalmPostures, prior: Prior, damping: Array
) -> tuple[Array, Array]:
    """Return the systems whose solutions are the frames' damped steps.

    An angle that stands at an end of its range and would leave it has a row of its own, with 1 on
    the diagonal and 0 on the right.

    Parameters
    ----------
    off, slope
        From `linearised`.
    postures
    prior
    damping : (n,)

    Returns
    -------
    matrix : (n, 26, 26)
    down : (n, 26)
    """
    transposed = slope.swapaxes(1, 2)
    matrix, down = transposed @ slope, (transposed @ off[..., None])[..., 0]
    q = postures.q[:, :N_ANGLES]
    matrix[:, 6:, 6:] += prior.matrix
    down[:, 6:] -= prior.slope(q)
    at_end = np.zeros(down.shape, dtype=bool)
    at_end[:, 6:] = ((q <= LOWER[:N_ANGLES]) & (down[:, 6:] < 0)) | (
        (q >= UPPER[:N_ANGLES]) & (down[:, 6:] > 0)
    )
    matrix *= ~(at_end[:, :, None] | at_end[:, None, :])
    diagonal = np.einsum("nii->ni", matrix)
    diagonal *= 1 + damping[:, None]
    diagonal += np.where(at_end, 1.0, 1e-9)
    return matrix, np.where(at_end, 0.0, down)


def told_joints(points: HandPoints, seen: Array) -> Mask:
    """Return of which joints the points seen in each frame tell: those that move one, (n, 22)."""
    there = are_seen(seen)
    return there @ points.kinematics.moves[points.on_hand.body]
