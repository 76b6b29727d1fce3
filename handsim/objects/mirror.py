"""The mirror image of an object across y = 0 of its own frame.

A hammer's is the hammer turned over. That of scissors is a pair for left-handers.
"""

from dataclasses import replace

from handsim.objects.grasp import Grasp
from handsim.objects.object import Collider, GraspObject, Hinge, Link, Piece, Vec3


def mirrored(grasp_object: GraspObject) -> GraspObject:
    """Return the mirror image of an object; its mirror image is the object again."""
    links = tuple(
        Link(_hinge(link.hinge), *_shapes(link.pieces, link.colliders))
        for link in grasp_object.links
    )
    pieces, colliders = _shapes(grasp_object.pieces, grasp_object.colliders)
    return replace(grasp_object, pieces=pieces, colliders=colliders, links=links)


def mirrored_grasp(grasp: Grasp) -> Grasp:
    """Return the other hand's grasp of the mirror image of what is grasped."""
    return replace(
        grasp,
        point=reflected(grasp.point),
        opposition=reflected(grasp.opposition),
        approach=reflected(grasp.approach),
        pointing=grasp.pointing and reflected(grasp.pointing),
    )


def reflected(vector: Vec3) -> Vec3:
    """Return a point or direction as a mirror shows it."""
    x, y, z = vector
    return (x, 0.0 - y, z)  # never -0, which would be told of a grasp


def reflected_axis(axis: Vec3) -> Vec3:
    """Return the axis about which a mirror shows a turn by the same angle (an axial vector)."""
    x, y, z = axis
    return (-x, y, -z)


def _shapes(
    pieces: tuple[Piece, ...], colliders: tuple[Collider, ...]
) -> tuple[tuple[Piece, ...], tuple[Collider, ...]]:
    seen = tuple(replace(piece, mirrored=not piece.mirrored) for piece in pieces)
    return seen, tuple(map(_collider, colliders))


def _collider(collider: Collider) -> Collider:
    """Mirror a collider; primitives are their own mirror images in their own frames."""
    w, *turn = collider.quat
    x, y, z = turn
    return replace(
        collider,
        pos=reflected(collider.pos),
        quat=(w, -x, y, -z),
        points=tuple(map(reflected, collider.points)),
        mirrored=not collider.mirrored,
    )


def _hinge(hinge: Hinge) -> Hinge:
    """Mirror a hinge; a right-handed thread becomes a left-handed one."""
    return replace(
        hinge,
        axis=reflected_axis(hinge.axis),
        anchor=reflected(hinge.anchor),
        pitch=-hinge.pitch,
    )
