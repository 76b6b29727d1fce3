"""Models alone and together: as in MuJoCo's Menagerie, each file loads as it is."""

from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

from handsim.arm.arm_joints import ARM_JOINT_NAMES
from handsim.files import data_folder
from handsim.hand.export import write_hand
from handsim.hand.postures import POSTURES
from handsim.joints import JOINT_NAMES
from handsim.types import SIDES, HandSize

FOLDERS = {kind: data_folder("models") / kind for kind in ("hand", "arm")}
LOADED = [
    path
    for folder in FOLDERS.values()
    for path in sorted(folder.glob("*.xml"))
    if not path.name.startswith("keyframes_")
]


@pytest.mark.parametrize("path", LOADED, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_each_file_loads_as_it_is_and_has_the_options_that_were_tried(path: Path) -> None:
    model = mujoco.MjModel.from_xml_path(str(path))
    option = model.opt
    assert (option.timestep, option.impratio, option.noslip_iterations) == (0.002, 10, 2)
    assert option.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert (model.nkey > 0) == path.stem.startswith("scene_")


def test_there_is_a_scene_of_either_side_and_of_both() -> None:
    for folder in FOLDERS.values():
        found = {path.stem for path in folder.glob("scene_*.xml")}
        assert found == {f"scene_{which}" for which in (*SIDES, "both")}


@pytest.mark.parametrize("kind", FOLDERS)
@pytest.mark.parametrize("side", SIDES)
def test_default_classes_are_named_after_the_side(kind, side) -> None:
    tree = ElementTree.parse(FOLDERS[kind] / f"{side}_{kind}.xml")
    names = [each.get("class") for each in tree.iterfind(".//default[@class]")]
    named = [name for name in names if name != "main"]
    assert f"{side}_{kind}" in named
    assert len(named) > 5
    assert all(name.startswith((f"{side}_hand", f"{side}_{kind}")) for name in named)
    unnamed = tree.find("./default")
    assert [child.tag for child in unnamed] == ["default"] * len(unnamed), "scenes keep their own"


@pytest.mark.parametrize("kind", FOLDERS)
def test_both_sides_of_a_scene_are_either_model_with_its_keyframes(kind) -> None:
    both = mujoco.MjModel.from_xml_path(str(FOLDERS[kind] / "scene_both.xml"))
    names = ((*ARM_JOINT_NAMES, *JOINT_NAMES) if kind == "arm" else JOINT_NAMES,) * 2
    expected = [f"{side}_{name}" for side, each in zip(SIDES, names, strict=True) for name in each]
    assert [both.actuator(i).name for i in range(both.nu)] == expected
    for side in SIDES:
        alone = mujoco.MjModel.from_xml_path(str(FOLDERS[kind] / f"{side}_{kind}.xml"))
        for i in range(alone.nu):
            one, other = alone.actuator(i), both.actuator(f"{side}_{alone.actuator(i).name}")
            assert other.gainprm == pytest.approx(one.gainprm)
        for i in range(alone.njnt):
            one, other = alone.joint(i), both.joint(f"{side}_{alone.joint(i).name}")
            assert other.range == pytest.approx(one.range)
            assert other.armature == pytest.approx(one.armature)
        for i in range(1, alone.nbody):
            if alone.body(i).name != "trunk":
                assert both.body(f"{side}_{alone.body(i).name}").mass == alone.body(i).mass


def test_keyframes_of_both_hands_are_one_posture_of_either() -> None:
    both = mujoco.MjModel.from_xml_path(str(FOLDERS["hand"] / "scene_both.xml"))
    data = mujoco.MjData(both)
    for name, q in POSTURES.items():
        mujoco.mj_resetDataKeyframe(both, data, both.key(name).id)
        for side in SIDES:
            at = [both.joint(f"{side}_{joint}").qposadr[0] for joint in JOINT_NAMES]
            assert data.qpos[at] == pytest.approx(q, abs=1e-5)
    mujoco.mj_resetDataKeyframe(both, data, both.key("flat").id)
    mujoco.mj_forward(both, data)
    right, left = (data.body(f"{side}_palm").xpos for side in SIDES)
    assert right == pytest.approx(left * [1, -1, 1])
    assert right[1] < 0 < left[1], "a person's hands, seen from behind"
    tips = [data.site(f"{side}_thumb_tip").xpos[1] for side in SIDES]
    assert right[1] < tips[0] < tips[1] < left[1], "thumbs inside"


def test_hands_of_other_sizes_lie_side_by_side(tmp_path) -> None:
    """Keyframes are drawn back from where a hand of that size would cross itself."""
    write_hand(HandSize(), tmp_path)
    before = (tmp_path / "keyframes_right.xml").read_bytes()
    write_hand(HandSize(0.16, 0.072, "left"), tmp_path)
    assert (tmp_path / "keyframes_right.xml").read_bytes() == before
    for side in SIDES:
        model = mujoco.MjModel.from_xml_path(str(tmp_path / f"scene_{side}.xml"))
        assert model.nkey == 11
        assert np.abs(model.key("fist").qpos).max() > 1
