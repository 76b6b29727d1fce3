import mujoco
import numpy as np
import pytest

from handsim.objects.catalogue import OBJECTS
from handsim.objects.convex_solid import corners
from handsim.objects.mirror import mirrored, reflected, reflected_axis
from handsim.objects.mjcf import add_object, points_of, surface_of
from handsim.objects.object import GraspObject, Hinge, Link, TriangleMesh

MIRROR = np.array([1.0, -1.0, 1.0])
every_object = pytest.mark.parametrize("name", OBJECTS)


@every_object
def test_the_mirror_image_of_the_mirror_image_is_the_object(name: str) -> None:
    assert mirrored(mirrored(OBJECTS[name])) == OBJECTS[name]
    assert mirrored(OBJECTS[name]) != OBJECTS[name]


@every_object
def test_surfaces_and_contact_pieces_are_mirrored(name: str) -> None:
    thing, image = OBJECTS[name], mirrored(OBJECTS[name])
    for mine, theirs in zip((thing, *thing.links), (image, *image.links), strict=True):
        for one, other in zip(mine.pieces, theirs.pieces, strict=True):
            here, there = surface_of(one), surface_of(other)
            np.testing.assert_array_equal(there.vertices, MIRROR * here.vertices)
            assert volume(there) == pytest.approx(volume(here))  # outside is outside
            assert not there.vertices.flags.writeable and not there.faces.flags.writeable
        for one, other in zip(mine.colliders, theirs.colliders, strict=True):
            here, there = MIRROR * corners(one), corners(other)
            order, places = np.lexsort(here.round(9).T), np.lexsort(there.round(9).T)
            if one.kind in ("box", "hull"):
                np.testing.assert_allclose(there[places], here[order], atol=1e-12)
            np.testing.assert_allclose(other.pos, MIRROR * one.pos)
            if one.mesh:
                np.testing.assert_array_equal(points_of(other), MIRROR * points_of(one))


def volume(mesh: TriangleMesh) -> float:
    a, b, c = (mesh.vertices[mesh.faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


@pytest.mark.parametrize("angle", [0.0, 0.5])
def test_a_hinge_turns_what_it_carries_to_the_mirrored_place(angle: float) -> None:
    """Also where it rises as a screw does; the axis is oblique, so that no sign can be wrong."""
    axis = (0.36, 0.48, 0.8)
    hinge = Hinge("lid", axis, (0.01, 0.02, 0.03), (-90.0, 90.0), pitch=0.05)
    cube = OBJECTS["cube"]
    thing = GraspObject(
        "made", "any", cube.pieces, cube.colliders, "made up",
        links=(Link(hinge, OBJECTS["hammer"].pieces, ()),),
    )  # fmt: skip
    poses = []
    for each in (thing, mirrored(thing)):
        spec = mujoco.MjSpec()
        add_object(spec, each, start={"lid": angle})
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        frame = data.body("lid")
        poses.append((frame.xpos.copy(), frame.xmat.reshape(3, 3).copy()))
    (pos, turn), (there, turned) = poses
    np.testing.assert_allclose(there, MIRROR * pos, atol=1e-12)
    np.testing.assert_allclose(turned, np.diag(MIRROR) @ turn @ np.diag(MIRROR), atol=1e-12)


def test_points_are_reflected_and_axes_as_turns_are() -> None:
    assert reflected((1.0, 2.0, 3.0)) == (1.0, -2.0, 3.0)
    assert str(reflected((1.0, 0.0, 3.0))) == "(1.0, 0.0, 3.0)"  # never -0
    assert reflected_axis((1.0, 2.0, 3.0)) == (-1.0, 2.0, -3.0)
