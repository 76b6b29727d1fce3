"""The scene of a task, compiled, and where its parts are."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import mujoco
import numpy as np

from handsim.grasping.conditions import Conditions
from handsim.grasping.rollout.sensing import add_senses
from handsim.hand.model import HandModel
from handsim.objects.mjcf import read_mesh
from handsim.objects.object import GraspObject
from handsim.tasks.scene import build_scene
from handsim.tasks.task import Task
from handsim.types import Array


@dataclass(frozen=True, eq=False)
class Scene:
    """A compiled scene and where its parts are, to be simulated in many times over.

    As its state changes while it is simulated, it is equal to itself alone.

    Attributes
    ----------
    task
        For the right or left hand that is in the scene.
    conditions
        What the scene was built with.
    hand
        The scene's model and data; its last sensors are those of `add_senses`.
    xml
        Gives the model as text, with the hand's own sensors. It takes as long as compiling and
        few ask for it, so that it is made when it is wanted.
    mocap
        Row of the forearm's target.
    object
        What is grasped.
    front : (3,) [m]
        Its front end in its own frame.
    lead : (22,) [s]
        Damping over stiffness of the actuators.
    """

    task: Task
    conditions: Conditions
    hand: HandModel
    xml: Callable[[], str]
    mocap: int
    object: GraspObject
    front: Array
    lead: Array

    @classmethod
    def build(cls, task: Task, conditions: Conditions) -> "Scene":
        """Build the scene of a task under the given conditions."""
        spec = _scene(task, conditions)
        add_senses(spec)
        hand = HandModel.from_spec(spec)
        model = hand.model
        index = hand.ctrl_index
        stiffness = model.actuator_gainprm[index, 0]
        damping = -model.actuator_biasprm[index, 2]
        grasp_object = task.object
        return cls(
            task=task.for_side(conditions.hand.side),
            conditions=conditions,
            hand=hand,
            xml=partial(_xml, task, conditions),
            mocap=int(model.body("forearm_target").mocapid[0]),
            object=grasp_object,
            front=_front_end(grasp_object),
            lead=damping / stiffness,
        )


def _xml(task: Task, conditions: Conditions) -> str:
    spec = _scene(task, conditions)
    spec.compile()
    return spec.to_xml()


def _scene(task: Task, conditions: Conditions) -> mujoco.MjSpec:
    dx, dy, yaw = conditions.object_offset
    return build_scene(
        task,
        conditions.hand,
        friction=conditions.friction,
        mass_scale=conditions.mass_scale,
        offset=(dx, dy),
        turn=yaw,
    )


def _front_end(grasp_object: GraspObject) -> Array:
    """Return the middle of what lies farthest along the object's x, (3,) [m]."""
    meshes = (read_mesh(p.mesh) if isinstance(p.mesh, str) else p.mesh for p in grasp_object.pieces)
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    return vertices[vertices[:, 0] > vertices[:, 0].max() - 1e-5].mean(axis=0)
