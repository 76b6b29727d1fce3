"""From the coordinates of a robot hand to all its joints and the commands of its actuators."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Mapping

import mujoco
import numpy as np

from handsim.retargeting._actuation import driving_actuators, find_servos
from handsim.retargeting._couplings import find_couplings, offset_of, within_ranges
from handsim.types import Array, Index

_SLIDE = mujoco.mjtJoint.mjJNT_SLIDE.value


class JointMap:
    """Coordinates are the joints that are moved by no other; the others follow them.

    Parameters
    ----------
    model
    joints
        Ids of j joints.
    speeds
        Largest speeds of joints by name.

    Attributes
    ----------
    names
        Of the joints.
    actuators
        Ids of those that move them.
    free : (m,)
        Places of the coordinates among the joints.
    start : (j,)
        Reference posture.
    lower, upper, speed : (m,)
        What joints that follow and actuators allow.
    """

    def __init__(
        self, model: mujoco.MjModel, joints: list[int], speeds: Mapping[str, float]
    ) -> None:
        self.names = tuple(model.joint(j).name for j in joints)
        self.actuators = driving_actuators(model, joints)
        self._couplings = find_couplings(model, joints)
        self._servos = find_servos(model, self.actuators, joints)
        led = {coupling.joint for coupling in self._couplings}
        self.free: Index = np.array([i for i in range(len(joints)) if i not in led], dtype=int)
        self.start: Array = model.qpos0[model.jnt_qposadr[joints]].copy()
        straight = all(not c.coefficients[2:].any() for c in self._couplings)
        self._constant: Array | None = self._slopes(self.start[None])[0] if straight else None
        lower, upper = self._ranges(model, joints)
        self.lower, self.upper = self._as_actuators_can(lower[self.free], upper[self.free])
        self.speed = self._speeds(speeds)

    def positions(self, x: Array) -> Array:
        """Return the positions of all joints, (..., j) [rad or m], from (..., m)."""
        positions = np.empty((*np.shape(x)[:-1], len(self.start)))
        positions[...] = self.start
        positions[..., self.free] = x
        for coupling in self._couplings:
            ahead = offset_of(positions, coupling.leader, self.start)
            first, second, *rest = coupling.coefficients
            follows = first + second * ahead
            for power, coefficient in enumerate(rest, start=2):
                if coefficient:
                    follows = follows + coefficient * ahead**power
            positions[..., coupling.joint] = self.start[coupling.joint] + follows
        return positions

    def commands(self, x: Array) -> Array:
        """Return the controls of the actuators, (..., a); NaN for those that are no servos."""
        return self._servos.commands(self.positions(np.asarray(x, dtype=float)))

    def slopes(self, x: Array) -> Array:
        """Return the derivatives of all joints by the coordinates, (j, m).

        (n, j, m) where couplings are curved, and differ from posture to posture.
        """
        if self._constant is not None:
            return self._constant
        return self._slopes(self.positions(x))

    def by_coordinate(self, rates: Array, x: Array) -> Array:
        """Turn rates by joints, (n, j, ...), into rates by coordinates, (n, m, ...)."""
        made = rates[:, self.free]
        slopes = self.slopes(x)
        beyond = (1,) * (rates.ndim - 2)
        for coupling in self._couplings:
            row = slopes[..., coupling.joint, :]  # (m,) or (n, m)
            for i in np.flatnonzero(row.reshape(-1, row.shape[-1]).any(axis=0)):
                slope = row[..., i].reshape(-1, *beyond)
                made[:, i] += slope * rates[:, coupling.joint]
        return made

    def _slopes(self, positions: Array) -> Array:
        made = np.zeros((len(positions), len(self.start), len(self.free)))
        made[:, self.free, np.arange(len(self.free))] = 1.0
        for coupling in self._couplings:
            if coupling.leader >= 0:
                ahead = offset_of(positions, coupling.leader, self.start)
                slope = np.polynomial.Polynomial(coupling.coefficients).deriv()(ahead)
                made[:, coupling.joint] = slope[:, None] * made[:, coupling.leader]
        return made

    def _ranges(self, model: mujoco.MjModel, joints: list[int]) -> tuple[Array, Array]:
        """Return the ends of all joints' ranges, (j,) each, followers taken into account."""
        half = np.where(model.jnt_type[joints] == _SLIDE, 0.1, np.pi)
        limited = model.jnt_limited[joints].astype(bool)
        lower = np.where(limited, model.jnt_range[joints, 0], self.start - half)
        upper = np.where(limited, model.jnt_range[joints, 1], self.start + half)
        return within_ranges(self._couplings, self.start, lower, upper)

    def _as_actuators_can(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """Narrow ranges to what servos of one coordinate each can hold."""
        if self._constant is None:
            return lower, upper
        servos, reference = self._servos, self.start[self.free]
        slopes = servos.slopes @ self._constant
        offsets = servos.slopes @ self.positions(reference) + servos.offsets
        for k, row in enumerate(slopes):
            (moved,) = np.nonzero(np.nan_to_num(row))
            if len(moved) != 1 or not np.isfinite(row).all():
                continue
            i = moved[0]
            ends = np.array([servos.lower[k], servos.upper[k]])
            with np.errstate(all="ignore"):
                low, high = np.sort((ends - offsets[k]) / row[i] + reference[i])
            if max(low, lower[i]) < min(high, upper[i]):
                lower[i], upper[i] = max(low, lower[i]), min(high, upper[i])
        return lower, upper

    def _speeds(self, said: Mapping[str, float]) -> Array:
        """Return the largest speeds of the coordinates, those of followers taken into account."""
        joints = np.array([said.get(name, np.inf) for name in self.names])
        slopes = np.abs(self._slopes(self.start[None])[0])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            each = np.where(slopes > 0, joints[:, None] / slopes, np.inf)
        return each.min(axis=0)
