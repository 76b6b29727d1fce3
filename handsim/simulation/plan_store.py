"""Plans on disk: what has been planned once is not planned again."""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from handsim.errors import FileError
from handsim.files import read_text, write_text
from handsim.joints import N_JOINTS, Array
from handsim.simulation.conditions import Conditions
from handsim.simulation.plan import GraspPlan, Pose

SCHEMA = 1
MAX_VALUE = 1000.0
"""Bound on every number of a plan, which are metres, degrees and factors."""


def plan_key(controller_digest: str, conditions: Conditions) -> str:
    """Return the key under which plans of one controller and one hand are kept."""
    hand = f"{conditions.hand_length:.6f} {conditions.hand_breadth:.6f} {conditions.side}"
    return hashlib.sha256(f"{controller_digest} {hand}".encode()).hexdigest()[:16]


@dataclass(frozen=True)
class PlanStore:
    """Plans kept in one JSON file, by task, for one controller and one hand.

    Attributes
    ----------
    path
        The file; it appears with the first plan.
    """

    path: Path

    def read(self) -> dict[str, GraspPlan]:
        """Return the plans by task, those that are known not to hold included.

        Raises
        ------
        FileError
            If the file is there and cannot be read.
        """
        try:
            return {task: _from_json(plan) for task, plan in self._stored().items()}
        except (ValueError, KeyError, TypeError) as error:
            raise self._unreadable(error) from error

    def _stored(self) -> dict[str, dict[str, Any]]:
        if not self.path.is_file():
            return {}
        try:
            stored = json.loads(read_text(self.path))
            if stored["schema"] > SCHEMA:
                raise FileError(
                    f"{self.path}: plans of schema {stored['schema']}, newer than {SCHEMA}; "
                    "update handsim or delete the file"
                )
            return dict(stored["plans"])
        except FileError:
            raise
        except (ValueError, KeyError, TypeError, RecursionError) as error:
            raise self._unreadable(error) from error

    def _unreadable(self, error: Exception) -> FileError:
        return FileError(f"{self.path}: not a file of plans ({error}); delete it")

    def add(self, task: str, plan: GraspPlan, held: bool) -> None:
        """Keep a plan and whether its nominal run held; those of other tasks stay."""
        plans = self._stored() | {task: _to_json(plan) | {"held": held}}
        content = {"schema": SCHEMA, "plans": {name: plans[name] for name in sorted(plans)}}
        self.path.parent.mkdir(exist_ok=True)
        write_text(self.path, json.dumps(content, indent=1) + "\n")


def _to_json(plan: GraspPlan) -> dict[str, Any]:
    return {
        "palm_pos_m": plan.palm.pos.tolist(),
        "palm_quat_wxyz": plan.palm.quat.tolist(),
        "retreat_m": plan.retreat.tolist(),
        "q_start_deg": np.rad2deg(plan.q_start).tolist(),
        "q_goal_deg": np.rad2deg(plan.q_goal).tolist(),
        "squeeze": plan.squeeze,
        "arrive": plan.arrive,
    }


def _from_json(stored: dict[str, Any]) -> GraspPlan:
    squeeze, arrive = stored["squeeze"], stored.get("arrive", GraspPlan.arrive)
    return GraspPlan(
        Pose(_numbers(stored["palm_pos_m"], 3), _numbers(stored["palm_quat_wxyz"], 4)),
        _numbers(stored["retreat_m"], 3),
        np.deg2rad(_numbers(stored["q_start_deg"], N_JOINTS)),
        np.deg2rad(_numbers(stored["q_goal_deg"], N_JOINTS)),
        *_numbers([squeeze, arrive], 2).tolist(),
    )


def _numbers(stored: Any, n: int) -> Array:
    values = np.array(stored, dtype=float)
    if values.shape != (n,) or not (np.abs(values) < MAX_VALUE).all():
        raise ValueError(f"{n} numbers below {MAX_VALUE:g} are expected")
    return values
