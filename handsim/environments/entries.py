"""What actions and observations hold: names, units, frames and bounds of every entry.

All numbers are 64-bit floats: what an observation tells of the controller is then what it works
with, and a policy that does as the controller does gives the same movement.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from gymnasium import spaces

from handsim.errors import InputError, UnknownNameError
from handsim.joints import CONTACT_PARTS, FINGERS, JOINT_NAMES, LOWER, N_JOINTS, UPPER
from handsim.types import Array

ActionKind = Literal["components", "joints"]
ACTION_KINDS: tuple[ActionKind, ...] = ("components", "joints")
SPEED = 8.0
"""Velocity of a component for an action of 1 [rad/s]. Those of the built-in controller reach 5. A
power of 2, so that dividing by it loses no bit."""
PHASES = ("reach", "squeeze", "action", "hold")


@dataclass(frozen=True)
class Entry:
    """One named part of an action or an observation.

    Attributes
    ----------
    name
        Of the part; the key of an observation.
    numbers
        What each of its numbers is.
    unit
        Of its numbers as they are: those of an action as it is given.
    meaning
        What it is, and in which frame.
    low, high
        Bounds of each number. What is beyond is cut off.
    """

    name: str
    numbers: tuple[str, ...]
    unit: str
    meaning: str
    low: float
    high: float

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return len(self.numbers)


def action_entry(kind: ActionKind, n_components: int) -> Entry:
    """Return what an action of a kind is.

    Raises
    ------
    UnknownNameError
        If there is no such kind.
    """
    if kind == "components":
        return Entry(
            "velocity",
            _components(n_components),
            f"{SPEED:g} rad/s",
            "velocity of the hand in the controller's principal components; the arm goes as "
            "planned, and fingers that have touched hold with a force",
            -1.0,
            1.0,
        )
    if kind == "joints":
        return Entry(
            "targets",
            JOINT_NAMES,
            "half of the joint's range",
            "target of each joint's position actuator, from -1, the lower end of its range of "
            "motion, to 1, the upper one; the arm goes as planned, and the two joints of the wrist "
            "with it",
            -1.0,
            1.0,
        )
    raise UnknownNameError("action", kind, ACTION_KINDS)


def observation_entries(n_components: int, seconds: float) -> tuple[Entry, ...]:
    """Return what an observation is, for a controller and the duration of a run [s]."""
    xyz, sides = ("x", "y", "z"), _components(n_components)
    tips = tuple(f"{finger} {axis}" for finger in FINGERS for axis in xyz)
    return (
        Entry("posture", JOINT_NAMES, "rad", "joint angles as the glove reads them", -4.0, 4.0),
        Entry("components", sides, "rad",
              "where the hand is meant to be in the subspace, drawn a little to each reading of "
              "the reach; for joint targets, the reading there", -20.0, 20.0),
        Entry("destination", sides, "rad", "where the plan has the grasp in the subspace",
              -20.0, 20.0),
        Entry("need", ("force",), "N", "least force a side that the planned grasp needs",
              0.0, 1000.0),
        Entry("fingertips", tips, "m", "tips of the fingers, object's frame", -3.0, 3.0),
        Entry("palm_position", xyz, "m", "origin of the palm, object's frame", -3.0, 3.0),
        Entry("palm_orientation", ("w", "x", "y", "z"), "1",
              "quaternion of the palm, object's frame; w is not negative", -1.0, 1.0),
        Entry("forces", CONTACT_PARTS, "N", "normal force of each part of the hand on the object",
              0.0, 1000.0),
        Entry("object_shift", xyz, "m", "way of the object's centre of mass so far, world frame",
              -3.0, 3.0),
        Entry("hinge", ("angle",), "rad", "the object's hinge that the rule is about, or 0",
              -7.0, 7.0),
        Entry("progress", PHASES, "1", "share of each phase that has passed", 0.0, 1.0),
        Entry("time", ("time",), "s", "since the start", 0.0, seconds),
    )  # fmt: skip


def box_of(entry: Entry) -> spaces.Space[Array]:
    """Return the space of one entry, (size,)."""
    box: Any = spaces.Box(entry.low, entry.high, (entry.size,), np.float64)
    return box


def dict_of(entries: Sequence[Entry]) -> spaces.Space[dict[str, Array]]:
    """Return the space of several entries, by their names."""
    spaces_by_name: Any = spaces.Dict({entry.name: box_of(entry) for entry in entries})
    return spaces_by_name


def checked_action(action: Array, shape: tuple[int, ...]) -> Array:
    """Return an action, or several, of a shape (..., size) within -1 and 1.

    Raises
    ------
    InputError
        If it has another shape, or a number is not finite.
    """
    given = np.asarray(action, dtype=float)
    if given.shape == shape:
        for number in given.ravel().tolist():
            if not -1.0 <= number <= 1.0:
                break
        else:
            return given
    if given.shape != shape or not np.isfinite(given).all():
        asked = " x ".join(str(n) for n in shape)
        raise InputError(f"action of shape {given.shape}; give {asked} finite numbers of -1 to 1")
    return np.minimum(np.maximum(given, -1.0), 1.0)


def targets_of(action: Array) -> Array:
    """Return the joint targets (..., 22) [rad] of actions (..., 22) of kind ``joints``."""
    return LOWER + 0.5 * (action + 1.0) * (UPPER - LOWER)


def action_of(targets: Array) -> Array:
    """Return the actions (..., 22) of kind ``joints`` whose targets (..., 22) [rad] are given.

    Raises
    ------
    InputError
        If they are not 22 a row.
    """
    q = np.asarray(targets, dtype=float)
    if q.shape[-1:] != (N_JOINTS,):
        raise InputError(f"targets of shape {q.shape}; give {N_JOINTS} angles a row")
    return np.clip(2.0 * (q - LOWER) / (UPPER - LOWER) - 1.0, -1.0, 1.0)


def _components(n: int) -> tuple[str, ...]:
    return tuple(f"component {i + 1}" for i in range(n))
