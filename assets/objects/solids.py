"""Shapes of the 13 objects as closed solids, for ``make.py`` beside it.

Each maker returns the solids of one object by mesh name, in the object frame [m]. Solids are
built with manifold3d, whose results are closed by construction.
"""

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from manifold3d import CrossSection, Manifold, OpType
from scipy.interpolate import make_interp_spline

from handsim.objects.object import TriangleMesh

Solids = dict[str, Manifold]
Point2 = tuple[float, float]
Point3 = tuple[float, float, float]

SEGMENTS = 64
"""Facets of a large round surface: 0.04 mm off a circle of 32 mm radius."""


def lathe(profile: Sequence[Point2], segments: int = SEGMENTS) -> Manifold:
    """Revolve a closed outline of (radius, height) [m] about the z axis."""
    return _outline(profile).revolve(segments)


def along_x(profile: Sequence[Point2], height: float, segments: int = 32) -> Manifold:
    """Revolve an outline of (radius, position) about the x axis, lifted by ``height`` [m]."""
    return lathe(profile, segments).rotate((0, 90, 0)).translate((0, 0, height))


def rounded_box(sides: Point3, centre: Point3, radius: float, segments: int = 16) -> Manifold:
    """Return a box of full ``sides`` [m] with all edges rounded by ``radius``."""
    ball = Manifold.sphere(radius, segments)
    half = np.array(sides) / 2 - radius
    corners = [ball.translate(half * (x, y, z)) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    return Manifold.batch_hull(corners).translate(centre)


def plate(outline: Sequence[Point2], bottom: float, top: float, rounding: float = 0.0) -> Manifold:
    """Extrude an outline in x and y between two heights, its corners rounded [m]."""
    shape = _outline(outline)
    if rounding:
        shape = shape.offset(-rounding).offset(rounding, circular_segments=24)
    return shape.extrude(top - bottom).translate((0, 0, bottom))


def block(low: Point3, high: Point3) -> Manifold:
    """Return the box between two opposite corners [m]."""
    return Manifold.cube(tuple(np.subtract(high, low))).translate(low)


def swept(path: Iterable[Point3], stamp: Manifold) -> Manifold:
    """Return a bead: the hulls of a convex stamp at successive points of a path."""
    places = [stamp.translate(point) for point in path]
    return _union(Manifold.batch_hull([a, b]) for a, b in pairwise(places))


def _outline(points: Sequence[Point2]) -> CrossSection:
    """Return the area within a closed outline, whichever way round it is given."""
    corners = np.array(points, dtype=float)
    x, y = corners.T
    area = x @ np.roll(y, -1) - y @ np.roll(x, -1)
    return CrossSection([corners if area > 0 else corners[::-1]])


def _hull(points: npt.ArrayLike) -> Manifold:
    return Manifold.hull_points(np.asarray(points, dtype=float))


def _union(solids: Iterable[Manifold]) -> Manifold:
    return Manifold.batch_boolean(list(solids), OpType.Add)


def _arc(centre: Point2, radii: Point2, start: float, stop: float, n: int) -> list[Point2]:
    """Return ``n`` points of an ellipse between two angles [deg]."""
    angles = np.deg2rad(np.linspace(start, stop, n))
    return [
        (centre[0] + radii[0] * np.cos(angle), centre[1] + radii[1] * np.sin(angle))
        for angle in angles
    ]


def tall_glass() -> Solids:
    """Straight glass with a thick base and a rounded rim."""
    rim = _arc((0.0309, 0.1439), (0.0011, 0.0011), 0, 180, 9)
    outside = [(0, 0), (0.030, 0), (0.0315, 0.001), (0.032, 0.003)]
    return {"tall_glass": lathe([*outside, *rim, (0.0298, 0.013), (0.027, 0.010), (0, 0.010)])}


def cup() -> Solids:
    """Coffee cup with a rounded foot and a handle."""
    foot = _arc((0.032, 0.008), (0.008, 0.008), -90, 0, 7)
    rim = _arc((0.03825, 0.08025), (0.00175, 0.00175), 0, 180, 9)
    floor = _arc((0.0305, 0.011), (0.006, 0.006), 0, -90, 7)
    vessel = [(0, 0), *foot, *rim, *floor, (0, 0.005)]
    cavity = [(0, 0.005), *reversed(floor), (0.0365, 0.083), (0, 0.083)]
    knots = [(0.036, 0.066), (0.050, 0.0668), (0.060, 0.0625), (0.0655, 0.053), (0.0663, 0.044),
             (0.0645, 0.034), (0.0585, 0.0255), (0.049, 0.0195), (0.037, 0.0165)]  # fmt: skip
    curve = make_interp_spline(np.arange(len(knots)), knots)(np.linspace(0, len(knots) - 1, 25))
    # Pieces of the bead meet in flat polygons, which the last bit cuts one way or the other; that
    # bit hangs on the processor's linear algebra.
    curve = np.round(curve, 8)
    stamp = Manifold.sphere(0.0045, 16).scale((1.0, 1.25, 1.0))
    handle = swept([(x, 0.0, z) for x, z in curve], stamp) - lathe(cavity)
    return {"cup": lathe(vessel) + handle}


def ashtray() -> Solids:
    """Round glass ashtray with four rests in its rim."""
    rim = _arc((0.0455, 0.0285), (0.0045, 0.0035), 0, 180, 11)
    outside = [(0, 0), (0.048, 0), (0.050, 0.002)]
    bowl = lathe([*outside, *rim, (0.037, 0.0095), (0.035, 0.008), (0, 0.008)])
    rest = Manifold.cylinder(0.12, 0.0045, 0.0045, 20, True).rotate((90, 0, 0))
    rests = _union(rest.translate((0, 0, 0.0325)).rotate((0, 0, angle)) for angle in (45.0, 135.0))
    return {"ashtray": bowl - rests}


def cube() -> Solids:
    """Wooden cube with 2 mm edges."""
    return {"cube": rounded_box((0.055, 0.055, 0.055), (0, 0, 0.0275), 0.002)}


def jar() -> Solids:
    """Jar with shoulder and neck, its contents, and the lid."""
    shoulder = [(0.036, 0.076), (0.0345, 0.082), (0.0315, 0.085), (0.0315, 0.101)]
    inside = [(0.029, 0.101), (0.029, 0.084), (0.033, 0.078), (0.033, 0.008), (0.030, 0.005)]
    glass = [(0, 0), (0.033, 0), (0.0355, 0.0015), (0.036, 0.004), *shoulder, *inside, (0, 0.005)]
    coffee = [(0, 0.0052), (0.0298, 0.0052), (0.0328, 0.0082), (0.0328, 0.066), (0, 0.069)]
    edge = _arc((0.0329, 0.1024), (0.0016, 0.0016), 0, 90, 5)
    lid = [(0, 0.1012), (0.0318, 0.1012), (0.0318, 0.088), (0.0345, 0.088), *edge]
    lid += [(0.028, 0.104), (0.0275, 0.1034), (0, 0.1034)]
    return {"jar_glass": lathe(glass), "jar_coffee": lathe(coffee), "jar_lid": lathe(lid)}


def hammer() -> Solids:
    """Locksmith's hammer on its side: square face to -y, peen to +y, oval handle along x."""
    low, high, middle = 0.1270, 0.1500, 0.1385
    body = block((low + 0.001, -0.031, 0.001), (high - 0.001, 0.014, 0.022))
    face = _hull(
        [(x, y, z) for y, cut in ((-0.030, 0.0), (-0.050, 0.0), (-0.0525, 0.002))
         for x in (low + cut, high - cut) for z in (cut, 0.023 - cut)]
    )  # fmt: skip
    peen = _hull(
        [(x, y, z) for y, half in ((0.010, 0.0115), (0.050, 0.0035), (0.0525, 0.002))
         for x in (middle - half, middle + half) for z in (0.0, 0.023)]
    )  # fmt: skip
    stations = [(-0.150, 0.0120, 0.0095), (-0.147, 0.0145, 0.0115), (-0.120, 0.0145, 0.0112),
                (-0.060, 0.0140, 0.0105), (0.020, 0.0115, 0.0092), (0.090, 0.0100, 0.0082),
                (0.152, 0.0095, 0.0080)]  # fmt: skip
    rings = [[(x, y, z + 0.0115) for y, z in _arc((0, 0), (a, b), 0, 345, 24)]
             for x, a, b in stations]  # fmt: skip
    handle = _union(_hull([*a, *b]) for a, b in pairwise(rings))
    return {"hammer_head": body + face + peen, "hammer_handle": handle}


def pen() -> Solids:
    """Hexagonal ballpoint pen on one of its flats, tip to +x."""
    half = 0.0045
    corner = half / np.cos(np.pi / 6)
    hexagon = [
        (corner * np.sin(angle), half + corner * np.cos(angle))
        for angle in (np.arange(6) + 0.5) * np.pi / 3
    ]
    ends = [(x, scale) for x, scale in ((-0.062, 0.94), (-0.061, 1.0), (0.049, 1.0))]
    barrel = _hull(
        [(x, scale * y, half + scale * (z - half)) for x, scale in ends for y, z in hexagon]
    )
    cone = [(0, 0.048), (0.0040, 0.048), (0.0042, 0.050), (0.0014, 0.066), (0.0005, 0.0695)]
    button = [(0, -0.070), (0.0022, -0.070), (0.0026, -0.0695), (0.0026, -0.060), (0, -0.060)]
    clip = block((-0.060, -0.0014, 0.0105), (-0.022, 0.0014, 0.0112))
    clip += block((-0.060, -0.0014, 0.0088), (-0.057, 0.0014, 0.0112))
    tip = along_x([*cone, (0, 0.070)], half) + along_x(button, half)
    return {"pen_barrel": barrel, "pen_metal": tip + clip - barrel}


def screwdriver() -> Solids:
    """Screwdriver on one flat of its six-sided handle, tip to +x."""
    height = 0.0135
    hexagon = CrossSection.circle(height / np.cos(np.pi / 6), 6).rotate(30.0)
    prism = hexagon.offset(-0.003).offset(0.003, circular_segments=24).extrude(0.105)
    prism = prism.rotate((0, 90, 0)).translate((-0.1075, 0, height))
    envelope = [(0, -0.1075), (0.010, -0.1075), (0.0135, -0.1050), (0.0156, -0.100),
                (0.0156, -0.035), (0.0130, -0.026), (0.0095, -0.020), (0.0090, -0.015),
                (0.0105, -0.008), (0.0100, -0.0035), (0.0085, -0.0025), (0, -0.0025)]  # fmt: skip
    shaft = [(0, -0.045), (0.003, -0.045), (0.003, 0.099), (0.0012, 0.1075), (0, 0.1075)]
    handle = prism ^ along_x(envelope, height, 48)
    blade = along_x(shaft, height, 24)
    slots = _union(
        block((0.0985, -0.003, -0.0005), (0.109, -0.0009, 0.003)).rotate((angle, 0, 0))
        for angle in (0, 90, 180, 270)
    )  # leaves the cross of a Phillips tip
    tip = slots.translate((0, 0, height))
    return {"screwdriver_handle": handle - blade, "screwdriver_blade": blade - tip}


def book() -> Solids:
    """Hardcover book that stands: spine to -x, fore edge to +x."""
    boards = [block((-0.063, y - 0.00125, 0.0), (0.065, y + 0.00125, 0.200))
              for y in (-0.00975, 0.00975)]  # fmt: skip
    spine = _outline(_arc((-0.058, 0), (0.007, 0.011), 90, 270, 17)).extrude(0.200)
    hollow = _outline(_arc((-0.0575, 0), (0.005, 0.0085), 90, 270, 17)).extrude(0.200)
    cover = boards[0] + boards[1] + (spine - hollow)
    pages = block((-0.060, -0.0085, 0.003), (0.0615, 0.0085, 0.197))
    return {"book_cover": cover, "book_pages": pages}


def phone() -> Solids:
    """Bar phone of about 2008 on its back: top end to +x, screen up."""
    body = rounded_box((0.106, 0.048, 0.0153), (0, 0, 0.00765), 0.004)
    screen = rounded_box((0.046, 0.036, 0.002), (0.022, 0, 0.0145), 0.0005)
    keys = [rounded_box((0.0065, 0.0105, 0.002), (x, y, 0.0145), 0.0006, 8)
            for x in (-0.044, -0.035, -0.026, -0.017) for y in (-0.0125, 0.0, 0.0125)]  # fmt: skip
    keys.append(rounded_box((0.011, 0.014, 0.002), (-0.0065, 0, 0.0145), 0.0006))
    return {"phone_body": body, "phone_screen": screen, "phone_keys": _union(keys)}


def phone_today() -> Solids:
    """Flat phone of today on its back: top end to +x, screen up."""
    shape = CrossSection.square((0.1476 - 0.022, 0.0716 - 0.022), True)
    body = shape.offset(0.011, circular_segments=32).extrude(0.0076)
    glass = shape.offset(0.0095, circular_segments=32).extrude(0.002).translate((0, 0, 0.0058))
    return {"phone_today_body": body - glass, "phone_today_screen": glass}


PIVOT = (0.012, 0.0)
"""Screw of the scissors, x and y [m]."""


def scissors() -> Solids:
    """Closed scissors: tips to +x; the fixed half's loop on -y, the moving half's on +y."""
    ring = _outline(_arc((-0.070, 0.0225), (0.029, 0.021), 0, 350, 36))
    ring -= _outline(_arc((-0.070, 0.0225), (0.0195, 0.0130), 0, 350, 36))
    loop = ring.extrude(0.010)
    shank = [(-0.046, 0.0085), (-0.046, 0.0255), (0.006, 0.0055), (0.016, -0.004), (0.004, -0.006)]
    upper = loop + plate(shank, 0.0047, 0.0095)
    lower = (loop + plate(shank, 0.0, 0.0046)).mirror((0, 1, 0))
    blade = [(-0.012, 0.0055), (-0.004, -0.0065), (0.020, -0.0085), (0.060, -0.0055),
             (0.100, 0.0005), (0.096, 0.0020), (0.010, 0.0045)]  # fmt: skip
    screw = Manifold.cylinder(0.0015, 0.0035, 0.003, 24).translate((*PIVOT, 0.0090))
    cut = plate(blade, 0.0047, 0.0067)
    fixed = plate(blade, 0.0025, 0.0045).mirror((0, 1, 0))
    return {
        "scissors_grip": lower - fixed,
        "scissors_blade": fixed,
        "scissors_moving_grip": upper - cut,
        "scissors_moving_blade": cut + screw,
    }


def stapler() -> Solids:
    """Half-strip desk stapler: mouth to +x; base and arm."""
    tongue = [(-0.065, -0.018), (0.060, -0.018), (0.065, -0.012), (0.065, 0.012), (0.060, 0.018)]
    base = plate([*tongue, (-0.065, 0.018)], 0.0, 0.006, 0.003)
    anvil = block((0.046, -0.007, 0.0), (0.058, 0.007, 0.0075))
    cheeks = _union(
        plate([(-0.062, 0.004), (-0.032, 0.004), (-0.046, 0.034), (-0.060, 0.034)], y, y + 0.002)
        .rotate((90, 0, 0))
        for y in (-0.016, 0.014)
    )  # fmt: skip
    side = [(-0.064, 0.026), (-0.064, 0.045), (-0.056, 0.053), (-0.030, 0.055), (0.020, 0.0545),
            (0.052, 0.050), (0.062, 0.041), (0.062, 0.024), (-0.040, 0.024)]  # fmt: skip
    arm = plate(side, -0.0135, 0.0135, 0.003).rotate((90, 0, 0))
    rail = block((-0.040, -0.006, 0.0205), (0.061, 0.006, 0.026))
    return {
        "stapler_base": base + anvil + cheeks,
        "stapler_arm": arm - rail,
        "stapler_rail": rail,
    }


def mouse() -> Solids:
    """Wired optical mouse: buttons to +x; shell in three parts and wheel."""
    sections = [(0.0, 0.0545, 0.0290, 0.0), (0.003, 0.0565, 0.0310, 0.0),
                (0.016, 0.0560, 0.0300, 0.0), (0.026, 0.0500, 0.0272, -0.002),
                (0.033, 0.0395, 0.0225, -0.007), (0.0368, 0.0240, 0.0145, -0.011),
                (0.038, 0.0100, 0.0065, -0.013)]  # fmt: skip
    angles = np.deg2rad(np.arange(0, 360, 7.5))
    rounded = [np.sign(f(angles)) * np.abs(f(angles)) ** 0.8 for f in (np.cos, np.sin)]
    shape = _hull(
        np.vstack(
            [np.column_stack([c + a * rounded[0], b * rounded[1], np.full_like(angles, z)])
             for z, a, b, c in sections]
        )
    )  # fmt: skip
    front = block((0.008, -0.05, 0.0145), (0.08, 0.05, 0.05))
    lid = shape ^ block((0.0086, -0.05, 0.0160), (0.08, 0.05, 0.05))
    slot = block((0.016, -0.0042, 0.0), (0.044, 0.0042, 0.05))
    wheel = Manifold.cylinder(0.0064, 0.0105, 0.0105, 40, True).rotate((90, 0, 0))
    halves = [lid ^ block((0.0, low, 0.0), (0.08, high, 0.05))
              for low, high in ((0.0008, 0.05), (-0.05, -0.0008))]  # fmt: skip
    return {
        "mouse_shell": shape - front,
        "mouse_left_button": halves[0] - slot,
        "mouse_right_button": halves[1] - slot,
        "mouse_wheel": wheel.translate((0.030, 0.0, 0.0215)) - (shape - front),
        "mouse_contact_rear": shape ^ block((-0.08, -0.05, 0.0), (0.008, 0.05, 0.05)),
        "mouse_contact_front": shape ^ block((0.0, -0.05, 0.0), (0.08, 0.05, 0.0145)),
    }


MAKERS: tuple[Callable[[], Solids], ...] = (
    tall_glass, mouse, cup, hammer, ashtray, cube, pen, jar, screwdriver, book, phone, phone_today,
    scissors, stapler,
)  # fmt: skip
"""Every object's maker, in the order of Table I."""


def surface(solid: Manifold) -> TriangleMesh:
    """Return the surface: vertices rounded to 1 micrometre and triangles in canonical order."""
    mesh = solid.to_mesh64()
    points = np.round(np.asarray(mesh.vert_properties)[:, :3], 6) + 0.0
    vertices, index = np.unique(points, axis=0, return_inverse=True)
    faces = index.ravel()[np.asarray(mesh.tri_verts, dtype=int)]
    faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
    first = faces.argmin(axis=1)
    faces = np.take_along_axis(faces, (first[:, None] + np.arange(3)) % 3, axis=1)
    order = np.lexsort(faces.T[::-1])
    return TriangleMesh(vertices.astype(np.float64), faces[order].astype(np.int32))
