"""Damaged files of robot hands: they work, or are refused in one line, and soon."""

import shutil
import time

from hypothesis import strategies as st

from handsim.errors import HandsimError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.planning.plan_store import shipped_plans
from handsim.grasping.robots import robot_grasper
from handsim.grasping.robots.robot_scene import RobotScene
from handsim.learning.controller import GraspController
from handsim.retargeting.retarget import Retargeter
from handsim.retargeting.robot_hand import RobotHand

from .conftest import SPECIAL, Content, damaged_bytes, search

LONGEST_S = 20.0
"""Of the processor: tests beside this one take their share of the clock."""

FINGER = """<link name="{f}_1"><inertial><mass value="0.02"/><inertia ixx="2e-6" iyy="4e-6"
izz="4e-6" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry>
<mesh filename="package://in/cube.obj" scale="1 1 1"/></geometry></collision></link>
<link name="{f}_2"><collision><origin xyz="0.02 0 0"/>
<geometry><box size="0.04 0.014 0.014"/></geometry></collision></link><link name="{f}_tip"/>
<joint name="{f}_a" type="revolute"><parent link="base"/><child link="{f}_1"/>
<origin xyz="0.09 {y} 0" rpy="0 0 0"/><axis xyz="0 1 0"/>
<limit lower="0" upper="1.5" effort="1" velocity="2"/></joint>
<joint name="{f}_b" type="revolute"><parent link="{f}_1"/><child link="{f}_2"/>
<origin xyz="0.05 0 0"/><axis xyz="0 1 0"/>
<limit lower="0" upper="1.6" effort="1" velocity="2"/>
<mimic joint="{f}_a" multiplier="1.05" offset="0.1"/></joint>
<joint name="{f}_c" type="fixed"><parent link="{f}_2"/><child link="{f}_tip"/>
<origin xyz="0.04 0 0"/></joint>"""
URDF = (
    '<robot name="h"><link name="base"/>'
    + "".join(
        FINGER.format(f=f, y=y) for f, y in (("thumb", 0.05), ("index", 0.02), ("ring", -0.02))
    )
    + "</robot>"
)
MJCF = """<mujoco><compiler angle="radian" meshdir="."/>
<asset><mesh name="c" file="cube.obj"/></asset>
<default><default class="f"><joint axis="0 1 0" range="0 1.6" damping="0.1"/></default></default>
<worldbody><body name="palm" childclass="f"><geom type="box" size=".04 .04 .01"/>
<body name="index" pos=".09 .02 0"><joint name="i1"/><geom type="mesh" mesh="c"/>
<body name="index_2" pos=".05 0 0"><joint name="i2"/><geom type="capsule" fromto="0 0 0 .04 0 0"
size=".007"/><site name="index_tip" pos=".04 0 0"/></body></body>
<body name="thumb" pos=".02 .05 0" euler="0 0 1"><joint name="t1"/><geom type="capsule"
fromto="0 0 0 .04 0 0" size=".007"/></body></body></worldbody>
<tendon><fixed name="t"><joint joint="i1" coef="1"/><joint joint="i2" coef="1"/></fixed></tendon>
<equality><joint joint1="t1" joint2="i1" polycoef="0 0.5 0 0 0"/></equality>
<actuator><position tendon="t" kp="1" ctrlrange="0 3"/></actuator></mujoco>"""
SERVOS = MJCF.replace("<actuator>", '<actuator><position joint="t1" kp="1" ctrlrange="0 1.6"/>')
"""The same with a servo for every coordinate."""
CUBE = "\n".join(
    [f"v {x} {y} {z}" for x in (0, 0.02) for y in (0, 0.02) for z in (0, 0.02)]
    + ["f 1 2 4", "f 1 4 3", "f 5 7 8", "f 5 8 6", "f 1 5 6", "f 1 6 2"]
    + ["f 3 4 8", "f 3 8 7", "f 1 3 7", "f 1 7 5", "f 2 6 8", "f 2 8 4"]
)
TOML = """side = "right"
[palm]
on = "base"
pos = [0.0, 0.0, 0.0]
quat = [1.0, 0.0, 0.0, 0.0]
[fingertips.index]
on = "index_tip"
[knuckles]
index = "index_a"
"""


@st.composite
def damaged_xml(draw: st.DrawFn, original: str) -> Content:
    """A file in which words in quotes are replaced, or elements doubled, dropped or swapped."""
    parts = original.split('"')
    elements = original.split("<")
    if draw(st.booleans()):
        for _ in range(draw(st.integers(1, 3))):
            i = draw(st.integers(0, len(parts) // 2 - 1)) * 2 + 1
            words = [*SPECIAL, *parts[1::2], "../secret.obj", "package://../secret.obj", "1e300"]
            parts[i] = draw(st.sampled_from(words) | st.floats().map(repr))
        return Content('"'.join(parts).encode(errors="surrogatepass"))
    for _ in range(draw(st.integers(1, 3))):
        i, j = (draw(st.integers(1, len(elements) - 1)) for _ in range(2))
        kind = draw(st.sampled_from(["drop", "double", "swap"]))
        if kind == "drop" and len(elements) > 2:
            del elements[i]
        elif kind == "double":
            elements.insert(min(j, len(elements)), elements[min(i, len(elements) - 1)])
        elif max(i, j) < len(elements):
            elements[i], elements[j] = elements[j], elements[i]
    return Content("<".join(elements).encode())


def test_files_of_hands(sandbox):
    outcomes: list[bool] = []

    def check(files: dict[str, bytes]) -> None:
        sandbox.fresh()
        secret = sandbox.root / "secret.obj"
        if not secret.exists():
            secret.write_text(CUBE)
            secret.chmod(0)
        for name, content in files.items():
            (sandbox.inputs / name).write_bytes(content)
        start = time.process_time()
        try:
            robot = RobotHand(sandbox.inputs / next(iter(files)))
            Retargeter(robot)
        except HandsimError as error:
            assert "\n" not in str(error) and str(error)
            outcomes.append(False)
        else:
            outcomes.append(True)
        assert time.process_time() - start < LONGEST_S

    urdf, mjcf, cube = URDF.encode(), MJCF.encode(), CUBE.encode()
    for files in ({"hand.urdf": urdf, "cube.obj": cube}, {"hand.xml": mjcf, "cube.obj": cube}):
        check(files)
    assert outcomes == [True, True]

    def any_of(whole: str) -> st.SearchStrategy:
        return damaged_xml(whole) | damaged_bytes(whole.encode())

    n = sandbox.cases
    search(lambda c: check({"hand.urdf": c, "cube.obj": cube}), any_of(URDF), 45 * n)
    search(lambda c: check({"hand.xml": c, "cube.obj": cube}), any_of(MJCF), 45 * n)
    search(lambda c: check({"hand.urdf": urdf, "cube.obj": c}), damaged_bytes(cube), 5 * n)
    changed = damaged_bytes(TOML.encode())
    search(lambda c: check({"hand.urdf": urdf, "cube.obj": cube, "hand.toml": c}), changed, 5 * n)
    assert False in outcomes and outcomes.count(True) > 2


def test_hands_that_grasp(sandbox, monkeypatch):
    """Damaged hands through the whole command, each with a person's plan in place of a search."""
    built_in = data_folder("assets") / "controller.npz"
    controller = GraspController.load(built_in)
    plan = shipped_plans(controller.digest, Conditions()).read()["cube-raise"]

    def unsearched(grasps, task, conditions, starts, *, progress):
        scene = RobotScene.build(task, conditions, grasps.retargeter.robot)
        told = grasps.told(scene, starts[0])
        return starts[0], grasps.run_told(scene, starts[0], told), told.movement.mapped

    monkeypatch.setattr(robot_grasper.RobotGrasper, "_starts", lambda self, task, base: [plan])
    monkeypatch.setattr(robot_grasper, "plan_robot_grasp", unsearched)

    def check(name: str, content: bytes) -> None:
        sandbox.fresh()
        own = sandbox.inputs / "controller.npz"
        shutil.copy(built_in, own)
        (sandbox.inputs / "cube.obj").write_text(CUBE)
        hand = sandbox.inputs / name
        hand.write_bytes(content)
        start = time.process_time()
        sandbox.run("grasp", own, "--hand", hand, "--task", "cube-raise", "-o",
                    sandbox.outputs / "run", "--json")  # fmt: skip
        assert time.process_time() - start < LONGEST_S

    check("hand.urdf", URDF.encode())
    check("hand.xml", SERVOS.encode())
    assert sandbox.codes == [0, 0]
    n = 6 if sandbox.cases == 1 else 50 * sandbox.cases
    search(lambda content: check("hand.urdf", content), damaged_xml(URDF), n)
    search(lambda content: check("hand.xml", content), damaged_xml(SERVOS), n)
    assert 2 in sandbox.codes and sandbox.codes.count(0) > 2
