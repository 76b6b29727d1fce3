from dataclasses import replace

import mujoco
import numpy as np
import pytest

from handsim.errors import FileError
from handsim.files import data_folder
from handsim.hand.eigengrasps import DEEPEST, EXTENT, eigengrasp_postures, read_eigengrasps
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.hand.population import PRESETS
from handsim.joints import JOINT_INDEX, JOINT_NAMES, LOWER, UPPER
from handsim.types import HandSize

TABLE = data_folder("models") / "hand" / "eigengrasps.csv"
INDEX = JOINT_INDEX["index_mcp"]


@pytest.fixture
def one_joint(tmp_path):
    """A table in which only index_mcp moves: 30 deg and deviations of 20, 4 and 1 deg."""
    file = tmp_path / "table.csv"
    rows = [",".join(("name", *(f"{joint}_deg" for joint in JOINT_NAMES)))]
    for name, angle in (("mean", 30), ("eigengrasp_1", 40), ("eigengrasp_2", 4)):
        q = np.zeros(22)
        q[INDEX] = angle
        rows.append(",".join((name, *map(str, q))))
    file.write_text("\n".join(rows) + "\n")
    return file


def test_two_standard_deviations_to_either_side_within_the_ranges(one_joint):
    postures = eigengrasp_postures(lambda q: 0.0, one_joint)
    ends = {name: np.rad2deg(q[INDEX]) for name, q in postures.items()}
    assert ends == {
        "eigengrasp_1_plus": pytest.approx(90),  # 30 + 80 is beyond the range
        "eigengrasp_1_minus": pytest.approx(-20),
        "eigengrasp_2_plus": pytest.approx(38),
        "eigengrasp_2_minus": pytest.approx(22),
    }


def test_drawn_back_to_the_mean_until_the_hand_is_hardly_in_itself(one_joint):
    """It penetrates in proportion to flexion, by the limit at 34 deg."""
    postures = eigengrasp_postures(lambda q: DEEPEST * np.rad2deg(q[INDEX]) / 34, one_joint)
    ends = {name: np.rad2deg(q[INDEX]) for name, q in postures.items()}
    assert 33 < ends["eigengrasp_1_plus"] < 34
    assert 33.8 < ends["eigengrasp_2_plus"] < 34
    assert ends["eigengrasp_2_minus"] == pytest.approx(22), "that side is not"


def test_mean_is_left_where_nothing_helps(one_joint):
    postures = eigengrasp_postures(lambda q: 1.0, one_joint)
    assert all(np.rad2deg(q[INDEX]) == pytest.approx(30) for q in postures.values())


@pytest.mark.parametrize("preset", PRESETS)
@pytest.mark.parametrize("side", ["right", "left"])
def test_eigengrasps_do_not_cross_themselves(preset, side):
    hand = HandModel.from_spec(build_hand(replace(PRESETS[preset], side=side)))
    mean, deviations = read_eigengrasps(TABLE)
    postures = eigengrasp_postures(hand.penetration)
    assert len(postures) == 2 * len(deviations) == 6
    for name, q in postures.items():
        assert hand.penetration(q) < 0.002
        assert np.all((q >= LOWER) & (q <= UPPER))
        offset = deviations[name.rsplit("_", 1)[0]] * (EXTENT if "plus" in name else -EXTENT)
        reached = (q - mean) @ offset / (offset @ offset)
        assert 0.3 < reached < 1.001, "it is still an eigengrasp"


@pytest.mark.parametrize("side", ["right", "left"])
def test_eigengrasps_are_keyframes_of_the_committed_models(side):
    model = mujoco.MjModel.from_xml_path(str(TABLE.parent / f"scene_{side}.xml"))
    hand = HandModel.from_spec(build_hand(HandSize(side=side)))
    postures = eigengrasp_postures(hand.penetration)
    assert len(postures) == 6
    for name, q in postures.items():
        assert np.allclose(model.key(name).qpos[hand.qpos_index], q, atol=1e-5)
        assert np.allclose(model.key(name).ctrl, q, atol=1e-5)


def test_penetration_is_that_of_the_posture_given():
    hand = HandModel.from_spec(build_hand())
    assert hand.penetration(np.zeros(22)) == 0.0
    crossed = np.zeros(22)
    crossed[JOINT_INDEX["index_abduction"]] = LOWER[JOINT_INDEX["index_abduction"]]
    assert hand.penetration(crossed) > 0.002
    assert np.array_equal(hand.q, crossed)


def test_another_table_is_an_error_that_names_the_remedy(tmp_path):
    with pytest.raises(FileError, match=r"python models/hand/make\.py"):
        read_eigengrasps(tmp_path / "none.csv")
    for content in ("name\nmean\n", TABLE.read_text().replace("mean", "average"), "", "a,b\n1,x\n"):
        (tmp_path / "table.csv").write_text(content)
        with pytest.raises(FileError, match=r"table\.csv: not a table"):
            read_eigengrasps(tmp_path / "table.csv")
