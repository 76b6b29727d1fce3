"""The 13 objects of Table I as data; sizes and masses with their sources in assets/README.md."""

from itertools import pairwise

import numpy as np

from handsim.objects.object import (
    CLEARANCE,
    Collider,
    GraspObject,
    Hinge,
    Link,
    Piece,
    Vec3,
    box,
    drum,
    feet,
    hull,
    hull_of,
    prism_along_x,
    ring,
    rod,
)

CLEAR_GLASS = (0.75, 0.88, 0.93, 0.25)
STEEL = (0.72, 0.73, 0.75, 1.0)
BLACK = (0.13, 0.13, 0.14, 1.0)

TALL_GLASS = GraspObject(
    name="tall-glass",
    front="any side",
    pieces=(Piece("tall_glass", 0.225, CLEAR_GLASS, 0.9),),
    colliders=(
        *feet(0.030),
        drum(0.032, CLEARANCE, 0.010),
        *ring((0.0298, 0.0298), (0.032, 0.032), (0.010, 0.145), 24),
    ),
    source="straight 35 cl highball glass, 145 x 64 mm; 90 cm3 of soda-lime glass, 2500 kg/m3",
    symmetry="z",
)


def _button(side: str, sign: int) -> Link:
    """Return a mouse button that yields 1.1 mm at 1 N under the fingertip, 45 mm before it."""
    name = f"{side}_button"
    hinge = Hinge(
        name,
        axis=(0.0, 1.0, 0.0),
        anchor=(0.0086, sign * 0.015, 0.030),
        range_deg=(0.0, 1.4),
        stiffness=1.0 * 0.045 / np.deg2rad(1.4),
        damping=2e-3,
    )
    grey = (0.17, 0.18, 0.20, 1.0)
    mesh = f"mouse_{name}"
    return Link(hinge, (Piece(mesh, 0.006, grey, 0.3),), (hull_of(mesh),))


MOUSE = GraspObject(
    name="mouse",
    front="buttons",
    pieces=(
        Piece("mouse_shell", 0.074, (0.30, 0.31, 0.34, 1.0), 0.4),
        Piece("mouse_wheel", 0.002, (0.55, 0.56, 0.58, 1.0), 0.2),
    ),
    colliders=(hull_of("mouse_contact_rear"), hull_of("mouse_contact_front")),
    links=(_button("left", 1), _button("right", -1)),
    source="113 x 62 x 38 mm (Logitech B100); 88 g, 1 N and 0.5 mm to click (maker's data sheet "
    "of a mouse of that size), here 1.1 mm so that a click can be seen",
)

_HANDLE: tuple[Vec3, ...] = (
    (0.039, 0.0, 0.0662), (0.052, 0.0, 0.0662), (0.0620, 0.0, 0.0600), (0.0660, 0.0, 0.0480),
    (0.0650, 0.0, 0.0350), (0.0580, 0.0, 0.0250), (0.039, 0.0, 0.0168),
)  # fmt: skip
CUP = GraspObject(
    name="cup",
    front="handle",
    pieces=(Piece("cup", 0.225, (0.93, 0.92, 0.88, 1.0), 0.6),),
    colliders=(
        *feet(0.032),
        drum(0.034, CLEARANCE, 0.005),
        *ring((0.030, 0.0365), (0.034, 0.040), (0.005, 0.012), 20),
        *ring((0.0365, 0.0365), (0.040, 0.040), (0.012, 0.082), 20),
        *(rod(start, end, 0.005) for start, end in pairwise(_HANDLE)),
    ),
    source="coffee cup of 80 x 82 mm, as mug 025 of the YCB set; 94 cm3 of stoneware, 2400 kg/m3",
)


def _handle_of_hammer() -> tuple[Collider, ...]:
    stations = (
        (-0.150, 0.0120, 0.0095), (-0.147, 0.0145, 0.0115), (-0.120, 0.0145, 0.0112),
        (-0.060, 0.0140, 0.0105), (0.020, 0.0115, 0.0092), (0.127, 0.0096, 0.0080),
    )  # fmt: skip
    angles = np.arange(16) * np.pi / 8
    rings = [
        [(x, a * np.cos(angle), 0.0115 + b * np.sin(angle)) for angle in angles]
        for x, a, b in stations
    ]
    return (hull([*rings[0], *rings[1], *rings[2]]), *(
        hull([*a, *b]) for a, b in pairwise(rings[2:])
    ))  # fmt: skip


HAMMER = GraspObject(
    name="hammer",
    front="head; its face to -y",
    pieces=(
        Piece("hammer_head", 0.300, (0.33, 0.34, 0.36, 1.0), 0.8),
        Piece("hammer_handle", 0.078, (0.80, 0.62, 0.40, 1.0), 0.2),
    ),
    colliders=(
        box((0.023, 0.083, 0.023), (0.1385, -0.011, 0.0115)),
        hull(
            [(0.1385 + x, y, z) for y, half in ((0.030, 0.008), (0.0525, 0.002))
             for x in (-half, half) for z in (0.0, 0.023)]
        ),
        *_handle_of_hammer(),
    ),
    source="locksmith's hammer, 300 g head of 105 x 23 mm, ash handle of 300 mm (DIN 1041 class)",
    handed=True,
)  # fmt: skip

ASHTRAY = GraspObject(
    name="ashtray",
    front="any side",
    pieces=(Piece("ashtray", 0.330, (0.78, 0.86, 0.84, 0.55), 0.9),),
    colliders=(
        *feet(0.048),
        drum(0.050, CLEARANCE, 0.008),
        *ring((0.0365, 0.041), (0.050, 0.050), (0.008, 0.032), 20),
    ),
    source="round glass ashtray of 100 x 32 mm; 132 cm3 of soda-lime glass, 2500 kg/m3",
    symmetry="z",
)

CUBE = GraspObject(
    name="cube",
    front="any face",
    pieces=(Piece("cube", 0.119, (0.80, 0.58, 0.36, 1.0), 0.2),),
    colliders=(box((0.055, 0.055, 0.055), (0.0, 0.0, 0.0275)),),
    source="55 mm cube of beech; 166 cm3, 720 kg/m3",
)

PEN = GraspObject(
    name="pen",
    front="tip",
    pieces=(
        Piece("pen_barrel", 0.0085, (0.10, 0.22, 0.55, 1.0), 0.7),
        Piece("pen_metal", 0.0035, STEEL, 0.9),
    ),
    colliders=(
        prism_along_x(-0.062, 0.049, 0.0045, 0.0045),
        prism_along_x(0.049, 0.062, 0.0045, 0.0022),
        rod((0.062, 0.0, 0.0045), (0.0690, 0.0, 0.0045), 0.0010),
        rod((-0.070, 0.0, 0.0045), (-0.062, 0.0, 0.0045), 0.0024, "cylinder"),
    ),
    source="hexagonal metal ballpoint pen, 140 x 9 mm, 12 g",
    symmetry="x",
)

JAR = GraspObject(
    name="jar",
    front="any side",
    pieces=(
        Piece("jar_coffee", 0.050, (0.36, 0.18, 0.07, 1.0), 0.1),
        Piece("jar_glass", 0.200, CLEAR_GLASS, 0.9),
    ),
    colliders=(*feet(0.034), drum(0.036, CLEARANCE, 0.082), drum(0.0315, 0.082, 0.101)),
    links=(
        Link(
            Hinge(
                "lid",
                axis=(0.0, 0.0, 1.0),
                anchor=(0.0, 0.0, 0.0),
                range_deg=(0.0, 360.0),
                friction=0.03,  # once loosened: the jar's weight on the table withstands 0.044 N m
                pitch=0.006,
            ),
            pieces=(Piece("jar_lid", 0.014, (0.70, 0.12, 0.11, 1.0), 0.5),),
            colliders=(drum(0.0345, 0.088, 0.104),),
        ),
    ),
    source="370 ml twist-off jar of 72 x 104 mm: 80 cm3 of soda-lime glass, 14 g tinplate lid; "
    "with 50 g of instant coffee, 240 kg/m3",
    symmetry="z",
)

SCREWDRIVER = GraspObject(
    name="screwdriver",
    front="tip",
    pieces=(
        Piece("screwdriver_handle", 0.065, (0.85, 0.35, 0.08, 1.0), 0.5),
        Piece("screwdriver_blade", 0.032, STEEL, 0.9),
    ),
    colliders=(
        prism_along_x(-0.1075, -0.030, 0.0135, 0.0135, corner=0.0152),
        prism_along_x(-0.030, -0.0025, 0.0135, 0.0100),
        rod((-0.0025, 0.0, 0.0135), (0.1060, 0.0, 0.0135), 0.003),
    ),
    source="as Phillips screwdriver 043 of the YCB set: 215 x 31 mm, 97 g",
    symmetry="x",
)

BOOK = GraspObject(
    name="book",
    front="fore edge; it stands, spine to -x",
    pieces=(
        Piece("book_cover", 0.090, (0.16, 0.33, 0.36, 1.0), 0.2),
        Piece("book_pages", 0.300, (0.93, 0.90, 0.82, 1.0), 0.0),
    ),
    colliders=(box((0.130, 0.022, 0.200), (0.0, 0.0, 0.100)),),
    source="hardcover novel of 130 x 200 x 22 mm: 137 cm3 of board, 650 kg/m3, and 401 cm3 of "
    "pages, 750 kg/m3",
)

PHONE = GraspObject(
    name="phone",
    front="top end; screen up",
    pieces=(
        Piece("phone_body", 0.097, (0.18, 0.19, 0.21, 1.0), 0.5),
        Piece("phone_screen", 0.006, (0.30, 0.50, 0.65, 1.0), 0.9),
        Piece("phone_keys", 0.002, (0.68, 0.69, 0.71, 1.0), 0.4),
    ),
    colliders=(box((0.106, 0.048, 0.0155), (0.0, 0.0, 0.00775)),),
    source="Sony Ericsson C702 (2008): 106 x 48 x 15.5 mm, 105 g (maker's data)",
)

PHONE_TODAY = GraspObject(
    name="phone-today",
    front="top end; screen up",
    pieces=(
        Piece("phone_today_body", 0.122, (0.62, 0.66, 0.72, 1.0), 0.6),
        Piece("phone_today_screen", 0.049, (0.05, 0.06, 0.08, 1.0), 0.9),
    ),
    colliders=(box((0.1476, 0.0716, 0.0078), (0.0, 0.0, 0.0039)),),
    source="Apple iPhone 15 (2023): 147.6 x 71.6 x 7.8 mm, 171 g (maker's data)",
)


def _half_of_scissors(sign: int, shank_bottom: float, blade_bottom: float) -> tuple[Collider, ...]:
    """Return loop, shank and blade; ``sign`` is the loop's side of the x axis.

    Of the loop only the far end stands on the table: three feet neither rock nor make many
    contacts.
    """
    angles = np.arange(13) * np.pi / 6
    loop = [
        (-0.070 + 0.0243 * x, sign * (0.0225 + 0.0165 * y), 0.0045 if x < -0.8 else 0.0048)
        for x, y in zip(np.cos(angles), np.sin(angles), strict=True)
    ]
    shank = ((-0.046, 0.0085), (-0.046, 0.0255), (0.006, 0.0055), (0.016, -0.004), (0.004, -0.006))
    blade = (
        (-0.004, -0.0065),
        (0.020, -0.0085),
        (0.060, -0.0055),
        (0.100, 0.0005),
        (0.010, 0.0045),
    )
    return (
        *(rod(start, end, 0.0045) for start, end in pairwise(loop)),
        *(
            hull([(x, sign * y, z) for x, y in outline for z in (bottom, bottom + thick)])
            for outline, bottom, thick in (
                (shank, shank_bottom, 0.0048),
                (blade, blade_bottom, 0.0020),
            )
        ),
    )


_GREEN = (0.12, 0.42, 0.30, 1.0)
SCISSORS = GraspObject(
    name="scissors",
    front="tips; the moving half's loop lies on +y",
    pieces=(
        Piece("scissors_grip", 0.016, _GREEN, 0.4),
        Piece("scissors_blade", 0.025, STEEL, 0.9),
    ),
    colliders=_half_of_scissors(-1, 0.0, 0.0025),
    links=(
        Link(
            Hinge(
                "blade",
                axis=(0.0, 0.0, -1.0),
                anchor=(0.012, 0.0, 0.0),
                range_deg=(0.0, 60.0),
                friction=0.05,  # the pivot's: they shut at 0.7 N on each loop
                damping=1e-3,
            ),
            pieces=(
                Piece("scissors_moving_grip", 0.016, _GREEN, 0.4),
                Piece("scissors_moving_blade", 0.025, STEEL, 0.9),
            ),
            colliders=_half_of_scissors(1, 0.0047, 0.0047),
        ),
    ),
    source="as scissors 037 of the YCB set: 200 x 87 mm, 82 g; 10.5 mm thick",
    handed=True,
)

STAPLER = GraspObject(
    name="stapler",
    front="mouth",
    pieces=(Piece("stapler_base", 0.090, (0.22, 0.22, 0.24, 1.0), 0.6),),
    colliders=(
        box((0.130, 0.036, 0.006), (0.0, 0.0, 0.003)),
        box((0.026, 0.032, 0.022), (-0.048, 0.0, 0.017)),
    ),
    links=(
        Link(
            Hinge(
                "arm",
                axis=(0.0, 1.0, 0.0),
                anchor=(-0.053, 0.0, 0.029),
                range_deg=(0.0, 6.0),
                stiffness=3.0 * 0.112 / np.deg2rad(6.0),
                rest_deg=-1.2,  # carries the arm's weight
                damping=0.02,
            ),
            pieces=(
                Piece("stapler_arm", 0.080, (0.62, 0.10, 0.12, 1.0), 0.6),
                Piece("stapler_rail", 0.030, STEEL, 0.9),
            ),
            colliders=(
                hull(
                    [(x, y, z) for x, z in ((-0.064, 0.026), (-0.064, 0.045), (-0.056, 0.053),
                     (-0.030, 0.055), (0.020, 0.0545), (0.052, 0.050), (0.062, 0.041),
                     (0.062, 0.024)) for y in (-0.0135, 0.0135)]
                ),
            ),
        ),
    ),
    source="half-strip desk stapler of 130 x 36 x 55 mm, 0.2 kg; return spring of 3 N at the mouth "
    "when shut; no staple in it",
)  # fmt: skip

OBJECTS: dict[str, GraspObject] = {
    item.name: item
    for item in (
        TALL_GLASS, MOUSE, CUP, HAMMER, ASHTRAY, CUBE, PEN, JAR, SCREWDRIVER, BOOK, PHONE,
        PHONE_TODAY, SCISSORS, STAPLER,
    )
}  # fmt: skip
"""Every built-in object by name: the 13 of Table I and today's phone."""
