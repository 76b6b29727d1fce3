"""Table, object and a robot hand on its base, with the names and sensors of a person's scene."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property, partial

import mujoco
import numpy as np

from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import Pose
from handsim.grasping.robots.robot_mount import NAMES, add_mount
from handsim.grasping.rollout.compiled_scene import front_end
from handsim.grasping.rollout.sensing import Sensors, add_sensors
from handsim.hand.mjcf import give_skin, weld_to_mocap
from handsim.joints import FINGERS, Finger
from handsim.objects.object import GraspObject
from handsim.retargeting.robot_hand import RobotHand
from handsim.robot_hands.mounting import mount_robot_hand
from handsim.silence import quiet_compile, unheard_warnings
from handsim.tasks.scene import build_scene, set_hand_friction
from handsim.tasks.task import Task
from handsim.types import Array, Index

PREFIX = "robot_"
"""Put before all names of the robot hand."""


@dataclass(frozen=True, eq=False)
class RobotScene:
    """A compiled scene in which a robot hand grasps.

    Its bodies are called as a person's: ``forearm`` is its base, ``palm`` the frame of the
    robot's palm, and the bodies of fingers begin with the finger's name, so that sensors and rules
    are the same.

    Attributes
    ----------
    task, conditions
        The task, mirrored for the robot's side, and the conditions.
    robot
        The hand.
    model, data
        The compiled model and one state of it.
    xml
        Returns the model as XML, meshes included.
    qpos_index, ctrl_index : (m,), (n_actuators,)
        Where the robot's free coordinates and its actuators are in ``qpos`` and ``ctrl``.
    joint_index : (n_joints,)
        Where all its joints are in ``qpos``.
    mount_ctrl : (6,)
        Where the servos of a mount are in ``ctrl``; (0,) for a free base.
    object
        The object to grasp.
    front : (3,) [m]
        Front end of the object in its own frame.
    fingers : (m,)
        Which finger each coordinate moves, as an index of `FINGERS`; -1 for the palm's.
    """

    task: Task
    conditions: Conditions
    robot: RobotHand
    model: mujoco.MjModel
    data: mujoco.MjData
    xml: Callable[[], str]
    qpos_index: Index
    joint_index: Index
    ctrl_index: Index
    mount_ctrl: Index
    object: GraspObject
    front: Array
    fingers: Index

    @cached_property
    def sensors(self) -> Sensors:
        """What the sensors of the model say, and where."""
        return Sensors(self.model)

    @property
    def gripping(self) -> list[Finger]:
        """The fingers that hold, beside the thumb: the grasp's, or all if it has none of them."""
        own: list[Finger] = [finger for finger in self.robot.fingers if finger != "thumb"]
        return [finger for finger in own if finger in self.task.grasp.fingers] or own

    @classmethod
    def build(cls, task: Task, conditions: Conditions, robot: RobotHand) -> "RobotScene":
        """Build the scene of a task, given for a right hand, with a robot hand.

        Raises
        ------
        InputError
            If an actuator of the hand is no position servo.
        """
        unknown = np.isnan(robot.commands(robot.reference))
        if unknown.any():
            names = [robot.actuator_names[i] for i in np.flatnonzero(unknown)]
            more = f" and {len(names) - 1} more" if len(names) > 1 else ""
            raise InputError(
                f"no position servo: actuator '{names[0]}'{more}; give the hand with <position> "
                "actuators, or without any, which adds them"
            )
        mirrored = task.for_side(robot.side)
        grasp_object = mirrored.object
        spec = robot_scene_spec(task, conditions, robot)
        add_sensors(spec, mirrored.rule.pressed)
        model = quiet_compile(spec)
        joints = [model.joint(PREFIX + name).qposadr[0] for name in robot.joint_names]
        index = np.array(joints, dtype=np.intp)
        return cls(
            mirrored,
            conditions,
            robot,
            model,
            mujoco.MjData(model),
            partial(_xml, task, conditions, robot),
            index[robot.joint_map.free],
            index,
            _actuators(model, PREFIX, robot.actuator_names),
            _actuators(model, "", NAMES if conditions.base == "mounted" else ()),
            grasp_object,
            front_end(grasp_object),
            robot.finger_of_coordinates(),
        )

    def pose(self, palm: Pose, x: Array) -> None:
        """Put the robot's palm at a pose in the world and its coordinates at x (m,), at rest.

        Everything else is put back to where the model has it; servos and base are to stay there.
        """
        model, data = self.model, self.data
        mujoco.mj_resetData(model, data)
        data.qpos[self.joint_index] = self.robot.joint_positions(x)
        data.ctrl[self.ctrl_index] = self.robot.commands(x)
        free = int(model.joint("forearm").qposadr[0])
        data.qpos[free : free + 3], data.qpos[free + 3 : free + 7] = palm.pos, palm.quat
        data.mocap_pos[0], data.mocap_quat[0] = palm.pos, palm.quat
        mujoco.mj_forward(model, data)


def robot_scene_spec(task: Task, conditions: Conditions, robot: RobotHand) -> mujoco.MjSpec:
    """Build table, object and a robot hand on a base that follows ``forearm_target``.

    The robot's skin is given the friction and softness of the own hand's: files of hands seldom say
    what theirs is, and the trials vary it. The weight of the hand's own links is compensated, as
    the controllers of such hands do. A base that is not mounted moves with unlimited force.

    Parameters
    ----------
    task
        For a right hand.
    conditions
    robot
    """
    dx, dy, yaw = conditions.object_offset
    mirrored = task.for_side(robot.side)
    spec = build_scene(mirrored, None, mass_scale=conditions.mass_scale, offset=(dx, dy), turn=yaw)
    base = _add_base(spec, welded=conditions.base != "mounted")
    mount_robot_hand(spec, _bare(robot.spec), robot.frames.palm, body="palm", prefix=PREFIX)
    _name_fingers(spec, robot)
    for finger in FINGERS:
        if finger not in robot.fingers:  # a body of nothing, which never touches anything
            spec.body("palm").add_body(name=f"{finger}_missing")
    for body in base.find_all(mujoco.mjtObj.mjOBJ_BODY):
        body.gravcomp = 1.0
    for geom in base.find_all(mujoco.mjtObj.mjOBJ_GEOM):
        give_skin(geom)
    set_hand_friction(spec, conditions.friction)
    if conditions.base == "mounted":
        add_mount(spec, robot.model)
    return spec


def _actuators(model: mujoco.MjModel, prefix: str, names: Iterable[str]) -> Index:
    """Return where actuators are in ``ctrl``."""
    return np.array([model.actuator(prefix + name).id for name in names], dtype=np.intp)


def _add_base(spec: mujoco.MjSpec, *, welded: bool) -> mujoco.MjsBody:
    """Add the bodies ``forearm`` and ``palm``, one in the other, and ``forearm_target``."""
    spec.worldbody.add_body(name="forearm_target", mocap=True)
    base = spec.worldbody.add_body(name="forearm", gravcomp=1.0)
    base.add_freejoint(name="forearm")
    # A free body needs mass, and the hand's own is all in bodies that it carries.
    base.add_geom(
        name="mount",
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[0.03, 0.0, 0.0],
        mass=0.5,
        contype=0,
        conaffinity=0,
        group=4,  # is not drawn
    )
    base.add_body(name="palm")
    if welded:
        weld_to_mocap(spec, "forearm_weld", "forearm_target", "forearm")
    return base


def _bare(hand: mujoco.MjSpec) -> mujoco.MjSpec:
    """Return a copy of a hand without what is not needed to grasp: sensors, keys, lights."""
    bare = hand.copy()
    for kind in (bare.sensors, bare.keys, bare.lights, bare.cameras):
        for each in list(kind):
            bare.delete(each)
    return bare


def _name_fingers(spec: mujoco.MjSpec, robot: RobotHand) -> None:
    """Let the names of the bodies of each finger begin with the finger's."""
    new: dict[str, str] = {}
    for finger, first in robot.first_bodies().items():
        body = spec.body(PREFIX + first)
        for each in (body, *body.find_all(mujoco.mjtObj.mjOBJ_BODY)):
            new[each.name] = f"{finger}_{each.name}"
    for old, name in new.items():
        spec.body(old).name = name
    for pair in spec.excludes:
        pair.bodyname1 = new.get(pair.bodyname1, pair.bodyname1)
        pair.bodyname2 = new.get(pair.bodyname2, pair.bodyname2)
    for equality in spec.equalities:
        equality.name1 = new.get(equality.name1, equality.name1)
        equality.name2 = new.get(equality.name2, equality.name2)


def _xml(task: Task, conditions: Conditions, robot: RobotHand) -> str:
    spec = robot_scene_spec(task, conditions, robot)
    model = quiet_compile(spec)
    for mesh in spec.meshes:
        if mesh.file:
            _write_out(mesh, model)
    quiet_compile(spec)
    with unheard_warnings():  # it compiles once more
        return spec.to_xml()


def _write_out(mesh: mujoco.MjsMesh, model: mujoco.MjModel) -> None:
    """Put the vertices of a mesh into the model itself, so that it needs no file."""
    i = model.mesh(mesh.name).id
    first, n = model.mesh_vertadr[i], model.mesh_vertnum[i]
    start, m = model.mesh_faceadr[i], model.mesh_facenum[i]
    # MuJoCo moved them to the mesh's centre and principal axes.
    turn = np.empty(9)
    mujoco.mju_quat2Mat(turn, model.mesh_quat[i])
    vertices = model.mesh_vert[first : first + n] @ turn.reshape(3, 3).T + model.mesh_pos[i]
    mesh.file, mesh.scale = "", [1.0, 1.0, 1.0]
    mesh.uservert, mesh.userface = vertices.ravel(), model.mesh_face[start : start + m].ravel()
