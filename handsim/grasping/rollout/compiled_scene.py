"""The compiled scene of a task, and where its parts are in MuJoCo's arrays."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import mujoco
import numpy as np

from handsim.arm.arm_joints import ARM_JOINT_NAMES
from handsim.arm.reaching_arm import ReachingArm
from handsim.grasping.conditions import Conditions
from handsim.grasping.rollout.sensing import add_sensors
from handsim.hand.model import HandModel
from handsim.objects.mjcf import surface_of
from handsim.objects.object import GraspObject
from handsim.tasks.scene import build_scene
from handsim.tasks.task import Task
from handsim.types import Array, Index


@dataclass(frozen=True, eq=False)
class Scene:
    """A compiled scene in which any number of runs can be made, one after the other.

    A scene is equal to itself alone, since its state changes with every run.

    Attributes
    ----------
    task
        For the right or left hand that is in the scene.
    conditions
        The conditions that the scene was built for.
    hand
        The scene's model and data; its last sensors are those of `add_sensors`.
    xml
        Returns the model as XML, without the sensors of `add_sensors`. This takes as long as
        compiling, so that it is done on demand.
    mocap
        Row of the forearm's target in MuJoCo's mocap arrays; None where an arm carries the hand.
    arm, arm_qpos, arm_ctrl
        The arm, and where its joints and actuators are in MuJoCo's arrays; None and empty without.
    object
        The object to grasp.
    front : (3,) [m]
        Front end of the object in its own frame.
    lead : (22,) [s]
        Ratio of damping to stiffness of the actuators.
    """

    task: Task
    conditions: Conditions
    hand: HandModel
    xml: Callable[[], str]
    mocap: int | None
    arm: ReachingArm | None
    arm_qpos: Index
    arm_ctrl: Index
    object: GraspObject
    front: Array
    lead: Array

    @property
    def model(self) -> mujoco.MjModel:
        """The compiled model."""
        return self.hand.model

    @classmethod
    def build(cls, task: Task, conditions: Conditions) -> "Scene":
        """Build the scene of a task under the given conditions."""
        spec = _scene(task, conditions)
        xml = partial(_xml, task, conditions)
        task = task.for_side(conditions.hand.side)
        add_sensors(spec, task.rule.pressed)
        hand = HandModel.from_spec(spec)
        model = hand.model
        grasp_object = task.object
        on_arm = conditions.base == "arm"
        names = ARM_JOINT_NAMES if on_arm else ()
        return cls(
            task=task,
            conditions=conditions,
            hand=hand,
            xml=xml,
            mocap=None if on_arm else int(model.body("forearm_target").mocapid[0]),
            arm=ReachingArm(conditions.hand) if on_arm else None,
            arm_qpos=np.array([model.joint(name).qposadr[0] for name in names], dtype=np.intp),
            arm_ctrl=np.array([model.actuator(name).id for name in names], dtype=np.intp),
            object=grasp_object,
            front=front_end(grasp_object),
            lead=servo_lead(model, hand.ctrl_index),
        )


def servo_lead(model: mujoco.MjModel, actuators: Index) -> Array:
    """Return the ratios of damping to stiffness of position actuators (n,) [s]."""
    return -model.actuator_biasprm[actuators, 2] / model.actuator_gainprm[actuators, 0]


def _xml(task: Task, conditions: Conditions) -> str:
    spec = _scene(task, conditions)
    spec.compile()
    return spec.to_xml()


def _scene(task: Task, conditions: Conditions) -> mujoco.MjSpec:
    dx, dy, yaw = conditions.object_offset
    return build_scene(
        task,
        conditions.hand,
        base=conditions.base,
        friction=conditions.friction,
        mass_scale=conditions.mass_scale,
        offset=(dx, dy),
        turn=yaw,
    )


def front_end(grasp_object: GraspObject) -> Array:
    """Return the mean of the vertices that lie farthest along the object's x axis, (3,) [m]."""
    vertices = np.concatenate([surface_of(piece).vertices for piece in grasp_object.pieces])
    return vertices[vertices[:, 0] > vertices[:, 0].max() - 1e-5].mean(axis=0)
