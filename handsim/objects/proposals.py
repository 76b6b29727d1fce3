"""Where an object that nobody has grasped before can be taken between thumb and fingers.

Grasps of several families (`proposal_families`) are thinned to those that differ, judged by force
closure under uncertainty (`closure`), and ranked. A short list of grasps that differ is what is
worth trying in physics.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from handsim.errors import InputError
from handsim.objects.closure import disturbances, firmness
from handsim.objects.convex_solid import ConvexSolid
from handsim.objects.grasp import Grasp
from handsim.objects.mirror import mirrored, mirrored_grasp
from handsim.objects.mjcf import centre_of_mass
from handsim.objects.object import GraspObject
from handsim.objects.proposal_families import (
    REACH,
    THIN,
    WIDTH_RANGE,
    Opposed,
    grasps_of,
    opposed_surfaces,
)
from handsim.types import Array, Side

__all__ = ["MOST_TRIED", "REACH", "WIDTH_RANGE", "Proposal", "propose_grasps", "short_list"]

MOST_TRIED = 20
"""Proposals of a short list."""
PER_FAMILY = 10
"""Grasps of each family that are judged by force closure."""
PER_PLACE = 4
"""Grasps that differ in nothing but the side they come from."""

WIDE = 0.06
"""Width from which a grasp costs more the wider it is [m]."""
CELL = 0.012
"""Side of the cells in which grasps count as being at one place [m]."""

_Family = tuple[str, int, bool]


@dataclass(frozen=True)
class Proposal:
    """A grasp and what speaks for it.

    Attributes
    ----------
    grasp
        In the object frame, for the hand that was asked for.
    facing_deg
        Angle between opposition and surface normals, the larger of two [deg].
    lever
        Distance of the centre of mass from the grasp point, across the approach [m].
    firm
        Share of samples of pose, friction and mass in which it holds (`handsim.objects.closure`).
    """

    grasp: Grasp
    facing_deg: float
    lever: float
    firm: float = 0.0

    @property
    def cost(self) -> float:
        """Least for what holds most often; then for facing surfaces, short levers, ease of span."""
        width = self.grasp.width
        strain = max(0.0, width - WIDE) / 0.03 + max(0.0, THIN - width) / 0.03
        return 8.0 * (1.0 - self.firm) + self.facing_deg / 15.0 + self.lever / 0.02 + strain

    @property
    def family(self) -> _Family:
        """Kind, number of fingers, and whether it is a pinch."""
        return self.grasp.kind, len(self.grasp.fingers), self.grasp.width < THIN


def propose_grasps(grasp_object: GraspObject, side: Side = "right") -> tuple[Proposal, ...]:
    """Return grasps between opposed surfaces, the most promising first.

    Parameters
    ----------
    grasp_object
    side
        Of the hand. A left hand's grasps are those of a right hand on the mirror image of the
        object, shown by the mirror.

    Raises
    ------
    InputError
        If the object offers none.
    """
    if side == "left":
        of_image = propose_grasps(mirrored(grasp_object))
        return tuple(replace(each, grasp=mirrored_grasp(each.grasp)) for each in of_image)
    solid, centre = ConvexSolid.of(grasp_object), centre_of_mass(grasp_object)
    pairs = _thinned(opposed_surfaces(solid, centre), centre)
    lever = np.linalg.norm(pairs.point - centre, axis=1)
    found = _first_of_each(grasps_of(solid, pairs))
    if not found:
        raise InputError(
            f"object '{grasp_object.name}' has no two opposed surfaces up to"
            f" {1000 * WIDTH_RANGE[1]:g} mm apart that fingers get to; set it down another way"
            " (--up) or scale it"
        )
    firm = firmness(solid, [grasp for grasp, _ in found], centre, grasp_object.mass, disturbances())
    facing = np.rad2deg(pairs.facing)
    proposals = [
        Proposal(grasp, float(facing[i]), float(lever[i]), float(share))
        for (grasp, i), share in zip(found, firm, strict=True)
    ]
    return tuple(sorted(proposals, key=lambda proposal: proposal.cost))


def short_list(proposals: Sequence[Proposal], n: int = MOST_TRIED) -> tuple[Proposal, ...]:
    """Return up to ``n`` proposals that differ, the best of every family among them.

    Each further one of a family or a place counts less.
    """
    best_of: dict[_Family, Proposal] = {}
    for each in proposals:
        best_of.setdefault(each.family, each)
    chosen = list(best_of.values())[:n]
    left = [each for each in proposals if each not in chosen]
    families: Counter[_Family] = Counter(each.family for each in chosen)
    places: Counter[tuple[int, ...]] = Counter(_place(each.grasp) for each in chosen)
    while left and len(chosen) < n:
        best = min(
            left,
            key=lambda each: (
                each.cost + 0.6 * families[each.family] + 0.8 * places[_place(each.grasp)]
            ),
        )
        left.remove(best)
        chosen.append(best)
        families[best.family] += 1
        places[_place(best.grasp)] += 1
    return tuple(chosen)


def _place(grasp: Grasp) -> tuple[int, ...]:
    """Return the place in cells of 15 mm, whatever the side that is come from."""
    return tuple(round(value / 0.015) for value in (*grasp.point, grasp.width))


def _thinned(pairs: Opposed, centre: Array) -> Opposed:
    """Return pairs of surfaces by facing and lever, the best first, and of each place few.

    What differs only in the side that the hand comes from, as all around a bottle, is one place.
    """
    off = pairs.point - centre
    worth = np.rad2deg(pairs.facing) / 15 + np.linalg.norm(off, axis=1) / 0.02
    aside = np.abs((off * np.cross([0.0, 0.0, 1.0], pairs.axis)).sum(axis=1))
    along = (off * pairs.axis).sum(axis=1)
    cells = np.column_stack([aside, along, off[:, 2], 2 * pairs.width]) / CELL
    places: Counter[tuple[int, ...]] = Counter()
    kept: list[int] = []
    for i in np.argsort(worth, kind="stable").tolist():
        place = tuple(np.round(cells[i]).astype(int).tolist())
        places[place] += 1
        if places[place] <= PER_PLACE:
            kept.append(i)
    return pairs.where(np.array(kept, dtype=np.int64))


def _first_of_each(found: list[tuple[Grasp, int]]) -> list[tuple[Grasp, int]]:
    """Return the first grasps of each family."""
    families: Counter[_Family] = Counter()
    kept: list[tuple[Grasp, int]] = []
    for grasp, i in sorted(found, key=lambda each: each[1]):
        family = (grasp.kind, len(grasp.fingers), grasp.width < THIN)
        families[family] += 1
        if families[family] <= PER_FAMILY:
            kept.append((grasp, i))
    return kept
