"""Run one grasp in contact physics: glove, driver, squeeze, forearm, and what is recorded of it.

Once every hundredth of a second the glove is read, the driver gives joint targets, the squeeze is
added, and the forearm is put where the palm's path and the commanded wrist angles need it.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
from scipy.spatial.transform import Rotation

from handsim.hand.grasp_object import GraspObject
from handsim.hand.grasp_task import Task
from handsim.hand.model import HandModel
from handsim.hand.objects import read_mesh
from handsim.hand.scene import build_scene
from handsim.joints import LOWER, UPPER
from handsim.simulation.alignment import Wrist
from handsim.simulation.conditions import Conditions
from handsim.simulation.drivers import Driver
from handsim.simulation.glove import RATE, DataGlove
from handsim.simulation.plan import GraspPlan, PalmPath, Pose, Schedule, schedule_for
from handsim.simulation.rollout import (
    CONTACT_PARTS,
    Phase,
    Rollout,
    current_versions,
)
from handsim.simulation.squeeze import ramp, squeeze_offset
from handsim.simulation.trials import GraspTraces, judge

Array = npt.NDArray[np.float64]

SHAKE_FREQUENCY = 2.0
"""Of the base's shaking during the hold [Hz]."""
MAX_SPEED = 500.0
"""Joint or body speed above which a simulation is taken to have diverged [m/s or rad/s]."""
_BAD_NUMBERS = (
    mujoco.mjtWarning.mjWARN_BADCTRL,
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
)
LOST = 0.02
"""Rise [m] that an object must show while the palm rises twice as far."""


@dataclass(frozen=True)
class Stage:
    """A compiled scene and where its parts are, to be simulated in many times over.

    Attributes
    ----------
    task
        For the right or left hand that is in the scene.
    conditions
        What the scene was built with.
    hand
        The scene's model and data.
    xml
        The model as text.
    mocap
        Row of the forearm's target.
    thing
        The object.
    front : (3,) [m]
        Its front end in its own frame.
    object_body, palm_body
        Body ids.
    part_of_geom : (n_geom,)
        Column of `CONTACT_PARTS` for the hand's geoms, -1 for all others.
    of_object : (n_geom,)
        Whether a geom belongs to the object.
    lead : (22,) [s]
        Damping over stiffness of the actuators.
    """

    task: Task
    conditions: Conditions
    hand: HandModel
    xml: str
    mocap: int
    thing: GraspObject
    front: Array
    object_body: int
    palm_body: int
    part_of_geom: npt.NDArray[np.intp]
    of_object: npt.NDArray[np.bool_]
    lead: Array

    @classmethod
    def build(cls, task: Task, conditions: Conditions) -> "Stage":
        """Build the scene of a task under the given conditions."""
        dx, dy, yaw = conditions.object_offset
        spec = build_scene(
            task,
            hand_length=conditions.hand_length,
            hand_breadth=conditions.hand_breadth,
            side=conditions.side,
            friction=conditions.friction,
            mass_scale=conditions.mass_scale,
            offset=(dx, dy),
            turn=yaw,
        )
        hand = HandModel.from_spec(spec)
        model = hand.model
        object_body = model.body("object").id
        root = model.body_rootid[model.geom_bodyid]
        index = hand.ctrl_index
        stiffness = model.actuator_gainprm[index, 0]
        damping = -model.actuator_biasprm[index, 2]
        thing = task.thing
        return cls(
            task=task.for_side(conditions.side),
            conditions=conditions,
            hand=hand,
            xml=spec.to_xml(),
            mocap=int(model.body("forearm_target").mocapid[0]),
            thing=thing,
            front=_front_end(thing),
            object_body=object_body,
            palm_body=model.body("palm").id,
            part_of_geom=_parts(model),
            of_object=root == object_body,
            lead=damping / stiffness,
        )


@contextmanager
def _silent() -> Iterator[None]:
    """Keep MuJoCo from telling the terminal and a log file what the outcome will tell."""
    kept = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(kept)


@_silent()
def simulate(
    stage: Stage,
    plan: GraspPlan,
    driver: Driver,
    glove: DataGlove | None = None,
    schedule: Schedule | None = None,
    brief: bool = False,
) -> Rollout:
    """Run one grasp and judge it.

    Parameters
    ----------
    stage
        Scene of the task.
    plan
        Where palm and fingers go.
    driver
        What moves the fingers during the reach.
    glove
        How the joints are read; by default 1 degree steps with noise.
    schedule
        Timing; by default that of the task.
    brief
        End the run once the object has been lost, as a search may.

    Returns
    -------
    Rollout
        Cut short, with outcome ``unstable``, where the simulation diverges.
    """
    glove = glove or DataGlove()
    schedule = schedule or schedule_for(stage.task)
    generator = np.random.default_rng(stage.conditions.seed)
    run = _Run(stage, plan, schedule, generator)
    model, data = stage.hand.model, stage.hand.data
    substeps = round(1.0 / (RATE * model.opt.timestep))
    arrived = False
    for tick, time in enumerate(run.times.tolist()):
        reading = glove.read(stage.hand.q, generator)
        if time <= schedule.reach:
            arrived = driver.arrived(reading)
        run.command(tick, driver.targets(time, reading))
        run.record(time, reading, driver.coordinates(reading))
        mujoco.mj_step(model, data, nstep=substeps)
        if run.diverged():
            return run.finish(driver, arrived, unstable_at=time)
        if brief and run.lost(tick):
            break
    return run.finish(driver, arrived)


class _Run:
    """State and traces of one run."""

    def __init__(
        self, stage: Stage, plan: GraspPlan, schedule: Schedule, generator: np.random.Generator
    ) -> None:
        self.stage, self.schedule = stage, schedule
        self.model, self.data = stage.hand.model, stage.hand.data
        mujoco.mj_resetData(self.model, self.data)
        yaw = np.deg2rad(stage.task.yaw_deg)
        expected = Rotation.from_euler("z", yaw).as_quat(scalar_first=True)
        path = PalmPath(plan, stage.task, schedule, Pose(np.zeros(3), expected))
        self.times = np.arange(round(schedule.end * RATE) + 1) / RATE
        self.palm_pos, self.palm_quat = path.poses(self.times)
        self.palm_pos += _shaking(self.times, stage.conditions.shake, schedule, generator)
        strength = ramp(self.times, schedule.squeeze_start, schedule.squeeze)
        squeeze = squeeze_offset(plan.squeeze, stage.task.grasp.fingers)
        self.added = strength[:, None] * squeeze + path.flexions(self.times)
        self.action_tick = round(schedule.action_start * RATE)
        self.wrist = Wrist(self.model)
        self.samples: dict[str, list[Any]] = {}
        self._place_hand(plan.q_start)

    def _place_hand(self, q_start: Array) -> None:
        """Put hand and forearm at the start, at rest."""
        free = self.data.joint("forearm")
        free.qpos[:3], free.qpos[3:] = self.wrist.forearm(
            self.palm_pos[0], self.palm_quat[0], q_start
        )
        self.stage.hand.set_posture(q_start)

    def command(self, tick: int, targets: Array) -> None:
        """Set the actuators' targets, squeeze included, and the forearm's."""
        data, mocap = self.data, self.stage.mocap
        ctrl = np.clip(targets + self.added[tick], LOWER, UPPER)
        data.ctrl[self.stage.hand.ctrl_index] = ctrl
        data.mocap_pos[mocap], data.mocap_quat[mocap] = self.wrist.forearm(
            self.palm_pos[tick], self.palm_quat[tick], ctrl
        )

    def record(self, time: float, reading: Array, z: Array) -> None:
        """Keep a sample of everything."""
        data, stage, rule = self.data, self.stage, self.stage.task.rule
        force, depth = self._contact()
        sample = {
            "time": time,
            "qpos": data.qpos.copy(),
            "qvel": data.qvel.copy(),
            "ctrl": data.ctrl.copy(),
            "mocap_pos": data.mocap_pos[stage.mocap].copy(),
            "mocap_quat": data.mocap_quat[stage.mocap].copy(),
            "reading": reading,
            "z": z,
            "contact_force": force,
            "penetration": depth,
            "object_pos": data.xipos[stage.object_body].copy(),
            "object_quat": data.xquat[stage.object_body].copy(),
            "palm_pos": data.xpos[stage.palm_body].copy(),
            "palm_quat": data.xquat[stage.palm_body].copy(),
            "front_pos": self._front(),
            "hinge": float(data.joint(rule.joint).qpos[0]) if rule.joint else 0.0,
        }
        for name, value in sample.items():
            self.samples.setdefault(name, []).append(value)

    def _front(self) -> Array:
        """Return where the object's front end is in the world, (3,) [m]."""
        turn = self.data.xmat[self.stage.object_body].reshape(3, 3)
        return self.data.xpos[self.stage.object_body] + turn @ self.stage.front

    def _contact(self) -> tuple[Array, float]:
        """Sum of normal forces per part of the hand on the object, and the deepest overlap."""
        force = np.zeros(len(CONTACT_PARTS))
        contact = self.data.contact
        if self.data.ncon == 0:
            return force, 0.0
        first, second = contact.geom[:, 0], contact.geom[:, 1]
        parts = self.stage.part_of_geom
        part = np.maximum(parts[first], parts[second])
        held = (part >= 0) & (self.stage.of_object[first] | self.stage.of_object[second])
        held &= contact.efc_address >= 0
        normal = self.data.efc_force[contact.efc_address[held]]
        np.add.at(force, part[held], normal)
        depth = float(max(0.0, -contact.dist[held].min())) if held.any() else 0.0
        return force, depth

    def diverged(self) -> bool:
        """Whether the state has left all bounds."""
        # MuJoCo warns of what is no number and, but for the controls, starts again from rest.
        warned = any(self.data.warning[kind].number for kind in _BAD_NUMBERS)
        return bool(warned or not (np.abs(self.data.qvel) <= MAX_SPEED).all())

    def lost(self, tick: int) -> bool:
        """Whether the object stays behind a palm that was to lift it."""
        rise = self.palm_pos[tick, 2] - self.palm_pos[self.action_tick, 2]
        if self.stage.task.rule.lift < LOST or tick <= self.action_tick or rise < 2 * LOST:
            return False
        height = self.data.xipos[self.stage.object_body, 2] - self.samples["object_pos"][0][2]
        return bool(height < LOST)

    def finish(self, driver: Driver, arrived: bool, unstable_at: float | None = None) -> Rollout:
        """Judge the traces and make them a record."""
        arrays = {name: np.array(values) for name, values in self.samples.items()}
        if unstable_at is not None:  # files hold numbers only
            arrays = {name: np.nan_to_num(values) for name, values in arrays.items()}
        stage, schedule = self.stage, self.schedule
        traces = GraspTraces(
            time=arrays["time"],
            object_pos=arrays.pop("object_pos"),
            object_quat=arrays.pop("object_quat"),
            palm_pos=arrays.pop("palm_pos"),
            palm_quat=arrays.pop("palm_quat"),
            touching=(arrays["contact_force"] > 0).sum(axis=1),
            penetration=arrays["penetration"],
            action_start=schedule.action_start,
            symmetry=stage.thing.symmetry,
            front_pos=arrays.pop("front_pos"),
            hinge=arrays.pop("hinge"),
            arrived=arrived,
            unstable_at=unstable_at,
        )
        return Rollout(
            task=stage.task.name,
            driver=driver.name,
            model_xml=stage.xml,
            assets={},
            phases=_phases(schedule),
            conditions=stage.conditions,
            outcome=judge(traces, stage.task),
            versions=current_versions(),
            **arrays,
        )


def _front_end(thing: GraspObject) -> Array:
    """Return the middle of what lies farthest along the object's x, (3,) [m]."""
    meshes = (read_mesh(p.mesh) if isinstance(p.mesh, str) else p.mesh for p in thing.pieces)
    vertices = np.concatenate([mesh.vertices for mesh in meshes])
    return vertices[vertices[:, 0] > vertices[:, 0].max() - 1e-5].mean(axis=0)


def _parts(model: mujoco.MjModel) -> npt.NDArray[np.intp]:
    """Column of `CONTACT_PARTS` for each geom of the hand, -1 elsewhere."""
    parts = np.full(model.ngeom, -1)
    forearm_root = model.body_rootid[model.body("forearm").id]
    for geom in range(model.ngeom):
        body = model.geom_bodyid[geom]
        if model.body_rootid[body] != forearm_root:
            continue
        name = model.body(body).name.split("_")[0]
        parts[geom] = CONTACT_PARTS.index(name if name in CONTACT_PARTS else "palm")
    return parts


def _shaking(
    times: Array, acceleration: float, schedule: Schedule, generator: np.random.Generator
) -> Array:
    """Return a horizontal shake of the hand in the hold, in a random direction, (n, 3) [m].

    ``acceleration`` is its amplitude [m/s^2].
    """
    angle = generator.uniform(0.0, 2 * np.pi)
    omega = 2 * np.pi * SHAKE_FREQUENCY
    since = times - schedule.hold_start
    swing = ramp(since, 0.0, 0.5) * acceleration / omega**2 * np.sin(omega * since)
    return swing[:, None] * np.array([np.cos(angle), np.sin(angle), 0.0])


def _phases(schedule: Schedule) -> tuple[Phase, ...]:
    return (
        Phase("reach", 0.0),
        Phase("squeeze", schedule.squeeze_start),
        Phase("action", schedule.action_start),
        Phase("hold", schedule.hold_start),
    )
