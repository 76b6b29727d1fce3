"""Coordinates of a model are told apart: the hand's, the object's, and what carries the hand."""

from dataclasses import replace

import mujoco
import numpy as np

from handsim.exports.export_sources import episodes_of
from handsim.grasping.rollout.record import Rollout

SCENE = """
<mujoco>
  <worldbody>
    <body name="object">
      <freejoint name="object_joint"/>
      <geom size=".02"/>
      <body name="lid">
        <joint name="lid" axis="0 1 0"/>
        <geom size=".01" pos=".02 0 0"/>
      </body>
    </body>
    <body name="forearm" pos="0 0 .3">
      <freejoint name="forearm"/>
      <geom size=".02"/>
      <body name="robot_palm">
        <joint name="robot_slide" type="slide" axis="1 0 0"/>
        <geom size=".02" pos=".05 0 0"/>
        <body name="robot_finger">
          <joint name="robot_bend" axis="0 1 0"/>
          <geom size=".01" pos=".1 0 0"/>
        </body>
      </body>
    </body>
  </worldbody>
  <tendon>
    <fixed name="both">
      <joint joint="robot_bend" coef="1"/>
      <joint joint="robot_slide" coef="1"/>
    </fixed>
  </tendon>
  <actuator>
    <general name="robot_pull" tendon="both"/>
    <general name="robot_bends" joint="robot_bend"/>
    <general name="robot_slides" joint="robot_slide"/>
  </actuator>
</mujoco>
"""


def of_robot(like: Rollout) -> Rollout:
    """A record of that model, whose numbers tell where they stand."""
    model = mujoco.MjModel.from_xml_string(SCENE)
    n = len(like.time)
    qpos, qvel, ctrl = (
        np.tile(np.arange(size, dtype=float), (n, 1)) for size in (model.nq, model.nv, model.nu)
    )
    return replace(like, model_xml=SCENE, qpos=qpos, qvel=qvel, ctrl=ctrl)


def test_coordinates_are_told_apart(flying: Rollout) -> None:
    (episode,) = episodes_of(of_robot(flying))
    rows = {q.name: (q.columns, q.units, q.values[0].tolist()) for q in episode.quantities}
    assert rows["joints"] == (("robot_slide", "robot_bend"), ("m", "rad"), [15, 16])
    assert rows["velocities"] == (
        ("robot_slide_velocity", "robot_bend_velocity"), ("m/s", "rad/s"), [13, 14],
    )  # fmt: skip
    assert rows["object_joints"] == (("object_lid",), ("rad",), [7])
    assert rows["object_position"][2] == [0, 1, 2]
    assert rows["object_orientation"][2] == [3, 4, 5, 6]
    assert rows["forearm_position"][2] == [8, 9, 10]
    assert rows["forearm_orientation"][2] == [11, 12, 13, 14]


def test_targets_are_in_the_order_of_the_joints(flying: Rollout) -> None:
    (episode,) = episodes_of(of_robot(flying))
    targets = episode.quantity("targets")
    assert targets is not None
    names = ("robot_slides_target", "robot_bends_target", "robot_pull_target")
    assert (targets.columns, targets.units) == (names, ("m", "rad", ""))
    assert targets.values[0].tolist() == [2, 1, 0]


def test_what_is_commanded_is_called_by_what_it_moves(flying: Rollout, with_arm: Rollout) -> None:
    for rollout, base in ((flying, "forearm"), (with_arm, "palm")):
        (episode,) = episodes_of(rollout)
        target = episode.quantity(f"{base}_target_position")
        assert target is not None
        assert np.array_equal(target.values, rollout.mocap_pos)
