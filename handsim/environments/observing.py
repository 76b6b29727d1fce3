"""What a policy sees of a run at a reading, and what the reward looks at."""
# pyright: reportAttributeAccessIssue=false
# MuJoCo's compiled modules carry no stubs for their enums and functions.

from collections.abc import Sequence
from math import dist
from typing import NamedTuple

import numpy as np

from handsim.environments.entries import Entry
from handsim.environments.grasp_episode import GraspEpisode, Row
from handsim.grasping.plan import Schedule, schedule_for
from handsim.grasping.rollout.commands import read_at
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.sensing import Sensors
from handsim.joints import FINGERS
from handsim.types import Array, Index

_TIPS = range(0, 3 * len(FINGERS), 3)
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
    press: list[tuple[float, float, float]]
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
        tips: Index = np.array([model.site(f"{finger}_tip").id for finger in FINGERS])
        self._tips = (3 * tips[:, None] + np.arange(3)).ravel()
        self._grasp: list[float] = model.site("grasp").pos.tolist()
        joint = scene.task.rule.joint
        self._hinge = int(model.joint(joint).qposadr[0]) if joint else None
        # Rows, since NumPy is faster with arrays of one shape.
        self._low = np.concatenate([np.full(entry.size, entry.low) for entry in entries])[None]
        self._high = np.concatenate([np.full(entry.size, entry.high) for entry in entries])[None]
        ends = np.cumsum([entry.size for entry in entries]).tolist()
        self._places = {
            entry.name: slice(end - entry.size, end)
            for entry, end in zip(entries, ends, strict=True)
        }
        shares = _shares(schedule_for(scene.task))
        # What is known before the runs, at each of their readings.
        self._known = np.zeros((len(shares), ends[-1]))
        self._known[:, self._places["destination"]] = destination
        self._known[:, self._places["need"]] = need
        self._known[:, self._places["progress"].start : self._places["time"].stop] = shares
        self._posture, self._components = self._places["posture"], self._places["components"]
        self._numbers = slice(self._places["fingertips"].start, self._places["hinge"].stop)
        self._first: list[list[float]] = []

    def begin(self, episode: GraspEpisode) -> None:
        """Remember where the objects are at the start of the runs."""
        self._first = [episode.sensors.posed(row.values)[:3] for row in episode.rows]

    def look(self, episode: GraspEpisode) -> tuple[Array, list[Felt]]:
        """Return observations at the reading that runs are at, (n, size), and what is felt."""
        rows = episode.rows
        flat = np.empty((len(rows), self._known.shape[1]))
        flat[:] = self._known[episode.reading]
        flat[:, self._posture], flat[:, self._components] = episode.seen()
        felt: list[Felt] = []
        for i, row in enumerate(rows):
            flat[i, self._numbers], each = self._look_at(row, self._first[i], episode.sensors)
            felt.append(each)
        np.maximum(flat, self._low, out=flat)
        np.minimum(flat, self._high, out=flat)
        return flat, felt

    def _look_at(
        self, row: Row, first: Sequence[float], sensors: Sensors
    ) -> tuple[list[float], Felt]:
        """Return the entries of one run from ``fingertips`` to ``hinge``, and what is felt.

        Parameters
        ----------
        row
        first : (3,) [m]
            Where the object's centre of mass was at the start.
        sensors
        """
        # Centre of mass; orientation, origin and the three axes of the object; the palm.
        (
            mx, my, mz, qw, qx, qy, qz, ox, oy, oz, a, b, c, d, e, f, g, h, i, px, py, pz,
            *palm_quat,
        ) = sensors.posed(row.values)  # fmt: skip
        seen: list[float] = []
        away: list[float] = []
        tips, grasp = row.sites.take(self._tips).tolist(), self._grasp
        for k in _TIPS:
            x, y, z = tips[k] - ox, tips[k + 1] - oy, tips[k + 2] - oz
            tip = (x * a + y * b + z * c, x * d + y * e + z * f, x * g + y * h + z * i)
            seen += tip
            away.append(dist(tip, grasp))
        x, y, z = px - ox, py - oy, pz - oz
        seen += (x * a + y * b + z * c, x * d + y * e + z * f, x * g + y * h + z * i)
        seen += _seen_from((qw, qx, qy, qz), palm_quat)
        force, press = sensors.touching(row.values)
        seen += force
        seen += (mx - first[0], my - first[1], mz - first[2])
        seen.append(0.0 if self._hinge is None else float(row.qpos[self._hinge]))
        return seen, Felt(force, press, away)

    def named(self, flat: Array) -> dict[str, Array]:
        """Return observations (..., size) by the names of their entries."""
        if flat.ndim == 1:  # the same, faster
            return {name: flat[place] for name, place in self._places.items()}
        return {name: flat[..., place] for name, place in self._places.items()}


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
