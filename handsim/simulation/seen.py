"""What is seen of a run, and the record that is made of it."""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt

from handsim.simulation.course import Course
from handsim.simulation.drivers import Driver
from handsim.simulation.glove import DataGlove
from handsim.simulation.plan import Schedule
from handsim.simulation.rollout import Phase, Rollout, current_versions
from handsim.simulation.stage import Stage
from handsim.simulation.trials import GraspTraces, judge

Array = npt.NDArray[np.float64]


def judged(
    stage: Stage,
    course: Course,
    driver: Driver,
    glove: DataGlove,
    seen: Mapping[str, Array],
    *,
    unstable: bool = False,
) -> Rollout:
    """Judge what was seen of a run and make it a record.

    Parameters
    ----------
    stage, course, driver, glove
        What the run was made with.
    seen
        Samples, a row each: ``qpos``, ``qvel``, ``ctrl``, ``mocap_pos``, ``mocap_quat``,
        ``contact_force``, ``penetration`` and the poses that `Senses` gives.
    unstable
        Whether the simulation diverged after the last sample.
    """
    schedule = course.schedule
    n = len(seen["qpos"])
    arrays = dict(seen)
    reading = glove.reading(arrays["qpos"][:, stage.hand.qpos_index], course.disturbance[:n])
    arrived = driver.arrived(reading[min(course.arrival, n - 1)])
    arrays |= {
        "time": course.times[:n],
        "reading": reading,
        "z": driver.coordinates(reading),
    }
    if unstable:  # files hold numbers only
        arrays = {name: np.nan_to_num(values) for name, values in arrays.items()}
    axes = np.stack([arrays.pop(f"object_{axis}") for axis in "xyz"], axis=2)
    front_pos = arrays.pop("object_origin") + axes @ stage.front
    joint = stage.task.rule.joint
    hinge = stage.hand.model.joint(joint).qposadr[0] if joint else None
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
        front_pos=front_pos,
        hinge=np.zeros(n) if hinge is None else arrays["qpos"][:, hinge],
        arrived=arrived,
        unstable_at=float(arrays["time"][-1]) if unstable else None,
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


def _phases(schedule: Schedule) -> tuple[Phase, ...]:
    return (
        Phase("reach", 0.0),
        Phase("squeeze", schedule.squeeze_start),
        Phase("action", schedule.action_start),
        Phase("hold", schedule.hold_start),
    )
