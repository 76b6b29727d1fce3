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

import numpy as np

from handsim.errors import InputError
from handsim.joints import FINGERS, Finger, Joint
from handsim.types import MEDIAN_HAND, Array, HandSize

HAND_LENGTH_RANGE = (0.12, 0.26)
"""Hand lengths that can be built [m]: from a child of four to six deviations above the mean man."""
HAND_BREADTH_RANGE = (0.05, 0.12)
"""Hand breadths that can be built [m]."""
DENSITY = 1100.0
"""Density of the ellipsoids [kg/m3]."""

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

CMC_OVERLAP = 0.4
"""The same for the thumb's metacarpal at the wrist, whose radius is that of the thenar muscles."""

# The thumb. [1] measured in the plane of the hand; the rest is this project's own, low confidence.
# Splay and pronation: of those with which the pad still meets every finger's pad, the ones with
# which 80 grasp postures of four people (West & Hogan, doi 10.5281/zenodo.14532969) cross the
# fingers least.
THUMB_DEPTH = 0.10
"""How far the thumb's CMC lies palmar to the others' plane, / HB: the trapezium's step."""
THUMB_SPLAY_DEG = 30.0
"""Angle of the flat thumb to the axis of its rotation [deg]."""
THUMB_PRONATION_DEG = 15.0
"""How far the pad of the flat thumb is turned from ulnar to palmar [deg]."""

# The palm's soft parts [3]: name, body, centre and semi-axes (x / HL, y / HB, z / HB), turn of the
# first semi-axis about z [deg].
SOFT_PARTS = (
    ("palm", "palm", (0.10, 0.0, -0.03), (0.13, 0.33, 0.17), 0.0),
    ("palm_centre", "palm", (0.26, 0.06, -0.035), (0.215, 0.26, 0.14), 0.0),
    ("index_pad", "palm", (0.375, 0.15, -0.045), (0.085, 0.28, 0.14), 4.0),
    ("web", "palm", (0.25, 0.25, -0.07), (0.15, 0.15, 0.10), 25.0),
    ("hypothenar", "palm_ulnar", (0.21, -0.29, -0.05), (0.18, 0.19, 0.165), -8.0),
    ("little_pad", "palm_ulnar", (0.33, -0.29, -0.045), (0.09, 0.22, 0.13), -6.0),
)


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
    """The right hand of a given size; that of a left one is its mirror image.

    Parameters
    ----------
    size
        Its side does not matter here.

    Raises
    ------
    InputError
        If length or breadth is outside `HAND_LENGTH_RANGE` or `HAND_BREADTH_RANGE`.
    """

    size: HandSize = MEDIAN_HAND

    def __post_init__(self) -> None:
        """Check that a hand of this size can be built."""
        for name, value, (low, high) in (
            ("hand length", self.size.length, HAND_LENGTH_RANGE),
            ("hand breadth", self.size.breadth, HAND_BREADTH_RANGE),
        ):
            if not low <= value <= high:  # also true of NaN
                raise InputError(
                    f"{name} {value:g} m is outside {low} to {high} m; give it in metres"
                )

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

    @property
    def arch_origin(self) -> Array:
        """Where the arch's axis leaves the carpus, in the hand frame, (3,) [m]."""
        return self._arch_end(CMC)

    def origin_of(self, body: str) -> Array:
        """Origin of ``palm`` or ``palm_ulnar`` in the hand frame, (3,) [m]."""
        return self.arch_origin if body == "palm_ulnar" else np.zeros(3)

    def ellipsoid(self, name: str) -> Ellipsoid:
        """Return an ellipsoid by its name."""
        return next(ellipsoid for ellipsoid in self.ellipsoids if ellipsoid.name == name)

    def mcp(self, finger: Finger) -> Array:
        """Metacarpophalangeal joint of a finger in the hand frame, (3,) [m]."""
        return self._point(*MCP[finger])

    def _arch_end(self, table: MappingProxyType[Finger, tuple[float, float]]) -> Array:
        middle, ring = np.array(table["middle"]), np.array(table["ring"])
        return self._point(*(middle + ring) / 2)

    def _point(self, x: float, y: float, z: float = 0.0) -> Array:
        return np.array([x * self.size.length, y * self.size.breadth, z * self.size.breadth])

    def _segments(self) -> list[Ellipsoid]:
        ellipsoids = []
        for finger in FINGERS:
            radii = RADII[finger][-3:]
            for k, (name, radius) in enumerate(zip(segment_names(finger), radii, strict=True)):
                across = radius * self.size.breadth
                start = -(CMC_OVERLAP if name == "thumb_metacarpal" else OVERLAP) * across
                length = LENGTHS[finger][k] * self.size.length
                end = length + (0.0 if k == 2 else OVERLAP * across)
                centre = np.array([(start + end) / 2, 0.0, 0.0])
                semi_axes = np.array([(end - start) / 2, across, across])
                ellipsoids.append(Ellipsoid(name, name, centre, semi_axes, np.eye(3)[0]))
        return ellipsoids

    def _metacarpals(self) -> list[Ellipsoid]:
        ellipsoids = []
        for finger in FINGERS[1:]:
            across = RADII[finger][0] * self.size.breadth
            cmc, mcp = self._point(*CMC[finger]), self.mcp(finger)
            length = float(np.linalg.norm(mcp - cmc))
            body = palm_body(finger)
            centre = (cmc + mcp) / 2 - self.origin_of(body)
            semi_axes = np.array([length / 2 + OVERLAP * across, across, across])
            direction = (mcp - cmc) / length
            ellipsoids.append(Ellipsoid(f"{finger}_metacarpal", body, centre, semi_axes, direction))
        return ellipsoids

    def _soft_parts(self) -> list[Ellipsoid]:
        ellipsoids = []
        for name, body, centre, size, turn_deg in SOFT_PARTS:
            angle = np.deg2rad(turn_deg)
            direction = np.array([np.cos(angle), np.sin(angle), 0.0])
            place = self._point(*centre) - self.origin_of(body)
            ellipsoids.append(Ellipsoid(name, body, place, self._point(*size), direction))
        return ellipsoids


def segment_names(finger: Finger) -> tuple[str, str, str]:
    """Return the names of a finger's three moving segments, proximal first."""
    parts = ("metacarpal", "proximal") if finger == "thumb" else ("proximal", "middle")
    return (f"{finger}_{parts[0]}", f"{finger}_{parts[1]}", f"{finger}_distal")


def palm_body(finger: Finger) -> str:
    """Return the part of the palm that carries a finger: the arch moves ring and little."""
    return "palm_ulnar" if finger in ("ring", "little") else "palm"


def first_segment(joint: Joint) -> int:
    """Return which of its finger's three segments, 0 to 2, a joint moves first."""
    place = joint.name.rsplit("_", 1)[1]
    order = ("", "mcp", "ip") if joint.finger == "thumb" else ("mcp", "pip", "dip")
    return order.index(place) if place in order else 0


def thumb_axes() -> Array:
    """Return the thumb metacarpal's axes in the hand frame, flat right hand, (3, 3).

    x points along the metacarpal, `THUMB_SPLAY_DEG` radial of the hand's x, about which the thumb
    rotates; -z is where the pad faces: from ulnar turned `THUMB_PRONATION_DEG` to palmar.
    """
    splay, pronation = np.deg2rad([THUMB_SPLAY_DEG, THUMB_PRONATION_DEG])
    x = np.array([np.cos(splay), np.sin(splay), 0.0])
    ulnar = np.array([np.sin(splay), -np.cos(splay), 0.0])
    pad = np.cos(pronation) * ulnar - np.sin(pronation) * np.array([0.0, 0.0, 1.0])
    return np.column_stack([x, np.cross(-pad, x), -pad])
