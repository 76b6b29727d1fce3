"""What LeRobot calls the quantities of an episode, on a grid of whole frames a second."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from handsim.errors import InputError
from handsim.exports.episode import Episode, Quantity
from handsim.types import Array
from handsim.viewing.film.clips import frame_times

STATE, ENVIRONMENT, ACTION = "observation.state", "observation.environment_state", "action"
FORCES, CHANNELS = "observation.forces", "observation.channels"
DONE, SUCCESS = "next.done", "next.success"

_OF_ROLLOUTS: dict[str, tuple[str, ...]] = {
    STATE: ("joints", "forearm_position", "forearm_orientation"),
    ENVIRONMENT: ("object_position", "object_orientation", "object_joints"),
    FORCES: ("contact_force", "table_force"),
}
"""Which quantities make a feature; the hinges of objects only where all have the same."""
_WITHOUT_ARM = ("forearm_target_position", "forearm_target_orientation")
"""What is commanded beside the joints where no arm carries the hand."""
FPS_LIMITS = (1, 1000)
_ON_GRID = 1e-6
"""How far a sample may be from a frame and still be taken for it [s]."""


@dataclass(frozen=True, eq=False)
class Feature:
    """A column of a data set: a vector a frame.

    Attributes
    ----------
    name
        Its key.
    names : k
        Of the elements, with units.
    values : (n, k)
        float32, or bool.
    """

    name: str
    names: tuple[str, ...]
    values: npt.NDArray[np.float32] | npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Take:
    """An episode on the grid of a data set.

    Attributes
    ----------
    episode
        As given.
    time : (n,) [s]
        Since its start, multiples of a frame.
    features
        The same for all of a data set, but for their values.
    resampled
        Whether its samples were not on the grid.
    """

    episode: Episode
    time: Array
    features: tuple[Feature, ...]
    resampled: bool


@dataclass(frozen=True)
class Plan:
    """What a data set will hold.

    Attributes
    ----------
    fps
        Frames a second.
    left_out
        Columns that not all movements have.
    """

    fps: int
    left_out: tuple[str, ...]


def usual_fps(episodes: Sequence[Episode]) -> int:
    """Return the median rate of movements, as whole frames a second, which LeRobot counts in."""
    rates = [(len(each.time) - 1) / each.duration for each in episodes]
    return int(np.clip(round(float(np.median(rates))), *FPS_LIMITS))


def plan_of(episodes: Sequence[Episode], fps: int | None = None) -> Plan:
    """Return what a data set of these movements will hold.

    Raises
    ------
    InputError
        If there is no such rate, or movements do not belong together: grasps and recordings, or
        different hands.
    """
    low, high = FPS_LIMITS
    if fps is not None and not low <= fps <= high:
        raise InputError(f"{fps} frames a second; give {low} to {high}")
    first = episodes[0]
    for each in episodes:
        if (each.kind == "rollout") != (first.kind == "rollout"):
            raise InputError(
                f"'{each.name}' is of the kind {each.kind}, '{first.name}' a {first.kind}; export "
                "rollouts and recordings apart"
            )
        if _columns(_state(each)) != _columns(_state(first)) or _columns(_action(each)) != (
            _columns(_action(first))
        ):
            raise InputError(
                f"'{each.name}' and '{first.name}' differ in joints, actuators or base of the "
                "hand; export them apart"
            )
    common = _common(episodes)
    all_columns = [c for each in episodes for q in _optional(each) for c in q.columns]
    left_out = tuple(dict.fromkeys(c for c in all_columns if c not in common))
    return Plan(fps or usual_fps(episodes), left_out)


def take_of(episode: Episode, plan: Plan) -> Take:
    """Return an episode on the grid of a data set.

    Samples on the grid are taken as they are; others are interpolated.
    """
    time = frame_times(episode.duration, plan.fps)
    at = episode.time[0] + time
    on_grid = len(at) == len(episode.time) and np.abs(at - episode.time).max() < _ON_GRID
    if not on_grid:
        quantities = tuple(each.at(at, episode.time) for each in episode.quantities)
        episode = replace(episode, time=at, quantities=quantities)
    features = [_feature(STATE, _state(episode)), *_further(episode, plan)]
    features.append(_actions(episode))
    last = np.arange(len(time)) == len(time) - 1
    features.append(Feature(DONE, (), last[:, None]))
    if episode.success is not None:
        features.append(Feature(SUCCESS, (), (last & episode.success)[:, None]))
    return Take(episode, time, tuple(features), not on_grid)


def _further(episode: Episode, plan: Plan) -> list[Feature]:
    """Return the observations beside the joints."""
    kept = [q for q in _optional(episode) if not set(q.columns) & set(plan.left_out)]
    if episode.kind != "rollout":
        return [_feature(CHANNELS, kept)] if kept else []
    environment = [q for q in kept if q.name in _OF_ROLLOUTS[ENVIRONMENT]]
    forces = [q for q in kept if q.name in _OF_ROLLOUTS[FORCES]]
    return [_feature(ENVIRONMENT, environment), _feature(FORCES, forces)]


def _actions(episode: Episode) -> Feature:
    """Return what is commanded; for a person, who tells no commands, the posture of the next frame.

    The last frame keeps its own.
    """
    if episode.kind == "rollout":
        return _feature(ACTION, _action(episode))
    (joints,) = _action(episode)
    names = tuple(f"{column}_target" for column in joints.columns)
    following = np.concatenate([joints.values[1:], joints.values[-1:]])
    return _feature(ACTION, [replace(joints, columns=names, values=following)])


def _state(episode: Episode) -> list[Quantity]:
    return [q for q in episode.quantities if q.name in _OF_ROLLOUTS[STATE]]


def _action(episode: Episode) -> list[Quantity]:
    if episode.kind != "rollout":
        return [q for q in episode.quantities if q.name == "joints"]
    free = episode.quantity("forearm_position") is not None
    names = ("targets", *(_WITHOUT_ARM if free else ()))
    return [q for q in episode.quantities if q.name in names]


def _optional(episode: Episode) -> list[Quantity]:
    """Return what is observed beside the joints, as far as it has a value in every frame."""
    names = (*_OF_ROLLOUTS[ENVIRONMENT], *_OF_ROLLOUTS[FORCES])
    rollout = episode.kind == "rollout"
    return [q for q in episode.quantities if (q.name in names if rollout else q.name != "joints")]


def _common(episodes: Sequence[Episode]) -> set[str]:
    """Return the columns that all have, and without a gap."""
    whole = [
        {c for q in _optional(each) if np.isfinite(q.values).all() for c in q.columns}
        for each in episodes
    ]
    return set.intersection(*whole)


def _columns(quantities: Sequence[Quantity]) -> list[tuple[str, str]]:
    return [pair for q in quantities for pair in zip(q.columns, q.units, strict=True)]


def _feature(name: str, quantities: Sequence[Quantity]) -> Feature:
    values = np.concatenate([q.values for q in quantities], axis=1).astype(np.float32)
    names = tuple(f"{c}_{unit.lower()}" if unit else c for c, unit in _columns(quantities))
    return Feature(name, names, values)
