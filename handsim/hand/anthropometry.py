"""From hand length and breadth to segments, joint centres, ellipsoids and masses.

Frame (hand frame): origin at the wrist centre of the flat right hand, +x distal, +y to the
thumb's side, +z dorsal, so that the palm faces -z. A left hand is the mirror image y -> -y.

Sources, and how sure they are
------------------------------
[1] Buchholz, Armstrong & Goldstein (1992), Ergonomics 35(3):261-273: segment lengths and joint
    positions as fractions of hand length HL and hand breadth HB. High confidence.
[2] Breadths of segments from the measurements behind a published OpenRAVE hand model. Medium
    confidence. They are taken as *semi*-axes: only so do they agree with [3], where a man's index
    finger is 21 mm broad at the PIP joint (0.115 HB = 10.2 mm is its half), and only so does the
    hand weigh what [5] found (read as full breadths, the segments of the table weigh 60 g).
[3] Pheasant & Haslegrave (2006), Bodyspace, 3rd ed., table of hand dimensions: for men HB 87,
    thickness at the metacarpals 33, index breadth 21 (PIP) and 18 (DIP), thumb 23 mm. The soft
    parts of the palm are sized by it; their shapes are this project's own. Low confidence.
[4] ANSUR II (2012), US Army: distribution of HL and HB. High confidence.
[5] de Leva (1996), J. Biomech. 29(9):1223-1230: a man's hand is 0.61 % of his mass, a woman's
    0.56 %. Density 1100 kg/m3 over the ellipsoids.
"""

from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Literal

import numpy as np

from handsim.errors import InputError, UnknownNameError
from handsim.joints import FINGERS, Array, Finger

HAND_LENGTH_RANGE = (0.12, 0.26)
"""Hand lengths that can be built [m]: from a child of four to beyond the longest on record."""
HAND_BREADTH_RANGE = (0.05, 0.12)
"""Hand breadths that can be built [m]."""
DENSITY = 1100.0
"""Density of the ellipsoids [kg/m3]."""

Sex = Literal["woman", "man"]


@dataclass(frozen=True)
class Population:
    """Joint normal distribution of hand length and breadth of one sex [m], ANSUR II."""

    hand_length: tuple[float, float]
    """Mean and standard deviation."""
    hand_breadth: tuple[float, float]
    """Mean and standard deviation."""
    correlation: float


POPULATIONS: MappingProxyType[Sex, Population] = MappingProxyType(
    {
        "woman": Population((0.1811, 0.0101), (0.0782, 0.0038), 0.57),
        "man": Population((0.1933, 0.0099), (0.0883, 0.0044), 0.58),
    }
)

PRESETS: MappingProxyType[str, tuple[float, float]] = MappingProxyType(
    {
        "woman-5": (0.165, 0.072),
        "woman-50": (0.1811, 0.0782),
        "woman-95": (0.199, 0.085),
        "man-5": (0.177, 0.081),
        "man-50": (0.1933, 0.0883),
        "man-95": (0.210, 0.096),
    }
)
"""Hand length and breadth [m] at the 5th, 50th and 95th percentile of each, ANSUR II.

Both at the same percentile: fewer than 5 % of people are as small, or as large, in both.
"""

HAND_LENGTH, HAND_BREADTH = PRESETS["man-50"]

# Segment lengths / HL [1]: proximal, middle, distal; the thumb: metacarpal, proximal, distal.
LENGTHS: MappingProxyType[Finger, tuple[float, float, float]] = MappingProxyType(
    {
        "thumb": (0.251, 0.196, 0.158),
        "index": (0.245, 0.143, 0.097),
        "middle": (0.266, 0.170, 0.108),
        "ring": (0.244, 0.165, 0.107),
        "little": (0.204, 0.117, 0.093),
    }
)

# Carpometacarpal and metacarpophalangeal joint centres of the fingers: x / HL, y / HB [1].
CMC: MappingProxyType[Finger, tuple[float, float]] = MappingProxyType(
    {
        "thumb": (0.073, 0.196),
        "index": (0.073, 0.126),
        "middle": (0.073, 0.0),
        "ring": (0.073, -0.129),
        "little": (0.073, -0.223),
    }
)
MCP: MappingProxyType[Finger, tuple[float, float]] = MappingProxyType(
    {
        "index": (0.447, 0.251),
        "middle": (0.446, 0.0),
        "ring": (0.409, -0.206),
        "little": (0.368, -0.402),
    }
)

# Semi-axes across the segment / HB [2]: metacarpal, proximal, middle, distal.
RADII: MappingProxyType[Finger, tuple[float, ...]] = MappingProxyType(
    {
        "thumb": (0.219, 0.115, 0.106),
        "index": (0.137, 0.115, 0.099, 0.088),
        "middle": (0.130, 0.108, 0.098, 0.090),
        "ring": (0.122, 0.102, 0.091, 0.084),
        "little": (0.110, 0.092, 0.082, 0.075),
    }
)

OVERLAP = 0.85
"""How far an ellipsoid reaches beyond its joints, as a fraction of its radius.

Ellipsoids that end at the joints would touch in a point and leave necks that no finger has.
The distal one ends at the fingertip itself, so that reach is exact.
"""

# The thumb. [1] measured in the plane of the hand; what leaves the plane is this project's own,
# chosen so that the flat thumb lies beside the palm and its pad meets every finger's pad.
THUMB_DEPTH = 0.10
"""How far the thumb's CMC lies palmar to the others' plane, / HB: the trapezium's step."""
THUMB_SPLAY_DEG = 30.0
"""Angle of the flat thumb to the axis of its rotation [deg]."""
THUMB_PHASE_DEG = 10.0
"""How far the flat thumb is turned palmar about the axis of its rotation [deg]."""
THUMB_PRONATION_DEG = 25.0
"""How far the pad of the flat thumb is turned from ulnar to palmar [deg]."""


@dataclass(frozen=True)
class Link:
    """A moving body of the right hand in its zero posture.

    Attributes
    ----------
    name, parent
        Names of the body and of the one that carries it.
    origin
        Joint centre in the parent's frame, (3,) [m].
    axes
        Columns are the body's x (along the segment), y (flexion turns about it) and z (dorsal)
        in the parent's frame, (3, 3).
    length
        To the next joint or the fingertip, along x [m]; 0 for the palm's two bodies.
    """

    name: str
    parent: str
    origin: Array
    axes: Array
    length: float = 0.0


@dataclass(frozen=True)
class Ellipsoid:
    """One ellipsoid of the right hand, in the frame of its body.

    Attributes
    ----------
    name, body
        Name without ``_geom``, and the body that carries it.
    centre
        (3,) [m].
    semi_axes
        Along ``direction`` and two across, the last nearest the body's z, (3,) [m].
    direction
        Unit vector of the first semi-axis, (3,), in the x-y plane of the body.
    """

    name: str
    body: str
    centre: Array
    semi_axes: Array
    direction: Array

    @property
    def volume(self) -> float:
        """Volume [m3]."""
        return float(4 / 3 * np.pi * np.prod(self.semi_axes))

    @property
    def mass(self) -> float:
        """Mass at `DENSITY` [kg]."""
        return DENSITY * self.volume

    @property
    def inertia(self) -> Array:
        """Principal moments of inertia about the centre, (3,) [kg m2]."""
        a, b, c = self.semi_axes**2
        return self.mass / 5 * np.array([b + c, a + c, a + b])


@dataclass(frozen=True)
class HandGeometry:
    """A right hand of a given size; `hand_geometry` makes and validates it."""

    hand_length: float
    hand_breadth: float

    @cached_property
    def links(self) -> tuple[Link, ...]:
        """Bodies from the palm outwards, parents first."""
        links = [
            Link("palm", "forearm", np.zeros(3), np.eye(3)),
            Link("palm_ulnar", "palm", self._arch_origin, np.eye(3)),
        ]
        for finger in FINGERS:
            names = segment_names(finger)
            parent = "palm_ulnar" if finger in ("ring", "little") else "palm"
            origin = self.thumb_cmc if finger == "thumb" else self.mcp(finger)
            if parent == "palm_ulnar":
                origin = origin - self._arch_origin
            axes = thumb_axes() if finger == "thumb" else np.eye(3)
            for name, fraction in zip(names, LENGTHS[finger], strict=True):
                length = fraction * self.hand_length
                links.append(Link(name, parent, origin, axes, length))
                parent, origin, axes = name, np.array([length, 0.0, 0.0]), np.eye(3)
        return tuple(links)

    @cached_property
    def ellipsoids(self) -> tuple[Ellipsoid, ...]:
        """Ellipsoids of all bodies: segments, metacarpals and the palm's soft parts."""
        return (*self._segments(), *self._metacarpals(), *self._soft_parts())

    @property
    def thumb_cmc(self) -> Array:
        """Carpometacarpal joint of the thumb in the hand frame, (3,) [m]."""
        x, y = CMC["thumb"]
        return self._point(x, y, -THUMB_DEPTH)

    @property
    def mass(self) -> float:
        """Mass of the hand without the forearm [kg]."""
        return sum(ellipsoid.mass for ellipsoid in self.ellipsoids)

    @property
    def arch_axis(self) -> Array:
        """Unit vector of the palm arch's axis in the hand frame, (3,).

        It runs between the middle and ring metacarpals, so that turning about it lifts the ring
        and little metacarpal heads to the palm and turns their fingers to the thumb.
        """
        along = self._arch_end(MCP) - self._arch_end(CMC)
        return along / np.linalg.norm(along)

    def link(self, name: str) -> Link:
        """Return a body by its name."""
        return next(link for link in self.links if link.name == name)

    def ellipsoid(self, name: str) -> Ellipsoid:
        """Return an ellipsoid by its name."""
        return next(ellipsoid for ellipsoid in self.ellipsoids if ellipsoid.name == name)

    def mcp(self, finger: Finger) -> Array:
        """Metacarpophalangeal joint of a finger in the hand frame, (3,) [m]."""
        return self._point(*MCP[finger])

    @property
    def _arch_origin(self) -> Array:
        return self._arch_end(CMC)

    def _arch_end(self, table: MappingProxyType[Finger, tuple[float, float]]) -> Array:
        middle, ring = np.array(table["middle"]), np.array(table["ring"])
        return self._point(*(middle + ring) / 2)

    def _point(self, x: float, y: float, z: float = 0.0) -> Array:
        return np.array([x * self.hand_length, y * self.hand_breadth, z * self.hand_breadth])

    def _segments(self) -> list[Ellipsoid]:
        ellipsoids = []
        for finger in FINGERS:
            radii = RADII[finger][-3:]
            for k, (name, radius) in enumerate(zip(segment_names(finger), radii, strict=True)):
                across = radius * self.hand_breadth
                start = -OVERLAP * across
                length = LENGTHS[finger][k] * self.hand_length
                end = length + (0.0 if k == 2 else OVERLAP * across)
                centre = np.array([(start + end) / 2, 0.0, 0.0])
                semi_axes = np.array([(end - start) / 2, across, across])
                ellipsoids.append(Ellipsoid(name, name, centre, semi_axes, np.eye(3)[0]))
        return ellipsoids

    def _metacarpals(self) -> list[Ellipsoid]:
        ellipsoids = []
        for finger in FINGERS[1:]:
            across = RADII[finger][0] * self.hand_breadth
            cmc, mcp = self._point(*CMC[finger]), self.mcp(finger)
            length = float(np.linalg.norm(mcp - cmc))
            body = "palm_ulnar" if finger in ("ring", "little") else "palm"
            centre = (cmc + mcp) / 2 - (self._arch_origin if body == "palm_ulnar" else 0.0)
            semi_axes = np.array([length / 2 + OVERLAP * across, across, across])
            direction = (mcp - cmc) / length
            ellipsoids.append(Ellipsoid(f"{finger}_metacarpal", body, centre, semi_axes, direction))
        return ellipsoids

    def _soft_parts(self) -> list[Ellipsoid]:
        ellipsoids = []
        for name, body, centre, size, turn_deg in SOFT_PARTS:
            offset = self._arch_origin if body == "palm_ulnar" else 0.0
            angle = np.deg2rad(turn_deg)
            direction = np.array([np.cos(angle), np.sin(angle), 0.0])
            ellipsoids.append(
                Ellipsoid(name, body, self._point(*centre) - offset, self._point(*size), direction)
            )
        return ellipsoids


# The palm's soft parts [3]: name, body, centre and semi-axes (x / HL, y / HB, z / HB), turn of the
# first semi-axis about z [deg].
SOFT_PARTS = (
    ("palm", "palm", (0.10, 0.0, -0.03), (0.13, 0.33, 0.17), 0.0),
    ("palm_centre", "palm", (0.25, 0.06, -0.05), (0.21, 0.24, 0.14), 0.0),
    ("index_pad", "palm", (0.40, 0.12, -0.05), (0.08, 0.26, 0.13), 0.0),
    ("web", "palm", (0.24, 0.24, -0.07), (0.16, 0.16, 0.11), 25.0),
    ("hypothenar", "palm_ulnar", (0.21, -0.30, -0.06), (0.17, 0.18, 0.17), -8.0),
    ("little_pad", "palm_ulnar", (0.35, -0.29, -0.05), (0.08, 0.22, 0.12), 0.0),
)


def hand_geometry(
    hand_length: float = HAND_LENGTH, hand_breadth: float = HAND_BREADTH
) -> HandGeometry:
    """Return the geometry of a right hand.

    Parameters
    ----------
    hand_length
        Wrist crease to the tip of the middle finger [m].
    hand_breadth
        Across the metacarpal heads of the four fingers [m]. Defaults: a man of median size.

    Raises
    ------
    InputError
        If either is outside `HAND_LENGTH_RANGE` or `HAND_BREADTH_RANGE`.
    """
    for name, value, (low, high) in (
        ("hand length", hand_length, HAND_LENGTH_RANGE),
        ("hand breadth", hand_breadth, HAND_BREADTH_RANGE),
    ):
        if not low <= value <= high:  # also true of NaN
            raise InputError(f"{name} {value:g} m is outside {low} to {high} m; give it in metres")
    return HandGeometry(float(hand_length), float(hand_breadth))


def preset(name: str) -> tuple[float, float]:
    """Return hand length and breadth [m] of a preset, ``woman-5`` to ``man-95``.

    Raises
    ------
    UnknownNameError
        If there is no such preset.
    """
    if name not in PRESETS:
        raise UnknownNameError("hand size", name, tuple(PRESETS))
    return PRESETS[name]


def sample_sizes(n: int, sex: Sex, seed: int) -> Array:
    """Draw hand lengths and breadths of a population jointly.

    Returns
    -------
    (n, 2) [m]
        Hand length and breadth, clipped to the ranges that can be built (beyond 6 sigma).

    Raises
    ------
    UnknownNameError
        If ``sex`` is neither ``woman`` nor ``man``.
    """
    if sex not in POPULATIONS:
        raise UnknownNameError("population", sex, tuple(POPULATIONS))
    people = POPULATIONS[sex]
    means, deviations = np.array([people.hand_length, people.hand_breadth]).T
    correlation = np.array([[1.0, people.correlation], [people.correlation, 1.0]])
    covariance = correlation * np.outer(deviations, deviations)
    sizes = np.random.default_rng(seed).multivariate_normal(means, covariance, size=n)
    limits = np.array([HAND_LENGTH_RANGE, HAND_BREADTH_RANGE])
    return np.clip(sizes, *limits.T)


def segment_names(finger: Finger) -> tuple[str, str, str]:
    """Return the names of a finger's three moving segments, proximal first."""
    parts = ("metacarpal", "proximal") if finger == "thumb" else ("proximal", "middle")
    return (f"{finger}_{parts[0]}", f"{finger}_{parts[1]}", f"{finger}_distal")


def thumb_axes() -> Array:
    """Return the thumb metacarpal's axes in the hand frame, flat right hand, (3, 3).

    x points along the metacarpal, on a cone of `THUMB_SPLAY_DEG` about the axis of the thumb's
    rotation (the hand's x), `THUMB_PHASE_DEG` palmar of the hand's plane; -z is where the pad
    faces: from ulnar turned `THUMB_PRONATION_DEG` to palmar.
    """
    splay, phase, pronation = np.deg2rad([THUMB_SPLAY_DEG, THUMB_PHASE_DEG, THUMB_PRONATION_DEG])
    radial = np.array([0.0, np.cos(phase), -np.sin(phase)])
    palmar = np.array([0.0, -np.sin(phase), -np.cos(phase)])
    x = np.array([np.cos(splay), 0.0, 0.0]) + np.sin(splay) * radial
    ulnar = np.array([np.sin(splay), 0.0, 0.0]) - np.cos(splay) * radial
    pad = np.cos(pronation) * ulnar + np.sin(pronation) * palmar
    return np.column_stack([x, np.cross(-pad, x), -pad])
