"""Force closure of a proposed grasp under uncertainty: how often it holds the object's weight.

In each sample the hand comes to rest a little off, skin is more or less slippery, and the object is
heavier or lighter. The thumb and each finger touch what they then meet. A sample holds where their
forces, within the friction of soft fingertips, balance the weight and a push from any side with no
more than the strength of a relaxed grip.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from handsim.objects.convex_solid import ConvexSolid
from handsim.objects.grasp import Grasp
from handsim.types import Array, Index

GRAVITY = 9.81
"""[m/s^2]"""
SPACING = 0.020
"""Between neighbouring fingers [m]: 0.23 of a hand breadth of 88 mm."""
SHIFT, TURN = 0.004, np.deg2rad(5.0)
"""Standard deviations of where a hand comes to rest along each axis [m], and of its turn [rad]."""
FRICTION = (0.3, 0.8)
"""Of skin on things: from wet or greasy to dry."""
TORSION = 0.006
"""Torsional friction of a soft fingertip [m] for each unit of sliding friction."""
MASS = (0.8, 1.3)
"""Factors on the mass."""
PUSH = 0.4
"""Push from any side, as a share of the weight."""
GRIP = 15.0
"""Greatest force of the thumb [N], and so of all fingers together, for two fingers; each further
one adds `GRIP_PER_FINGER`. People's grip of a filled glass is 3 to 10 N."""
GRIP_PER_FINGER = 8.0
GIVES_WAY = 0.012
"""How far from where it is expected a finger still finds the surface [m]."""
LEVER = 0.05
"""Length by which torques are divided [m]."""
EDGES = 6
"""Edges of the pyramid that stands for a friction cone."""
SAMPLES = 10

_TINY = 1e-3
"""Share of a wrench that may be left unbalanced."""


@dataclass(frozen=True, eq=False)
class Disturbances:
    """Samples of what is uncertain, (n,) or (n, 3) each.

    Attributes
    ----------
    shift
        Of the hand along opposition, approach and across both [m].
    turn
        About the approach [rad].
    friction, mass
        Coefficient, and factor on the mass.
    """

    shift: Array
    turn: Array
    friction: Array
    mass: Array


def disturbances(n: int = SAMPLES, seed: int = 0) -> Disturbances:
    """Draw samples; the first is undisturbed but for mid friction."""
    generator = np.random.default_rng([seed, 1988])
    shift, turn = generator.normal(0, SHIFT, (n, 3)), generator.normal(0, TURN, n)
    spread = FRICTION[0] + (np.arange(n) + 0.5) / n * (FRICTION[1] - FRICTION[0])
    friction: Array = generator.permutation(spread)
    mass = generator.uniform(*MASS, n)
    shift[0], turn[0], friction[0], mass[0] = 0.0, 0.0, np.mean(FRICTION), 1.0
    return Disturbances(shift, turn, friction, mass)


def firmness(
    solid: ConvexSolid, grasps: list[Grasp], centre: Array, mass: float, drawn: Disturbances
) -> Array:
    """Return the share of samples in which each grasp holds, (n_grasps,), 0 to 1.

    Where two hold alike, that which needs less force gets up to 0.1 more.

    Parameters
    ----------
    solid
        The object.
    grasps
    centre : (3,) [m]
        Its centre of mass.
    mass
        [kg].
    drawn
        What is uncertain.
    """
    touched = _contacts(solid, grasps, drawn)
    shares = np.empty(len(grasps))
    for i, grasp in enumerate(grasps):
        strength = GRIP + GRIP_PER_FINGER * (len(grasp.fingers) - 2)
        spare = [
            _spare(touched[i][k], centre, GRAVITY * mass * m, mu, strength)
            for k, (m, mu) in enumerate(zip(drawn.mass, drawn.friction, strict=True))
        ]
        held = np.array([each >= 0 for each in spare])
        shares[i] = held.mean() - 0.1 * (1 - np.maximum(spare, 0.0).mean())
    return np.maximum(shares, 0.0)


def _contacts(
    solid: ConvexSolid, grasps: list[Grasp], drawn: Disturbances
) -> list[list[list[tuple[Array, Array]]]]:
    """Return points [m] and inward normals touched, by grasp and sample."""
    starts: list[Array] = []
    axes: list[Array] = []
    owner: list[tuple[int, int, bool]] = []
    for i, grasp in enumerate(grasps):
        axis, approach = np.array(grasp.opposition), np.array(grasp.approach)
        across = np.cross(axis, approach)
        n = len(grasp.fingers)
        places = SPACING * (np.arange(n) - (n - 1) / 2)
        for k, (shift, turn) in enumerate(zip(drawn.shift, drawn.turn, strict=True)):
            turned = np.cos(turn) * axis + np.sin(turn) * across
            aside = np.cross(turned, approach)
            middle = grasp.point + shift[1] * approach + shift[2] * across
            for place, thumb in [(0.0, True), *((each, False) for each in places)]:
                starts.append(middle + place * aside)
                axes.append(turned)
                owner.append((i, k, thumb))
    lines, directions = np.array(starts), np.array(axes)
    spans = solid.spans(lines, directions)
    touched: list[list[list[tuple[Array, Array]]]] = [[[] for _ in drawn.turn] for _ in grasps]
    for line, rows in _by_line(spans.line, len(lines)):
        i, k, thumb = owner[line]
        half = grasps[i].width / 2
        ends = spans.enter[rows] if thumb else spans.leave[rows]
        near = np.abs(ends - (-half if thumb else half))
        row = rows[int(near.argmin())]
        if near.min() > GIVES_WAY:
            continue
        end = spans.enter[row] if thumb else spans.leave[row]
        normal = -(spans.normal_in if thumb else spans.normal_out)[row]
        touched[i][k].append((lines[line] + end * directions[line], normal))
    return touched


def _by_line(line: Index, n: int) -> list[tuple[int, Index]]:
    """Return the rows of each line that has any."""
    bounds = np.searchsorted(line, np.arange(n + 1))
    return [(i, np.arange(bounds[i], bounds[i + 1])) for i in range(n) if bounds[i] < bounds[i + 1]]


def _spare(
    touched: list[tuple[Array, Array]], centre: Array, weight: float, mu: float, strength: float
) -> float:
    """Return the share of the strength that is left in the worst case, below 0 if it fails."""
    if len(touched) < 2:
        return -1.0
    generators, pushes = _wrenches(touched, centre, mu)
    worst = 0.0
    for push in (*np.eye(3), *-np.eye(3)):
        load = np.concatenate([weight * (np.array([0.0, 0.0, -1.0]) + PUSH * push), np.zeros(3)])
        forces, left = nnls(generators, -load / weight, maxiter=400)
        if left > _TINY:
            return -1.0
        worst = max(worst, float(pushes @ forces) * weight)
    return 1.0 - worst / (2 * strength)


def _wrenches(touched: list[tuple[Array, Array]], centre: Array, mu: float) -> tuple[Array, Array]:
    """Return wrenches about the centre, (6, n) arms in units of `LEVER`, and pushes (n,).

    The push is the normal force of each.
    """
    points, normals = (np.array(each) for each in zip(*touched, strict=True))
    helper = np.eye(3)[np.abs(normals).argmin(axis=1)]
    first = _cross(normals, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = _cross(normals, first)
    angles = 2 * np.pi * np.arange(EDGES) / EDGES
    sliding = np.cos(angles)[:, None, None] * first + np.sin(angles)[:, None, None] * second
    forces: Array = (normals + mu * sliding).reshape(-1, 3)
    arms: Array = (points - centre) / LEVER
    columns = [np.hstack([forces, _cross(np.tile(arms, (EDGES, 1)), forces)])]
    for twist in (-mu * TORSION / LEVER, mu * TORSION / LEVER):
        columns.append(np.hstack([normals, _cross(arms, normals) + twist * normals]))
    generators: Array = np.vstack(columns).T
    return generators, np.ones(generators.shape[1])


def _cross(a: Array, b: Array) -> Array:
    """Return the vector products of rows (n, 3), in a tenth of the time of NumPy's function."""
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]
