"""Plans on disk, so that no plan is searched twice."""

import hashlib
import json
from base64 import b64decode, b64encode
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from handsim.errors import FileError
from handsim.files import data_folder, read_text, write_text
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan, Pose
from handsim.grasping.planning.plan_key import PlanKey
from handsim.joints import N_JOINTS
from handsim.types import MEDIAN_HAND, Array, HandSize

SCHEMA = 2  # 1: postures in degrees, neither destinations in the subspace nor keys; still read
MAX_VALUE = 1000.0
"""Bound on every number of a plan: metres, radians (in schema 1, degrees) and factors."""
MAX_COMPONENTS = 5
"""Greatest number of coordinates of a destination in a subspace."""

_Stored = dict[str, Any]
Note = Callable[[str], None]
"""Called with a line of text for people."""


@dataclass(frozen=True)
class StoredPlan:
    """A plan, what it was made for, and whether it holds.

    Attributes
    ----------
    plan
    held
        Whether its nominal run held.
    key
        What it was made for; None where a file of schema 1 does not say.
    attempts
        Number of searches made for it, each with seeds of its own.
    hand
        Size and side of the hand that it was made for; None where that is not known. It does not
        stand in the file: the store knows it.
    mapped : (k, m)
        Coordinates to which a robot hand's movement was mapped when the plan was tried [rad or m];
        None for a person's hand.
    """

    plan: GraspPlan
    held: bool
    key: PlanKey | None = None
    attempts: int = 1
    hand: HandSize | None = None
    mapped: Array | None = None


@dataclass(frozen=True)
class PlanStore:
    """Plans kept in one JSON file, by task, for one controller and one hand.

    Every bit of a number is kept.

    Attributes
    ----------
    path
        The file; it appears with the first plan.
    owner
        Digest of the controller and the hand, as in `plan_store`; a file that names another owner
        is refused. Empty takes any.
    controller
        Digest of the controller, where it is known.
    hand
        Size and side of the hand, where they are known.
    """

    path: Path
    owner: str = ""
    controller: str = ""
    hand: HandSize | None = None

    def entries(self) -> dict[str, StoredPlan]:
        """Return what is stored, by task, even plans that do not hold or fit.

        Raises
        ------
        FileError
            If the file is there and cannot be read, or holds plans of another controller, hand or
            task.
        """
        schema, plans = self._stored()
        try:
            entries = {name: _entry(name, stored, schema) for name, stored in plans.items()}
        except _UNREADABLE as error:
            raise self._unreadable(error) from error
        return {name: replace(each, hand=self.hand) for name, each in entries.items()}

    def read(self) -> dict[str, GraspPlan]:
        """Return the plans by task; otherwise as `entries`."""
        return {name: each.plan for name, each in self.entries().items()}

    def add(self, task: str, stored: StoredPlan) -> None:
        """Store a plan of a task in place of an earlier one.

        Raises
        ------
        FileError
            If the file cannot be written, or is there and cannot be read; it stays as it is.
        """
        known = self.entries() | {task: stored}
        content = {
            "schema": SCHEMA,
            "owner": self.owner,
            "plans": {name: _to_json(name, known[name]) for name in sorted(known)},
        }
        try:
            self.path.parent.mkdir(exist_ok=True)
            write_text(self.path, json.dumps(content, indent=1, allow_nan=False) + "\n")
        except OSError as error:
            raise FileError(f"{self.path}: cannot be written ({error.strerror})") from error

    def keep(self, task: str, stored: StoredPlan, note: Note | None) -> None:
        """Store a plan as `add`; where the store cannot be written, a line says so and that is all.

        Parameters
        ----------
        task, stored
        note
            Called with that line.
        """
        try:
            self.add(task, stored)
        except (FileError, OSError) as error:
            if note is not None:
                note(f"plan of {task} is used, but could not be kept: {error}")

    def _stored(self) -> tuple[int, dict[str, _Stored]]:
        """Return schema and plans as they are in the file."""
        if not self.path.is_file():
            return SCHEMA, {}
        try:
            stored = json.loads(read_text(self.path))
            schema = stored["schema"]
            if not isinstance(schema, int) or schema < 1:
                raise ValueError(f"schema {schema!r}")
            if schema > SCHEMA:
                raise FileError(
                    f"{self.path}: plans of schema {schema}, newer than {SCHEMA}; "
                    "update handsim or delete the file"
                )
            plans = dict(stored["plans"])
            owner = str(stored["owner"]) if schema > 1 else ""
        except FileError:
            raise
        except _UNREADABLE as error:
            raise self._unreadable(error) from error
        if owner and self.owner and owner != self.owner:
            raise FileError(
                f"{self.path}: holds plans of another controller or hand ({owner!r} instead "
                f"of '{self.owner}'); put it back where it came from, or delete it"
            )
        return schema, plans

    def _unreadable(self, error: Exception) -> FileError:
        told = str(error) if isinstance(error, ValueError) else repr(error)
        return FileError(f"{self.path}: not a file of plans ({told}); delete it")


_UNREADABLE = (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError)


def plan_store(folder: Path, controller_digest: str, conditions: Conditions) -> PlanStore:
    """Return the store, in a folder, of a controller's plans for the hand of the conditions.

    The file is named after its owner, so that the files of several owners lie in one folder.

    Parameters
    ----------
    folder
    controller_digest
        `GraspController.digest`.
    conditions
        Only size (to a micrometre) and side of the hand count, and what carries it.
    """
    size = counted(conditions.hand)
    hand = f"{size.length:.6f} {size.breadth:.6f} {size.side} {conditions.base}"
    return store_of(folder, controller_digest, hand, size)


def store_of(
    folder: Path, controller_digest: str, hand: str, size: HandSize | None = None
) -> PlanStore:
    """Return the store of a controller's plans for a hand of which a text says all.

    ``size`` is that of a person's hand.
    """
    owner = hashlib.sha256(f"{controller_digest} {hand}".encode()).hexdigest()[:16]
    return PlanStore(folder / f"{owner}.json", owner, controller_digest, size)


def usual_store(
    folder: Path, controller_digest: str, conditions: Conditions
) -> tuple[PlanStore, ...]:
    """Return the store of the hand with which searches for the hand of the conditions begin.

    It is that of the right hand of a man of median size on an arm, for which most plans are made;
    none for this hand itself. The parameters are those of `plan_store`.
    """
    if counted(conditions.hand) == MEDIAN_HAND:
        return ()
    return (plan_store(folder, controller_digest, Conditions()),)


def counted(size: HandSize) -> HandSize:
    """Return a size as it counts for plans, to a micrometre."""
    return replace(size, length=round(size.length, 6), breadth=round(size.breadth, 6))


def shipped_folder() -> Path:
    """Return the folder of the plans that come with the package, for the built-in controller."""
    return data_folder("assets") / "plans"


def shipped_plans(digest: str, conditions: Conditions) -> PlanStore:
    """Return what comes with the package for a controller of that digest: no plans for most."""
    return plan_store(shipped_folder(), digest, conditions)


def _to_json(task: str, stored: StoredPlan) -> _Stored:
    plan = stored.plan
    mapped = {} if stored.mapped is None else {"mapped": _packed(stored.mapped)}
    return {
        "task": task,
        "key": stored.key and asdict(stored.key),
        "held": stored.held,
        "attempts": stored.attempts,
        "palm_pos_m": plan.palm.pos.tolist(),
        "palm_quat_wxyz": plan.palm.quat.tolist(),
        "retreat_m": plan.retreat.tolist(),
        "q_start_rad": plan.q_start.tolist(),
        "q_goal_rad": plan.q_goal.tolist(),
        "z_goal_rad": None if plan.z_goal is None else plan.z_goal.tolist(),
        "squeeze": plan.squeeze,
        "grip_n": plan.grip,
        "arrive": plan.arrive,
        **mapped,
    }


def _packed(rows: Array) -> _Stored:
    """Return a table of numbers as text: some thousand of them, which nobody reads one by one."""
    content = np.ascontiguousarray(rows, dtype="<f8").tobytes()
    return {"shape": list(rows.shape), "float64_base64": b64encode(content).decode()}


def _unpacked(stored: _Stored) -> Array:
    content = b64decode(stored["float64_base64"], validate=True)
    rows = np.frombuffer(content, dtype="<f8").astype(float)
    if not (np.abs(rows) < MAX_VALUE).all():
        raise ValueError(f"mapped coordinates below {MAX_VALUE:g} are expected")
    return rows.reshape(*_shape(stored["shape"]))


def _shape(stored: Any) -> tuple[int, int]:
    rows, columns = stored
    if not (isinstance(rows, int) and isinstance(columns, int) and rows > 0 and columns > 0):
        raise ValueError(f"mapped coordinates of shape {stored!r}")
    return rows, columns


def _entry(task: str, stored: _Stored, schema: int) -> StoredPlan:
    held = stored.get("held", False) if schema == 1 else stored["held"]
    if not isinstance(held, bool):
        raise ValueError(f"held of {task!r} is {held!r}")
    if schema == 1:
        return StoredPlan(_plan(stored, "deg"), held)
    if stored["task"] != task:
        raise ValueError(f"the plan under {task!r} is of {stored['task']!r}")
    attempts = stored["attempts"]
    if not isinstance(attempts, int) or attempts < 0:
        raise ValueError(f"attempts of {task!r} are {attempts!r}")
    key = None if stored["key"] is None else _key(stored["key"])
    mapped = _unpacked(stored["mapped"]) if "mapped" in stored else None
    return StoredPlan(_plan(stored, "rad"), held, key, attempts, mapped=mapped)


def _key(stored: _Stored) -> PlanKey:
    return PlanKey(**{each.name: str(stored[each.name]) for each in fields(PlanKey)})


def _plan(stored: _Stored, unit: str) -> GraspPlan:
    usual = {"grip_n": GraspPlan.grip, "arrive": GraspPlan.arrive} | stored
    squeeze, grip, arrive = _numbers([usual[name] for name in ("squeeze", "grip_n", "arrive")], 3)
    if not (squeeze >= 0 and grip > 0 and 0 < arrive <= 1):
        raise ValueError(
            f"squeeze {squeeze:g}, grip {grip:g} N or arrival {arrive:g} is out of range"
        )
    quat = _numbers(stored["palm_quat_wxyz"], 4)
    if abs(np.linalg.norm(quat) - 1.0) > 1e-6:
        raise ValueError("the palm's quaternion is not of length 1")
    q_start, q_goal = (_numbers(stored[f"q_{end}_{unit}"], N_JOINTS) for end in ("start", "goal"))
    if unit == "deg":
        q_start, q_goal = np.deg2rad(q_start), np.deg2rad(q_goal)
    z_goal = stored["z_goal_rad"] if unit == "rad" else None
    if z_goal is not None:
        z_goal = _numbers(z_goal, max(1, min(len(z_goal), MAX_COMPONENTS)))
    return GraspPlan(
        Pose(_numbers(stored["palm_pos_m"], 3), quat),
        _numbers(stored["retreat_m"], 3),
        q_start,
        q_goal,
        float(squeeze),
        float(grip),
        float(arrive),
        z_goal,
    )


def _numbers(stored: Any, n: int) -> Array:
    values = np.array(stored, dtype=float)
    if values.shape != (n,) or not (np.abs(values) < MAX_VALUE).all():
        raise ValueError(f"{n} numbers below {MAX_VALUE:g} are expected")
    return values
