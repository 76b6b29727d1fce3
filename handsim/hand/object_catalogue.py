"""The 13 objects of Table I as data; sizes and masses with their sources in assets/README.md."""

from handsim.hand.grasp_object import (
    GraspObject,
    Hinge,
    Link,
    Piece,
    box,
    ring,
    upright_cylinder,
)

CLEAR_GLASS = (0.72, 0.86, 0.92, 0.35)

TALL_GLASS = GraspObject(
    name="tall-glass",
    front="any side",
    pieces=(Piece("tall_glass", 0.225, CLEAR_GLASS, 0.9),),
    colliders=(
        upright_cylinder(0.032, 0.0, 0.010),
        *ring((0.0298, 0.0298), (0.032, 0.032), (0.010, 0.145), 24),
    ),
    source="straight 35 cl highball glass, 145 x 64 mm, 2.2 mm wall, 10 mm base, soda-lime glass",
    symmetry="z",
)

CUBE = GraspObject(
    name="cube",
    front="any face",
    pieces=(Piece("cube", 0.118, (0.80, 0.58, 0.36, 1.0), 0.2),),
    colliders=(box((0.055, 0.055, 0.055), (0.0, 0.0, 0.0275)),),
    source="55 mm cube of beech, 720 kg/m3",
)

JAR = GraspObject(
    name="jar",
    front="any side",
    pieces=(
        Piece("jar_glass", 0.190, CLEAR_GLASS, 0.9),
        Piece("jar_coffee", 0.100, (0.28, 0.16, 0.09, 1.0), 0.1),
    ),
    colliders=(upright_cylinder(0.036, 0.0, 0.082), upright_cylinder(0.030, 0.082, 0.090)),
    links=(
        Link(
            Hinge(
                "lid",
                axis=(0.0, 0.0, 1.0),
                anchor=(0.0, 0.0, 0.0),
                range_deg=(0.0, 360.0),
                friction=0.15,
                pitch=0.006,
            ),
            pieces=(Piece("jar_lid", 0.014, (0.75, 0.15, 0.13, 1.0), 0.5),),
            colliders=(upright_cylinder(0.0345, 0.088, 0.104),),
        ),
    ),
    source="370 ml twist-off jar, 72 x 104 mm, with 100 g of instant coffee",
    symmetry="z",
)

OBJECTS: dict[str, GraspObject] = {item.name: item for item in (TALL_GLASS, CUBE, JAR)}
"""Every built-in object by name."""
