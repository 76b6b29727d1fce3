"""Real obstacles - a table, things that stand about - in the same beta as the learned one.

Each multiplies beta by b(t) = 1 - (1 - t)^3 with t the distance from its surface as a fraction of
a layer's width, and 1 beyond, as the outer boundary does (`navigation.obstacle`). So beta is 0 and
phi 1 on its surface, and no path of the flow that begins outside goes in.

*Planes.* Let the destination lie outside a plane's layer. In the layer a point is nearer to the
plane than the destination is, so that (z - z_goal) . grad ln b <= 0: where the learned beta
descends, (z - z_goal) . grad ln(beta) / k < 2, both together do. A field that is certified by
descent in the whole workspace stays so: a table changes nothing of the proof.

*Balls.* Behind a ball, as seen from the destination, that product grows without bound: there has to
be a saddle (Koditschek & Rimon 1990), and from a set of starts without volume paths end in it.
With what was learned beside it nothing is proved then, but that no path goes into the ball.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from handsim.navigation.obstacle import LogEvaluator, Obstacle, closing
from handsim.types import Array

_TINY_DEPTH = 1e-12


class Wall(Protocol):
    """The surface of an obstacle."""

    @property
    def width(self) -> float:
        """Thickness of the layer in which it acts, in the unit of the places."""
        ...

    @property
    def keeps_descent(self) -> bool:
        """Whether a field that descends in its layer does so with it, too."""
        ...

    def distance(self, z: Array) -> tuple[Array, Array, Array]:
        """Return distances (N,) of places (N, 3), their gradients and Hessians."""
        ...

    def near(self, z: list[float]) -> tuple[float, list[float]]:
        """Return the distance of one place and its gradient, in numbers: for loops."""
        ...

    def moved(self, axes: Array, origin: Array, unit: float) -> "Wall":
        """Return it in a frame with those axes (columns), that origin and that unit."""
        ...


@dataclass(frozen=True, eq=False)
class Plane:
    """A half space that is kept out of, as a table with what is below.

    Attributes
    ----------
    point, normal : (3,)
        On its surface, and the unit vector out of it.
    width
        Of the layer.
    """

    point: Array
    normal: Array
    width: float

    @property
    def keeps_descent(self) -> bool:
        """See the module."""
        return True

    def distance(self, z: Array) -> tuple[Array, Array, Array]:
        """As `Wall.distance`."""
        n = len(z)
        return (z - self.point) @ self.normal, np.tile(self.normal, (n, 1)), np.zeros((n, 3, 3))

    @cached_property
    def _numbers(self) -> tuple[list[float], list[float]]:
        return self.point.tolist(), self.normal.tolist()

    def near(self, z: list[float]) -> tuple[float, list[float]]:
        """As `Wall.near`."""
        point, normal = self._numbers
        return sum([(a - b) * n for a, b, n in zip(z, point, normal, strict=True)]), normal

    def moved(self, axes: Array, origin: Array, unit: float) -> "Plane":
        """As `Wall.moved`."""
        return Plane((self.point - origin) @ axes / unit, self.normal @ axes, self.width / unit)


@dataclass(frozen=True, eq=False)
class Ball:
    """A ball around a thing that the hand is to keep out of.

    Attributes
    ----------
    centre : (3,)
    radius, width
        Of the ball, and of the layer around it.
    """

    centre: Array
    radius: float
    width: float

    @property
    def keeps_descent(self) -> bool:
        """See the module."""
        return False

    def distance(self, z: Array) -> tuple[Array, Array, Array]:
        """As `Wall.distance`."""
        away = z - self.centre
        far = np.maximum(np.linalg.norm(away, axis=1), _TINY_DEPTH)
        out = away / far[:, None]
        across = np.eye(3) - out[:, :, None] * out[:, None, :]
        return far - self.radius, out, across / far[:, None, None]

    def near(self, z: list[float]) -> tuple[float, list[float]]:
        """As `Wall.near`."""
        away = [a - b for a, b in zip(z, self.centre.tolist(), strict=True)]
        far = max(sum([a * a for a in away]) ** 0.5, _TINY_DEPTH)
        return far - self.radius, [a / far for a in away]

    def moved(self, axes: Array, origin: Array, unit: float) -> "Ball":
        """As `Wall.moved`."""
        return Ball((self.centre - origin) @ axes / unit, self.radius / unit, self.width / unit)


@dataclass(frozen=True)
class WalledObstacle:
    """A learned obstacle and walls beside it, one beta.

    Attributes
    ----------
    learned
    walls
        In its coordinates.
    """

    learned: Obstacle
    walls: tuple[Wall, ...]

    @property
    def lower(self) -> Array:
        """Lower corner of the workspace, (3,)."""
        return self.learned.lower

    @property
    def upper(self) -> Array:
        """Upper corner of the workspace, (3,)."""
        return self.learned.upper

    @property
    def inner(self) -> tuple[Array, Array]:
        """Corners of the box of possible destinations; walls may take some of it away."""
        return self.learned.inner

    def evaluator(self, k: float) -> LogEvaluator:
        """Return a function of one point as 3 floats: ln beta, then its gradient."""
        learned = self.learned.evaluator(k)

        def log_jet(z: list[float]) -> list[float]:
            parts = learned(z)
            for wall in self.walls:
                distance, slope = wall.near(z)
                if distance < wall.width:
                    ln_b, first = closing(distance, wall.width)
                    parts[0] += ln_b
                    for i, part in enumerate(slope):
                        parts[i + 1] += first * part
            return parts

        return log_jet

    def log_jets(self, z: Array, k: float, order: int) -> tuple[Array, Array, Array]:
        """Return ln beta (N,), its gradients (N, 3) and Hessians (N, 3, 3) at points (N, 3)."""
        value, grad, hess = self.learned.log_jets(z, k, order)
        for wall in self.walls:
            distance, slope, bend = wall.distance(z)
            t = np.clip(distance / wall.width, _TINY_DEPTH, 1.0)
            b = t * (3 - 3 * t + t * t)
            first = 3 * (1 - t) ** 2 / b / wall.width
            value = value + np.log(b)
            if order >= 1:
                grad = grad + first[:, None] * slope
            if order >= 2:
                second = (-6 * (1 - t) / b) / wall.width**2 - first**2
                both = slope[:, :, None] * slope[:, None, :]
                hess = hess + second[:, None, None] * both + first[:, None, None] * bend
        return value, grad, hess


def keep_off(goal: Array, walls: Sequence[Wall]) -> tuple[Wall, ...]:
    """Return walls whose layers are thin enough that a destination lies outside them.

    A layer is made as thin as 0.9 of the destination's distance. A wall that the destination lies
    in or on cannot be kept out of and is left out: the palm is to go there.
    """
    kept: list[Wall] = []
    for wall in walls:
        room = float(wall.distance(goal[None])[0][0])
        if room > 1e-6:
            unit = max(wall.width / (0.9 * room), 1.0)
            kept.append(wall if unit == 1.0 else _thinner(wall, wall.width / unit))
    return tuple(kept)


def _thinner(wall: Wall, width: float) -> Wall:
    if isinstance(wall, Plane):
        return Plane(wall.point, wall.normal, width)
    assert isinstance(wall, Ball)
    return Ball(wall.centre, wall.radius, width)
