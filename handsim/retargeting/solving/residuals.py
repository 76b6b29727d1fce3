"""What a fit of n postures leaves over, frame by frame, and its derivatives.

For k fingers, with p fingertips, h targets, L the mean length of the robot's fingers:

    w_o (|p_i - p_t| - |s (h_i - h_t)|) / L     openings between thumb and fingers, as distances
    w_v (p_i - p_t - s (h_i - h_t)) / L         and as vectors
    w_t (p_i - p_i*) / L                        fingertips, the thumb's less
    w_d (a_i - a_i*),  w_b (b_i - b_i*)         directions out of the fingers and out of their backs
    w_c (d_0 - d)_+ / L                         links that are nearer to each other than d_0
    w_m (x - middle) / half range               decides only where nothing else does
"""

from dataclasses import dataclass

import numpy as np

from handsim.retargeting.robot_hand import RobotHand
from handsim.retargeting.solving.self_contact import NearLinks
from handsim.retargeting.solving.targets import Targets
from handsim.types import Array

_SOFT = 0.0005
"""Below this length a distance is rounded, so that its slope stays finite [m]."""
CLEARANCE = 0.0
"""Overlap that is let pass [m]."""


@dataclass(frozen=True)
class Weights:
    """What counts how much; errors are relative to the mean length of the robot's fingers.

    Attributes
    ----------
    opening, pinch
        Distances between thumb and fingers, far apart and touching.
    vector
        The same as vectors: which way the opening points.
    tip, thumb
        Fingertips at their targets; the thumb's apart, as it may stand elsewhere.
    direction, back
        Directions out of the fingers, and out of the backs of their tips.
    near
        Human distance over which ``pinch`` fades into ``opening``, / human finger's mean length.
    contact
        Overlap of links.
    previous
        Distance to the posture before [rad].
    speed
        Changes from posture to posture beyond what is allowed [rad].
    middle
        Distance to mid-range, / half of the range; decides only where nothing else does.
    """

    opening: float = 4.0
    pinch: float = 10.0
    vector: float = 2.0
    tip: float = 0.5
    thumb: float = 0.1
    direction: float = 0.08
    back: float = 0.04
    near: float = 0.5
    contact: float = 30.0
    previous: float = 0.05
    speed: float = 10.0
    middle: float = 0.0002


@dataclass(frozen=True)
class Quadratic:
    """A sum of squares about the present coordinates of each posture.

    Attributes
    ----------
    cost : (n,)
        Half of the sum of squares.
    gradient : (n, m)
    hessian : (n, m, m)
        By Gauss and Newton.
    """

    cost: Array
    gradient: Array
    hessian: Array


class Residuals:
    """The frame-by-frame part of a fit.

    Parameters
    ----------
    robot
    targets
        Of n postures.
    weights
    unit
        Mean length of the robot's fingers [m].
    """

    def __init__(
        self,
        robot: RobotHand,
        targets: Targets,
        weights: Weights,
        unit: float,
    ) -> None:
        self.robot, self.targets, self.weights, self.unit = robot, targets, weights, unit
        self.middle = (robot.lower + robot.upper) / 2
        self.half = np.maximum((robot.upper - robot.lower) / 2, 1e-9)
        self._thumb = robot.fingers.index("thumb") if "thumb" in robot.fingers else -1
        self._others = [i for i in range(len(robot.fingers)) if i != self._thumb]
        tip = np.full(len(robot.fingers), weights.tip)
        if self._thumb >= 0 and self._others:
            tip[self._thumb] = weights.thumb
        self._tip_weight = tip / unit
        i = self._others
        self._vectors = targets.vectors[:, i]
        self._wide = np.sqrt(np.sum(targets.openings[:, i] ** 2, axis=2) + _SOFT**2)
        near, counted = targets.nearness[:, i], targets.counted[:, i]
        counts = weights.opening + near * (weights.pinch - weights.opening)
        self._opening_weights = counted * counts / unit, weights.vector / unit * counted[..., None]

    def at(self, x: Array, near: NearLinks | None = None) -> Quadratic:
        """Return cost, slope and curvature at coordinates (n, m).

        Parameters
        ----------
        x
        near
            Links that are near each other; None leaves them out.
        """
        robot, goal, weights = self.robot, self.targets, self.weights
        poses, rates = robot.fingertips_in(robot.link_frames(x), x)
        (points, directions, backs), (d_points, d_directions, d_backs) = poses, rates
        n, m = x.shape
        errors: list[Array] = []
        slopes: list[Array] = []

        def add(error: Array, slope: Array) -> None:
            """Add errors (n, ...) and their slopes (n, m, ...)."""
            errors.append(error.reshape(n, -1))
            slopes.append(slope.reshape(n, m, -1))

        if self._thumb >= 0 and self._others:
            i, t = self._others, slice(self._thumb, self._thumb + 1)
            apart, d_apart = points[:, i] - points[:, t], d_points[:, :, i] - d_points[:, :, t]
            weight, vector = self._opening_weights
            far = np.sqrt(np.sum(apart**2, axis=2) + _SOFT**2)
            along = apart / far[..., None]
            d_far = np.sum(along[:, None] * d_apart, axis=3)
            add(weight * (far - self._wide), weight[:, None] * d_far)
            add(vector * (apart - self._vectors), vector[:, None] * d_apart)
        tip = self._tip_weight[:, None]
        add(tip * (points - goal.points), tip * d_points)
        add(weights.direction * (directions - goal.directions), weights.direction * d_directions)
        if weights.back:
            add(weights.back * (backs - goal.backs), weights.back * d_backs)
        error, slope = np.concatenate(errors, axis=1), np.concatenate(slopes, axis=2)
        gradient = (slope @ error[..., None])[..., 0]
        hessian = slope @ slope.swapaxes(1, 2)
        cost = 0.5 * np.sum(error**2, axis=1)
        off = weights.middle * (x - self.middle) / self.half
        cost += 0.5 * np.sum(off**2, axis=1)
        gradient += weights.middle / self.half * off
        hessian[:, np.arange(m), np.arange(m)] += (weights.middle / self.half) ** 2
        if near is not None and len(near.posture):
            self._add_near(near, x, cost, gradient, hessian)
        return Quadratic(cost, gradient, hessian)

    def _add_near(
        self, near: NearLinks, x: Array, cost: Array, gradient: Array, hessian: Array
    ) -> None:
        """Add the overlaps that are beyond what is let pass."""
        over = near.weight / self.unit * np.maximum(-CLEARANCE - near.distance_at(x), 0.0)
        kept = over > 0
        at, over = near.posture[kept], over[kept]
        rates = -(near.weight[kept] / self.unit)[:, None] * near.rates[kept]
        if not len(at):
            return
        first = np.flatnonzero(np.diff(at, prepend=-1))  # contacts come posture by posture
        which = at[first]
        cost[which] += np.add.reduceat(0.5 * over**2, first)
        gradient[which] += np.add.reduceat(rates * over[:, None], first)
        hessian[which] += np.add.reduceat(rates[:, :, None] * rates[:, None, :], first)
