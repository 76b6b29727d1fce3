"""Names of joints by makers, engines, anatomists, Germans and the French."""

import pytest

from handsim.joints import JOINTS
from handsim.recordings.columns.vocabulary import likeness, side_of, turned_around, unit_of

SURE = {
    "ThumbRotate": "thumb_rotation", "ThumbAb": "thumb_abduction", "IndexPIJ": "index_pip",
    "MiddleIndexAb": "index_abduction", "PinkieMPJ": "little_mcp", "PalmArch": "palm_arch",
    "WristYaw": "wrist_deviation", "Index_MCP_Flex": "index_mcp", "MCP5_F": "little_mcp",
    "index_proximal_flexion": "index_mcp", "thumb_cmc_spread": "thumb_abduction",
    "MCP2-3_A": "index_abduction", "CMC5_F": "palm_arch", "IP1_F": "thumb_ip",
    "WRIST_F": "wrist_flexion", "Ring PIP [rad]": "ring_pip", "thumbmpj": "thumb_mcp",
    "index proximal interphalangeal": "index_pip", "Zeigefinger_Endgelenk": "index_dip",
    "Kleiner Finger Abspreizung": "little_abduction", "Handgelenk_Beugung": "wrist_flexion",
    "Annulaire_MCP": "ring_mcp", "RightIndexIntermediate": "index_pip", "f3_pip": None,
}  # fmt: skip


@pytest.mark.parametrize("joint", JOINTS, ids=lambda joint: joint.name)
def test_own_names_and_the_makers_are_known(joint) -> None:
    for name in (joint.name, f"{joint.name}_deg", joint.sensor):
        assert likeness(name) == {joint.name: 1.0}


@pytest.mark.parametrize("name", [name for name in SURE if SURE[name]])
def test_other_names_are_sure(name: str) -> None:
    (joint, score), = likeness(name).items()  # fmt: skip
    assert joint == SURE[name] and score >= 0.8


def test_doubtful_names_score_less() -> None:
    assert likeness("Finger2_Joint1") == {"index_mcp": 0.525}
    assert likeness("Finger2_Joint1", 0) == {"middle_mcp": 0.525}
    assert likeness("Thumb_CMC_Flex") == {"thumb_rotation": 0.7}
    assert likeness("IndexPip_velocity") == {"index_pip": 0.3}
    assert likeness("wrist_x")["wrist_flexion"] < 0.2
    assert likeness("MiddleAb") == {"index_abduction": 0.5}
    assert likeness("emg_01") == likeness("") == likeness("sensor7") == {}


def test_units_sides_and_signs() -> None:
    assert [unit_of(name) for name in ("a_deg", "a [rad]", "a (°)", "a", "raw_a", "a raw")] == [
        "deg", "rad", "deg", None, None, "counts"
    ]  # fmt: skip
    assert unit_of("a", "[Grad]") == "deg"
    assert [side_of(n) for n in ("LeftIndex", "index_r", "RH_index", "index")] == [
        "left", "right", "right", None
    ]  # fmt: skip
    assert turned_around("wrist_extension") and not turned_around("flexion/extension")
