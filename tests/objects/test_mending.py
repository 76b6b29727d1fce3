"""What is wrong with users' meshes is mended where that is safe, and said; the rest is refused."""

import numpy as np
import pytest
import trimesh

from handsim.errors import InputError
from handsim.objects.meshes.mending import Solid, mend
from handsim.objects.meshes.mesh_file import Triangles
from handsim.objects.meshes.surface import centroid, signed_volume, winding

from .shapes import ball, box, moebius, of, soup, together, turned, without

BOX = 0.04 * 0.05 * 0.06


def volume(solid: Solid) -> float:
    return signed_volume(*solid.surface)


@pytest.mark.parametrize("part", [box(), soup(box())], ids=["shared", "soup"])
def test_a_sound_box_is_left_as_it_is(part: Triangles) -> None:
    solid = mend(part)
    assert (solid.watertight, solid.mended, len(solid.bodies)) == (True, (), 1)
    assert volume(solid) == pytest.approx(BOX)


def test_inside_out_is_turned_and_said() -> None:
    solid = mend(turned(box()))
    assert solid.watertight
    assert solid.mended == ("inside out: turned right side out",)
    assert volume(solid) == pytest.approx(BOX)


@pytest.mark.parametrize("first", [0, 2])
def test_single_triangles_are_turned_like_their_neighbours(first: int) -> None:
    solid = mend(turned(box(), slice(first, first + 3)))
    assert solid.mended == ("3 triangles turned the way round of their neighbours",)
    assert volume(solid) == pytest.approx(BOX)


def test_a_small_hole_is_closed_and_a_large_one_is_refused() -> None:
    whole = ball()
    at = int(whole.vertices[:, 2].argmax())
    around = np.nonzero((whole.faces == at).any(axis=1))[0]
    solid = mend(without(whole, *around.tolist()))
    assert not solid.watertight
    (said,) = solid.mended
    assert said.startswith("1 small hole closed, the widest 15.")
    assert volume(solid) == pytest.approx(signed_volume(whole.vertices, whole.faces), rel=0.01)
    half = np.nonzero(whole.vertices[whole.faces].mean(axis=1)[:, 2] > 0)[0]
    with pytest.raises(InputError, match=r"not watertight: 1 hole, the widest 100 % .* thickness"):
        mend(without(whole, *half.tolist()))


def test_one_wide_hole_of_little_area_and_many_small_ones_of_much_are_refused() -> None:
    """Each of the two limits by itself: a slot, and a surface like a sieve."""
    long = of(trimesh.creation.box((0.2, 0.05, 0.05)).subdivide().subdivide().subdivide())
    middle = long.vertices[long.faces].mean(axis=1)
    slot = (middle[:, 2] > 0.0249) & (np.abs(middle[:, 1]) < 0.0063) & (np.abs(middle[:, 0]) < 0.05)
    with pytest.raises(InputError, match=r"widest 50 % .* and [1-4] % of the surface"):
        mend(without(long, *np.nonzero(slot)[0].tolist()))
    whole = ball(0.03, 4)
    with pytest.raises(InputError, match=r"widest [5-9] % .* and (1\d|[6-9]) % of the surface"):
        mend(without(whole, *range(0, len(whole.faces), 12)))


def test_of_each_patch_the_smaller_part_is_turned() -> None:
    """Most of these triangles look inwards: turned the way of most, they are inside out."""
    solid = mend(turned(box(), slice(0, 9)))
    assert solid.mended == (
        "3 triangles turned the way round of their neighbours",
        "inside out: turned right side out",
    )
    assert volume(solid) == pytest.approx(BOX)


def test_a_triangle_that_is_missing_is_put_back() -> None:
    whole = ball()
    solid = mend(without(whole, 17))
    assert len(solid.surface[1]) == len(whole.faces)
    assert volume(solid) == pytest.approx(signed_volume(whole.vertices, whole.faces))


@pytest.mark.parametrize("missing", [1, 2])
def test_long_triangles_that_are_missing_are_put_back(missing: int) -> None:
    """The wall of a bottle is made of slivers as long as itself: a hole of many corners is not."""
    whole = of(trimesh.creation.cylinder(radius=0.03, height=0.2, sections=64))
    wall = np.nonzero(np.ptp(whole.vertices[whole.faces][:, :, 2], axis=1) > 0.1)[0]
    shared = np.isin(whole.faces[wall], whole.faces[wall[0]]).sum(axis=1)
    solid = mend(without(whole, *wall[np.argsort(-shared, kind="stable")][:missing].tolist()))
    assert solid.mended == ("1 small hole closed, of a triangle or two",)
    assert volume(solid) == pytest.approx(signed_volume(whole.vertices, whole.faces), rel=1e-3)
    many = [i for i in wall if abs(whole.vertices[whole.faces[i], 0]).max() < 0.02]
    with pytest.raises(InputError, match="not watertight"):
        mend(without(whole, *many[: len(many) // 4]))


def test_seams_are_closed() -> None:
    apart = soup(box())
    vertices = apart.vertices + np.random.default_rng(0).uniform(-2e-6, 2e-6, apart.vertices.shape)
    solid = mend(Triangles(vertices, apart.faces))
    assert not solid.watertight
    assert solid.mended == ("seams closed: 36 edges whose ends did not quite meet",)
    assert volume(solid) == pytest.approx(BOX, rel=1e-3)


def test_a_surface_given_twice_is_a_double_shell() -> None:
    for second in (box(), turned(box())):
        solid = mend(together(box(), second))
        assert not solid.watertight
        assert solid.mended == ("double shell: 12 triangles given twice, taken once",)
        assert volume(solid) == pytest.approx(BOX)


def test_a_shell_in_a_shell_is_a_hollow_whichever_way_it_faces() -> None:
    inner = box(0.038, 0.048, 0.058)
    material = BOX - 0.038 * 0.048 * 0.058
    for given, end in ((turned(inner), "a hollow"), (inner, "turned inward")):
        solid = mend(together(box(), given))
        (said,) = solid.mended
        assert said.startswith("double shell: a surface inside another, 2.9 % of the longest side")
        assert said.endswith(end)
        assert volume(solid) == pytest.approx(material)
        assert [body.cavity for body in solid.bodies] == [False, True]


def test_several_bodies_are_one_thing_each_right_side_out() -> None:
    solid = mend(together(box(), turned(box(0.02, 0.02, 0.02, (0.1, 0, 0)))))
    assert solid.mended == (
        "inside out: 1 of 2 bodies turned",
        "2 bodies taken as one rigid thing",
    )
    assert volume(solid) == pytest.approx(BOX + 0.02**3)
    expected = 0.1 * 0.02**3 / (BOX + 0.02**3)
    np.testing.assert_allclose(centroid(*solid.surface), [expected, 0, 0], atol=1e-9)


def test_bodies_that_share_an_edge_are_told_apart() -> None:
    solid = mend(together(box(0.04, 0.04, 0.04), box(0.04, 0.04, 0.04, (0.04, 0.04, 0))))
    assert len(solid.bodies) == 2
    assert volume(solid) == pytest.approx(2 * 0.04**3)


def test_specks_are_left_out() -> None:
    solid = mend(together(box(), box(1e-4, 1e-4, 1e-4, (0.1, 0, 0))))
    assert solid.mended == ("1 speck left out",)
    assert np.ptp(solid.surface[0], axis=0)[0] == pytest.approx(0.04)


FLAT = Triangles(box().vertices * [1, 1, 0], box().faces)
MANY = together(*(box(0.01, 0.01, 0.01, (0.012 * i, 0, 0)) for i in range(65)))


@pytest.mark.parametrize(
    ("part", "cause"),
    [
        (moebius(), "one side only"),
        (FLAT, "encloses no volume"),
        (MANY, "65 separate bodies, more than 64"),
        (Triangles(np.zeros((3, 3)), np.array([[0, 1, 2]])), "in one place"),
        (Triangles(np.eye(3), np.array([[0, 1, 2]])), "encloses no volume"),
    ],
)
def test_what_cannot_be_mended_is_refused_by_its_cause(part: Triangles, cause: str) -> None:
    with pytest.raises(InputError, match=cause):
        mend(part)


def test_a_point_is_wound_round_once_inside_and_never_outside() -> None:
    part = ball()
    assert winding(part.vertices, part.faces, np.array([0.01, 0, 0])) == pytest.approx(1)
    assert winding(part.vertices, part.faces, np.array([0.05, 0, 0])) == pytest.approx(0, abs=1e-9)
