"""Hands as users bring them are read with their own links, from the user's folders alone."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from handsim.errors import FileError, InputError
from handsim.robot_hands.reading.hand_file import read_hand_file

from .hands import BAD, five_fingers, urdf

CUBE = "\n".join(
    [f"v {x} {y} {z}" for x in (0, 0.02) for y in (0, 0.02) for z in (0, 0.02)]
    + ["f 1 2 4", "f 1 4 3", "f 5 7 8", "f 5 8 6", "f 1 5 6", "f 1 6 2"]
    + ["f 3 4 8", "f 3 8 7", "f 1 3 7", "f 1 7 5", "f 2 6 8", "f 2 8 4"]
)
MESH = '<visual><geometry><mesh filename="{}"/></geometry></visual>'


def written(folder: Path, text: str, name: str = "hand.urdf") -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    path.write_text(text)
    return path


def bodies(model: mujoco.MjModel) -> set[str]:
    return {model.body(i).name for i in range(model.nbody)}


def test_links_that_are_fixed_keep_their_names(tmp_path):
    file = read_hand_file(written(tmp_path, urdf(five_fingers())))
    model = file.spec.compile()
    assert {"base", "index_tip", "thumb_tip", "pinky_distal"} <= bodies(model)
    assert file.speeds["index_1"] == 2.0
    assert model.njnt == 3 + 4 * 2


def test_a_hand_without_actuators_gets_servos_for_what_moves_by_itself(tmp_path):
    file = read_hand_file(written(tmp_path, urdf(five_fingers())))
    model = file.spec.compile()
    names = {model.actuator(i).name for i in range(model.nu)}
    assert names == {"thumb_yaw", "thumb_1", "index_1", "middle_1", "ring_1", "pinky_1"}
    assert any("6 position servos were added" in note for note in file.notes)
    assert model.actuator("index_1").ctrlrange == pytest.approx([0, 1.5])


def test_what_has_no_name_is_given_one_that_is_not_taken(tmp_path):
    text = """<mujoco><worldbody><body name="palm"><geom size=".02"/>
    <body name="body 0"><joint name="joint 1"/><geom size=".01"/>
    <body pos=".1 0 0"><joint/><geom size=".01"/></body></body></body></worldbody>
    <actuator><position joint="joint 1"/><motor name="two" joint="joint 1"/></actuator></mujoco>"""
    model = read_hand_file(written(tmp_path, text, "hand.xml")).model
    assert bodies(model) == {"world", "palm", "body 0", "body 3"}
    assert [model.joint(i).name for i in range(2)] == ["joint 1", "joint 2"]
    assert [model.actuator(i).name for i in range(2)] == ["actuator 0", "two"]


def test_an_inertia_that_no_body_has_is_balanced_with_a_note(tmp_path):
    file = read_hand_file(written(tmp_path, urdf(five_fingers(), inertia=BAD)))
    assert any("A + B >= C" in note and "'base'" in note for note in file.notes)
    a, b, c = np.sort(file.spec.compile().body("index_proximal").inertia)
    assert a + b >= c * (1 - 1e-9)
    negative = BAD.replace('ixx="0.0001"', 'ixx="-1"')
    file = read_hand_file(written(tmp_path, urdf(five_fingers(), inertia=negative)))
    assert any("not positive" in note for note in file.notes)
    whole = read_hand_file(written(tmp_path, urdf(five_fingers())))
    assert not any("inertia" in note for note in whole.notes)


def test_packages_are_found_above_the_file_or_in_folders_given(tmp_path):
    text = urdf(five_fingers(), visual=MESH.format("package://my_hand/meshes/cube.obj"))
    for name, folders in (("my_hand", ()), ("elsewhere", (tmp_path / "share",))):
        written(tmp_path / (name if not folders else "share/my_hand") / "meshes", CUBE, "cube.obj")
        path = written(tmp_path / name / "urdf", text)
        file = read_hand_file(path, folders)
        assert not file.placeholders
        model = file.spec.compile()
        assert model.nmesh >= 1 and model.mesh_vertnum.max() == 8
    alone = read_hand_file(written(tmp_path / "alone", text.replace("my_hand", "their_hand")))
    assert any("1 mesh is left out" in note and "not found" in note for note in alone.notes)


def test_missing_and_broken_meshes_are_left_out_with_a_note(tmp_path):
    for content in (None, b"", b"no mesh", CUBE.encode()[:40]):
        if content is not None:
            (tmp_path / "cube.obj").write_bytes(content)
        text = urdf(five_fingers(), visual=MESH.format("cube.obj"))
        file = read_hand_file(written(tmp_path, text))
        assert file.placeholders and any("left out" in note for note in file.notes)
        assert "index_tip" in bodies(file.spec.compile())


@pytest.mark.parametrize(
    "reference",
    ["../secret.obj", "{}/secret.obj", "file://{}/secret.obj", "package://../secret.obj",
     "package://in/../../secret.obj", "link.obj", "a/../../secret.obj"],
)  # fmt: skip
def test_no_file_outside_the_folders_is_read(tmp_path, reference):
    written(tmp_path, CUBE, "secret.obj").chmod(0)
    inside = tmp_path / "in"
    inside.mkdir()
    (inside / "link.obj").symlink_to(tmp_path / "secret.obj")
    text = urdf(five_fingers(), visual=MESH.format(reference.format(tmp_path)))
    file = read_hand_file(written(inside, text))
    assert file.placeholders, "it is not there for this hand"
    include = f'<mujoco><include file="{reference.format(tmp_path)}"/></mujoco>'
    with pytest.raises(FileError, match="not in its folder"):
        read_hand_file(written(inside, include, "hand.xml"))


def test_an_mjcf_is_read_whatever_its_suffix_with_its_parts(tmp_path):
    part = (
        '<mujoco><body name="a"><geom size=".01"/><body name="b" pos=".1 0 0"><joint name="j"/>'
        '<geom type="mesh" mesh="cube"/></body></body></mujoco>'
    )
    whole = (
        '<mujoco><compiler meshdir="assets"/><asset><mesh file="cube.obj"/><texture name="t" '
        'type="2d" file="no.png"/><material name="m" texture="t"/></asset><worldbody>'
        '<include file="part.xml"/></worldbody></mujoco>'
    )
    written(tmp_path, part, "part.xml")
    written(tmp_path / "assets", CUBE, "cube.obj")
    model = read_hand_file(written(tmp_path, whole, "hand.mjcf")).spec.compile()
    assert {"a", "b"} <= bodies(model) and model.mesh("cube").vertnum == 8


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<robot name='a'><link name='${side}_base'/></robot>", "xacro"),
        (
            "<robot xmlns:xacro='http://www.ros.org/wiki/xacro'><xacro:include file='b'/></robot>",
            "xacro",
        ),
        ("<robot name='a'><link name='b'/><link name='b'/></robot>", "share a name"),
        ("<sdf/>", "its root is <sdf>"),
        ("no xml", "no XML"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><robot/>", "DOCTYPE"),
        ("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>", "nothing in it moves"),
        (
            "<mujoco><worldbody><body><joint/><geom size='1'/><geom size='1e-300'/></body>"
            "</worldbody></mujoco>",
            "a shape of 1e-300 m, smaller than 1e-09",
        ),
        ("<mujoco><worldbody><body><joint range='0 nan'/></body></worldbody></mujoco>", "finite"),
        ("<mujoco><worldbody><replicate count='999999'/></worldbody></mujoco>", "replicate"),
        ("<mujoco><asset><hfield file='/etc/passwd'/></asset></mujoco>", "hfield"),
        ("<mujoco><asset><model file='/etc/passwd'/></asset></mujoco>", "only meshes"),
        ("<mujoco><include file='hand.urdf'/></mujoco>", "more than once"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_line(tmp_path, text, said):
    with pytest.raises(FileError, match=said) as error:
        read_hand_file(written(tmp_path, text))
    assert "\n" not in str(error.value)


def test_joints_of_a_urdf_that_cannot_be_are_named(tmp_path):
    joints = five_fingers()
    stray = replace(joints[1], mimic=("nobody", 1.0, 0.0))
    with pytest.raises(FileError, match="'nobody', which is no other joint"):
        read_hand_file(written(tmp_path, urdf([joints[0], stray, *joints[2:]])))
    lost = replace(joints[1], parent="nowhere")
    with pytest.raises(FileError, match="'nowhere', which is none"):
        read_hand_file(written(tmp_path, urdf([joints[0], lost, *joints[2:]])))
    with pytest.raises(InputError, match="no such folder"):
        read_hand_file(written(tmp_path, urdf(joints)), [tmp_path / "none"])


FINGER = """
<mujoco>
  <compiler angle="radian" {compiler}/>
  <option timestep="0.002" {option}/>
  {more}
  <worldbody><body name="palm"><geom size="0.01"/>
    <body name="tip" pos="0.05 0 0"><joint name="bend" axis="0 1 0" range="0 1.5" {joint}/>
    <geom size="0.01"/></body></body></worldbody>
</mujoco>"""


def mjcf(folder: Path, **parts: str) -> Path:
    all_parts = dict.fromkeys(("compiler", "option", "more", "joint"), "") | parts
    return written(folder, FINGER.format(**all_parts), "hand.xml")


def test_settings_of_other_versions_of_mujoco_are_left_out_and_said(tmp_path):
    path = mjcf(tmp_path, option='apirate="200" collision="all"', compiler='convexhull="true"')
    file = read_hand_file(path)
    assert file.model.opt.timestep == 0.002 and file.model.njnt == 1
    assert file.notes[-1] == (
        "settings of another version of MuJoCo are left out: apirate, collision, convexhull"
    )


def test_what_is_said_of_the_hand_and_not_understood_is_refused(tmp_path):
    with pytest.raises(FileError, match="unrecognized attribute: 'rnage' Element 'joint'"):
        read_hand_file(mjcf(tmp_path, joint='rnage="0 1"'))


def test_what_other_programs_are_told_is_left_out(tmp_path):
    more = (
        '<custom><numeric name="n" data="1 2"/></custom><asset><texture type="skybox" '
        'builtin="gradient" rgb1="0 1 0" width="8" height="8"/></asset>'
    )
    file = read_hand_file(mjcf(tmp_path, joint='user="3"', more=more))
    model = file.model
    assert (model.nuser_jnt, model.nnumeric, model.ntex) == (0, 0, 0)
    assert not any(word in file.spec.to_xml() for word in ("<size", "user=", "numeric"))


BOUND = """
<mujoco>
  <worldbody><body name="palm"><geom size="0.01"/>
    <body pos="0.05 0 0"><joint name="first" axis="0 1 0" ref="20"/><geom size="0.01"/>
      <body pos="0.05 0 0"><joint name="second" axis="0 1 0"/><geom size="0.01"/>
  </body></body></body></worldbody>
  <tendon>
    <fixed name="t"><joint joint="second" coef="0.02"/><joint joint="first" coef="-0.01"/></fixed>
    <fixed name="u"><joint joint="second" coef="1"/></fixed>
  </tendon>
  <equality><tendon name="e" tendon1="t" {with_} polycoef="0.004 1 0 0 0"/></equality>
  <actuator><position joint="{moved}" kp="1"/></actuator>
</mujoco>"""


@pytest.mark.parametrize("moved", ["first", "second"])
def test_joints_whose_tendon_keeps_its_length_follow_each_other(tmp_path, moved):
    path = written(tmp_path, BOUND.format(moved=moved, with_=""), "hand.xml")
    model = read_hand_file(path).model
    as_given = mujoco.MjModel.from_xml_string(BOUND.format(moved=moved, with_=""))
    assert model.eq_type[0] == mujoco.mjtEq.mjEQ_JOINT.value
    assert model.joint(int(model.eq_obj2id[0])).name == moved, "what has an actuator leads"
    at = []
    for each in (model, as_given):
        data = mujoco.MjData(each)
        data.qpos += [0.5, 0.3]
        mujoco.mj_forward(each, data)
        at.append(data.efc_pos[0] / data.efc_J.ravel()[1])  # by how much the second joint is off
    assert at[0] == pytest.approx(at[1], rel=1e-6)


def test_two_tendons_that_are_held_together_are_left_as_they_are(tmp_path):
    text = BOUND.format(moved="first", with_='tendon2="u"')
    model = read_hand_file(written(tmp_path, text, "hand.xml")).model
    assert model.eq_type[0] == mujoco.mjtEq.mjEQ_TENDON.value
