"""Markers by their names and by a map."""

from pathlib import Path

import pytest

from handsim.errors import FileError
from handsim.recordings.points.marker_map import (
    read_marker_map,
    roles_by_name,
    roles_of_map,
    side_by_name,
)


@pytest.mark.parametrize(
    ("name", "role"),
    [
        ("hand_top", "palm"), ("thumb_tip", "thumb_tip"), ("thumb_middle", "thumb_middle"),
        ("middle_middle", "middle_middle"), ("middle_tip", "middle_tip"),
        ("index_middle", "index_middle"), ("IndexMCP", "index_mcp"), ("R_ring_pip", "ring_pip"),
        ("right little knuckle", "little_mcp"), ("Subject:pinky_tip", "little_tip"),
        ("right_elbow", "elbow"), ("LeftShoulder", "shoulder"), ("back_left", "torso"),
        ("wrist_radial", "forearm"), ("thumb_ip", "thumb_ip"), ("target_1", "object"),
        ("M17", "ignore"), ("middle finger tip", "middle_tip"), ("head_front", "ignore"),
    ],
)  # fmt: skip
def test_roles_by_likeness_of_names(name: str, role: str) -> None:
    assert roles_by_name([name]).roles == {name: role}


def test_three_of_a_family_are_an_object() -> None:
    roles = roles_by_name(["cup1", "cup2", "cup3", "lamp1", "hand_a"]).roles
    assert [roles[f"cup{i}"] for i in (1, 2, 3)] == ["object"] * 3
    assert roles["lamp1"] == "ignore" and roles["hand_a"] == "palm"
    assert "cup1 as object" in roles_by_name(["cup1", "cup2", "cup3"]).notes[0]


def test_sides_by_names() -> None:
    assert side_by_name(["right_elbow", "RightShoulder"]) == "right"
    assert side_by_name(["L_elbow"]) == "left"
    assert side_by_name(["right_elbow", "left_elbow"]) is None
    assert side_by_name(["elbow", "back_left"]) is None


def test_a_map_says_role_place_side_and_unit(tmp_path: Path) -> None:
    file = tmp_path / "map.toml"
    file.write_text(
        'side = "left"\nunit = "cm"\n[markers]\nA = "palm"\n"B 1" = "object"\n'
        'C = { body = "index_middle", place_mm = [12, 0, 9] }\n'
    )
    said = read_marker_map(file)
    assert (said.side, said.metres_per_unit) == ("left", 0.01)
    roles = roles_of_map(file, said, ["A", "B 1", "C", "D"])
    assert roles.roles == {"A": "palm", "B 1": "object"}
    on_hand = roles.on_hand()
    assert list(on_hand) == ["A", "C"] and on_hand["C"].body == "index_middle"
    assert on_hand["C"].place[0] * 0.1933 == pytest.approx(0.012)  # the median hand
    assert roles.named("object") == ["B 1"]
    with pytest.raises(FileError, match="marker B 1 is not in the recording"):
        roles_of_map(file, said, ["A", "C"])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[markers", "not readable as TOML"),
        ("", "no table"),
        ('colour = "red"\n[markers]\nA = "palm"', "'colour' is not understood"),
        (
            '[markers]\nA = "index_tp"',
            "marker A: unknown role of a marker 'index_tp'; did you mean",
        ),
        ("[markers]\nA = 3", "marker A: give a role"),
        ('[markers]\nA = { body = "index_middle", place_mm = [1, 2] }', "marker A: give a role"),
        ('[markers]\nA = { body = "nose", place_mm = [1, 2, 3] }', "unknown body 'nose'"),
        ('[markers]\nA = { body = "palm", place_mm = [nan, 2, 3] }', "marker A: give a role"),
        ('side = "both"\n[markers]\nA = "palm"', "side = 'both'"),
        ('wrist = 3\n[markers]\nA = "palm"', "wrist = 3"),
        ('unit = "inch"\n[markers]\nA = "palm"', "unit = 'inch'"),
    ],
)
def test_maps_that_are_not_understood(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "map.toml"
    file.write_text(text)
    with pytest.raises(FileError, match=said) as error:
        read_marker_map(file)
    assert "map.toml" in str(error.value) and "\n" not in str(error.value)
