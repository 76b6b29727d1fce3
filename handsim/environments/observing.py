"""What a policy sees of a run at a reading, and what the reward looks at."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Sequence
from math import dist
from typing import NamedTuple

import numpy as np

from handsim.environments.entries import Entry
from handsim.environments.grasp_episode import GraspEpisode
from handsim.grasping.plan import Schedule, schedule_for
from handsim.grasping.rollout.commands import read_at
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.joints import FINGERS
from handsim.types import Array, Index

_SHORT = 1e-9  # a phase that takes no time has passed once it begins [s]


class Felt(NamedTuple):
    """How hand and object are to each other at a reading.

    Attributes
    ----------
    force : (6,) [N]
        Normal force of each part of the hand (`CONTACT_PARTS`).
    press : (6, 3) [N]
        The same as vectors in the world.
    away : (5,) [m]
        From each fingertip to the grasp point.
    """

    force: list[float]
    press: list[list[float]]
    away: list[float]


class Observer:
    """Looks at the runs of one scene.

    It looks a hundred times a second: what is few numbers is computed with numbers, which are
    faster than arrays.

    Parameters
    ----------
    scene
    entries
        What to observe.
    destination : (n_components,) [rad]
        Of the plan.
    need : [N]
        Least force a side that the planned grasp needs.
    """

    def __init__(
        self, scene: Scene, entries: Sequence[Entry], destination: Array, need: float
    ) -> None:
        model = scene.model
        self._tips: Index = np.array([model.site(f"{finger}_tip").id for finger in FINGERS])
        self._grasp: list[float] = model.site("grasp").pos.tolist()
        joint = scene.task.rule.joint
        self._hinge = int(model.joint(joint).qposadr[0]) if joint else None
        self._low = np.concatenate([np.full(entry.size, entry.low) for entry in entries])
        self._high = np.concatenate([np.full(entry.size, entry.high) for entry in entries])
        ends = np.cumsum([entry.size for entry in entries]).tolist()
        self._places = {
            entry.name: slice(end - entry.size, end)
            for entry, end in zip(entries, ends, strict=True)
        }
        self._template = np.zeros(ends[-1])
        self._template[self._places["destination"]] = destination
        self._template[self._places["need"]] = need
        self._numbers = slice(self._places["palm_position"].start, self._places["hinge"].stop)
        self._tip_numbers = self._places["fingertips"]
        self._clock = slice(self._places["progress"].start, self._places["time"].stop)
        self._shares = _shares(schedule_for(scene.task))
        self._first: list[list[float]] = []

    def begin(self, episode: GraspEpisode) -> None:
        """Remember where the objects are at the start of the runs."""
        self._first = [episode.sensors.posed(row.values)["object_pos"] for row in episode.rows]

    def look(self, episode: GraspEpisode) -> tuple[Array, list[Felt]]:
        """Return observations at the reading that runs are at, (n, size), and what is felt."""
        sensors, places, shares = episode.sensors, self._places, self._shares[episode.reading]
        flat = np.array([self._template] * len(episode.rows))
        flat[:, places["posture"]], flat[:, places["components"]] = episode.seen()
        flat[:, self._clock] = shares
        poses = [sensors.posed(row.values) for row in episode.rows]
        axes = [(pose["object_x"], pose["object_y"], pose["object_z"]) for pose in poses]
        origins = np.array([pose["object_origin"] for pose in poses])
        away = episode.sites.take(self._tips, axis=1) - origins[:, None]
        parts = away[:, :, None] * np.array(axes)[:, None]
        tips = parts[..., 0] + parts[..., 1] + parts[..., 2]
        flat[:, self._tip_numbers] = tips.reshape(len(poses), -1)
        felt: list[Felt] = []
        for i, (row, pose, each) in enumerate(zip(episode.rows, poses, tips.tolist(), strict=True)):
            force, press = sensors.touching(row.values)
            flat[i, self._numbers] = [
                *_in_frame(axes[i], pose["palm_pos"], pose["object_origin"]),
                *_seen_from(pose["object_quat"], pose["palm_quat"]),
                *force,
                *_away(pose["object_pos"], self._first[i]),
                0.0 if self._hinge is None else float(row.qpos[self._hinge]),
            ]
            felt.append(Felt(force, press, [dist(tip, self._grasp) for tip in each]))
        np.maximum(flat, self._low, out=flat)
        np.minimum(flat, self._high, out=flat)
        return flat, felt

    def named(self, flat: Array) -> dict[str, Array]:
        """Return observations (..., size) by the names of their entries."""
        return {name: flat[..., place] for name, place in self._places.items()}


def _in_frame(
    axes: Sequence[Sequence[float]], place: Sequence[float], origin: Sequence[float]
) -> tuple[float, ...]:
    """Return a place of the world in a frame, of which axes and origin are given in the world."""
    x, y, z = _away(place, origin)
    (a, b, c), (d, e, f), (g, h, i) = axes
    return x * a + y * b + z * c, x * d + y * e + z * f, x * g + y * h + z * i


def _away(place: Sequence[float], origin: Sequence[float]) -> tuple[float, float, float]:
    """Return the way from one place to another, the second first."""
    (x, y, z), (a, b, c) = place, origin
    return x - a, y - b, z - c


def _shares(schedule: Schedule) -> Array:
    """Return the shares of the phases that have passed at each reading, and its time, (n, 5)."""
    times = read_at(schedule)
    starts = np.array([0.0, schedule.squeeze_start, schedule.action_start, schedule.hold_start])
    ends = np.append(starts[1:], schedule.end)
    shares = np.clip((times[:, None] - starts) / np.maximum(ends - starts, _SHORT), 0.0, 1.0)
    return np.column_stack([shares, times])


def _seen_from(frame: Sequence[float], quat: Sequence[float]) -> tuple[float, ...]:
    """Return an orientation in another frame, both given in the world as quaternions."""
    aw, ax, ay, az = frame
    w, x, y, z = quat
    turned = (
        aw * w + ax * x + ay * y + az * z,
        aw * x - ax * w - ay * z + az * y,
        aw * y + ax * z - ay * w - az * x,
        aw * z - ax * y + ay * x - az * w,
    )
    return turned if turned[0] >= 0.0 else tuple(-each for each in turned)
