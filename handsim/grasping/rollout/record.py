"""The record of one simulated grasp: its model, its samples and its outcome.

A record has all that is needed to draw or to judge the grasp again without simulating it: the
model as XML with its meshes, states, commands, contact forces, versions and the outcome.
"""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

import platform
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from handsim.content import ByContent
from handsim.errors import InputError
from handsim.grasping._stored_model import trusted_xml
from handsim.grasping.conditions import Conditions
from handsim.grasping.gripping.need import LEAST, contacts_at, least_grip, spare_state
from handsim.grasping.rollout.forearm import WRIST_COLUMNS
from handsim.tasks.rules import GraspTraces, Outcome, judge
from handsim.types import Array

N_NEEDS = 2
"""Moments of the hold at which the force that is needed is computed."""

if TYPE_CHECKING:
    import mujoco

    from handsim.grasping.plan import Schedule
    from handsim.grasping.rollout.commands import Commands
    from handsim.grasping.rollout.drivers import Driver
    from handsim.grasping.rollout.glove import DataGlove
    from handsim.objects.object import GraspObject
    from handsim.tasks.task import Task


class JudgedScene(Protocol):
    """What a record needs to know of a scene, be it with a person's hand or a robot's."""

    @property
    def task(self) -> "Task":
        """For the hand's side."""
        ...

    @property
    def conditions(self) -> Conditions:
        """The conditions that the scene was built for."""
        ...

    @property
    def model(self) -> "mujoco.MjModel":
        """The compiled model."""
        ...

    @property
    def xml(self) -> Callable[[], str]:
        """Returns the model as XML."""
        ...

    @property
    def object(self) -> "GraspObject":
        """The object to grasp.

        :meta private:
        """
        ...

    @property
    def front(self) -> Array:
        """Front end of the object in its own frame, (3,) [m]."""
        ...


@dataclass(frozen=True)
class Phase:
    """A phase of a grasp, and when it starts [s]."""

    name: str
    start: float


class _Text:
    """A text field that can be set to a function, which is called when the text is first read."""

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = f"_{name}"

    def __get__(self, instance: Any, owner: type | None = None) -> str:
        if instance is None:
            raise AttributeError(self._name)  # tells dataclasses that there is no default
        value: str | Callable[[], str] = getattr(instance, self._name)
        text = value if isinstance(value, str) else value()
        self.__set__(instance, text)
        return text

    def __set__(self, instance: Any, value: str | Callable[[], str]) -> None:
        object.__setattr__(instance, self._name, value)


@dataclass(frozen=True, kw_only=True, eq=False)
class Rollout(ByContent):
    """A simulated grasp; two are equal if all their fields are, to the bit.

    Attributes
    ----------
    task, driver
        Names of the task and of the driver.
    model_xml, assets
        The model as XML, which may be set to a function that returns it, and the files that it
        refers to, by name.
    time : (n,) [s]
    qpos, qvel, ctrl : (n, nq), (n, nv), (n, nu)
        MuJoCo's positions, velocities and controls, in the order of the model.
    mocap_pos, mocap_quat : (n, 3) [m], (n, 4)
        Commanded pose of the forearm.
    reading : (n, 22) [rad]
        Readings of the data glove.
    z : (n, n_components) [rad]
        Readings in the driver's subspace; (n, 0) where it has none.
    contact_force : (n, 6) [N]
        Sum of normal forces on the object, per part of the hand (`CONTACT_PARTS`).
    press : (n, 6, 3) [N]
        The same forces as vectors in the world.
    penetration : (n,) [m]
        Deepest overlap of the hand with object or table.
    table_force : (n,) [N]
        What hand and arm press on the table.
    phases
        In order of time.
    conditions, outcome
        Conditions of the run, and how it was judged.
    versions
        Of the software and the platform that made it.
    """

    task: str
    driver: str
    model_xml: _Text = _Text()
    assets: dict[str, bytes]
    time: Array
    qpos: Array
    qvel: Array
    ctrl: Array
    mocap_pos: Array
    mocap_quat: Array
    reading: Array
    z: Array
    contact_force: Array
    press: Array
    penetration: Array
    table_force: Array
    phases: tuple[Phase, ...]
    conditions: Conditions
    outcome: Outcome
    versions: dict[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Return what was grasped, by what, and how it ended."""
        ended = "success" if self.outcome.success else self.outcome.reason
        return f"Rollout({self.task} by {self.driver}: {ended} after {self.time[-1]:.2f} s)"

    def model(self) -> "mujoco.MjModel":
        """Compile the stored model.

        Raises
        ------
        InputError
            If it holds what no scene of this package does (see `trusted_xml`), is no model, or
            has other sizes than the stored states.
        """
        import mujoco

        try:
            xml = trusted_xml(self.model_xml, self.assets)
            model = mujoco.MjModel.from_xml_string(xml, self.assets)
        except ValueError as error:
            reason = " ".join(str(error).split())
            raise InputError(f"rollout of {self.task}: {reason}") from error
        if (model.nq, model.nv) != (self.qpos.shape[1], self.qvel.shape[1]):
            raise InputError(
                f"rollout of {self.task}: {self.qpos.shape[1]} positions and "
                f"{self.qvel.shape[1]} velocities for a model of {model.nq} and {model.nv}; "
                "make it again"
            )
        return model

    def phase_at(self, time: float) -> str:
        """Return the name of the phase at ``time`` [s]."""
        names = [phase.name for phase in self.phases if phase.start <= time + 1e-9]
        return names[-1] if names else ""


def current_versions() -> dict[str, str]:
    """Return the versions and the platform that the numbers of a simulation depend on."""
    return dict(_versions())


@cache
def _versions() -> dict[str, str]:
    return {
        "handsim": version("handsim"),
        "mujoco": version("mujoco"),
        "numpy": version("numpy"),
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
    }


def read_by(
    glove: "DataGlove", commands: "Commands", driver: "Driver", q: Array
) -> tuple[Array, bool]:
    """Return a glove's readings of postures (n, 22), and whether the hand had arrived.

    The driver says so by what the glove read at the end of the reach; where the run ended before,
    by its last reading.

    Parameters
    ----------
    glove, commands, driver
        Of the run.
    q : (n, 22) [rad]
    """
    n = len(q)
    reading = glove.reading(q, commands.disturbance[:n])
    last_of_reach = reading[min(commands.arrival, n - 1)].copy()
    if commands.reach is not None:  # the arm says where the wrist is, not the driver
        last_of_reach[WRIST_COLUMNS] = driver.destination[WRIST_COLUMNS]
    return reading, driver.arrived(last_of_reach)


def record_of(
    scene: "JudgedScene",
    commands: "Commands",
    driver: "Driver",
    samples: Mapping[str, Array],
    *,
    reading: Array,
    arrived: bool,
    unstable: bool = False,
) -> Rollout:
    """Judge a run by its samples and return its record.

    Parameters
    ----------
    scene, commands, driver
        Of the run.
    samples
        Arrays with a row for each reading: ``qpos``, ``qvel``, ``ctrl``, ``mocap_pos``,
        ``mocap_quat``, ``contact_force``, ``press``, ``penetration``, ``table_force``, ``pressed``
        and those of `Sensors.poses`.
    reading : (n, 22) [rad]
        Of the glove.
    arrived
        Whether the hand was at its destination at the end of the reach.
    unstable
        Whether the simulation diverged after the last sample.
    """
    schedule = commands.schedule
    n = len(samples["qpos"])
    arrays = dict(samples)
    arrays |= {
        "time": commands.times[:n],
        "reading": reading,
        "z": driver.coordinates(reading),
    }
    if unstable:  # files hold numbers only
        arrays = {name: np.nan_to_num(values) for name, values in arrays.items()}
    axes = np.stack([arrays.pop(f"object_{axis}") for axis in "xyz"], axis=2)
    front_pos = arrays.pop("object_origin") + axes @ scene.front
    joint = scene.task.rule.joint
    hinge = scene.model.joint(joint).qposadr[0] if joint else None
    traces = GraspTraces(
        time=arrays["time"],
        object_pos=arrays.pop("object_pos"),
        object_quat=arrays.pop("object_quat"),
        palm_pos=arrays.pop("palm_pos"),
        palm_quat=arrays.pop("palm_quat"),
        press=arrays["press"],
        force=arrays["contact_force"],
        penetration=arrays["penetration"],
        table_force=arrays["table_force"],
        pressed=arrays.pop("pressed"),
        need=LEAST if unstable else _need(scene, commands, arrays),
        action_start=schedule.action_start,
        hold_start=schedule.hold_start,
        symmetry=scene.object.symmetry,
        front_pos=front_pos,
        hinge=np.zeros(n) if hinge is None else arrays["qpos"][:, hinge],
        strain=0.0 if commands.reach is None else float(commands.reach.strain.max()),
        arrived=arrived,
        unstable_at=float(arrays["time"][-1]) if unstable else None,
    )
    return Rollout(
        task=scene.task.name,
        driver=driver.name,
        model_xml=scene.xml,
        assets={},
        phases=_phases(schedule),
        conditions=scene.conditions,
        outcome=judge(traces, scene.task),
        versions=current_versions(),
        **arrays,
    )


def _need(scene: "JudgedScene", commands: "Commands", arrays: Mapping[str, Array]) -> float:
    """Return the greatest need of a few moments of the hold: where the palm accelerates most [N].

    Only what is lifted has one beyond the least.
    """
    import mujoco

    n, first = len(arrays["qpos"]), commands.row(commands.schedule.hold_start)
    if not scene.task.rule.lifted or n <= first:
        return LEAST
    model = scene.model
    data = spare_state(model)
    object_id = model.body("object").id
    load = commands.load[:n] * model.body_subtreemass[object_id]
    needs: list[float] = []
    for rows in np.array_split(np.arange(first, n), N_NEEDS):
        if not len(rows):
            continue
        row = int(rows[np.linalg.norm(load[rows], axis=1).argmax()])
        for name in ("qpos", "mocap_pos", "mocap_quat"):
            getattr(data, name)[:] = arrays[name][row]
        mujoco.mj_fwdPosition(model, data)  # places and contacts, and no forces
        needs.append(least_grip(contacts_at(model, data), data.subtree_com[object_id], load[row]))
    return max(needs)


def _phases(schedule: "Schedule") -> tuple[Phase, ...]:
    return (
        Phase("reach", 0.0),
        Phase("squeeze", schedule.squeeze_start),
        Phase("action", schedule.action_start),
        Phase("hold", schedule.hold_start),
    )
