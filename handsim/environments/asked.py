"""What is grasped, by which hand, controller and plan: from the words of `gymnasium.make`."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

from handsim.errors import InputError, UnknownNameError
from handsim.files import data_folder
from handsim.grasping.conditions import Conditions
from handsim.grasping.gripping.need import LEAST
from handsim.grasping.plan import GraspPlan
from handsim.grasping.planning.expected_need import expected_need
from handsim.grasping.planning.grasper import ControllerGrasper
from handsim.grasping.planning.plan_store import (
    PlanStore,
    plan_store,
    shipped_folder,
    shipped_plans,
    usual_store,
)
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.hand.population import PRESETS, preset
from handsim.learning.controller import GraspController
from handsim.tasks.table_one import task_by_name
from handsim.tasks.task import Task
from handsim.types import MEDIAN_HAND, SIDES, HandSize

HandAsked = HandSize | str | None
ControllerAsked = GraspController | Path | str | None
_FILES = (".xml", ".mjcf", ".urdf")


@dataclass(frozen=True)
class Grasped:
    """All that stays the same from one run of an environment to the next.

    Attributes
    ----------
    task
        For a right hand.
    conditions
        Nominal ones, with the hand and what carries it.
    controller, plan
    need : [N]
        Least force a side that the grasp is expected to need.
    """

    task: Task
    conditions: Conditions
    controller: GraspController
    plan: GraspPlan
    need: float


def hand_asked(hand: HandAsked) -> HandSize:
    """Return a hand by its size, its side or the name of a preset, such as ``woman-5 left``.

    Raises
    ------
    InputError
        If a file of a robot hand is given.
    UnknownNameError
        If the name is not known.
    """
    if hand is None:
        return MEDIAN_HAND
    if isinstance(hand, HandSize):
        return hand
    if hand.lower().endswith(_FILES):
        raise InputError(
            f"hand '{hand}' is a robot hand's file, and environments have people's hands; "
            "`handsim grasp --hand FILE` lets a robot hand grasp"
        )
    size, side = MEDIAN_HAND, None
    for word in hand.split():
        if word in SIDES:
            side = word
        elif word in PRESETS:
            size = preset(word)
        else:
            raise UnknownNameError("hand", word, (*PRESETS, *SIDES), "handsim hands")
    return HandSize(size.length, size.breadth, side or size.side)


def controller_asked(controller: ControllerAsked) -> GraspController:
    """Return a controller; by default the built-in one, otherwise from its file."""
    if isinstance(controller, GraspController):
        return controller
    return _built_in() if controller is None else GraspController.load(Path(controller))


def grasped(
    task: Task | str,
    conditions: Conditions,
    controller: ControllerAsked = None,
    plan: GraspPlan | None = None,
) -> Grasped:
    """Return what an environment is about; a plan that is not known is searched first.

    Plans are looked up where `handsim grasp` keeps them. One that is searched, which takes a minute
    or more, is kept in memory alone, for all environments of the process.

    Parameters
    ----------
    task
        A task, or the name of one of Table I.
    conditions
        Nominal ones.
    controller
        A controller or its file; by default the built-in one.
    plan
        Where palm and fingers go; by default the one that `handsim grasp` takes.
    """
    chosen = task_by_name(task) if isinstance(task, str) else task
    learned = controller_asked(controller)
    if plan is None:
        path = None if isinstance(controller, GraspController | None) else Path(controller)
        grasper = _grasper(learned, path, conditions)
        plan = grasper.plan_for(chosen, Scene.build(chosen, conditions))
    need = expected_need(chosen) if chosen.rule.lifted else LEAST
    return Grasped(chosen, conditions, learned, plan, need)


@cache
def _built_in() -> GraspController:
    return GraspController.load(data_folder("assets") / "controller.npz")


@cache
def _grasper(
    controller: GraspController, path: Path | None, conditions: Conditions
) -> ControllerGrasper:
    """Return what knows the plans of a controller for a hand."""
    shared: list[PlanStore] = [shipped_plans(controller.digest, conditions)]
    if path is not None:
        shared.insert(0, plan_store(path.with_suffix(".plans"), controller.digest, conditions))
    hints = (
        shipped_plans(_built_in().digest, conditions),
        *usual_store(shipped_folder(), _built_in().digest, conditions),
    )
    return ControllerGrasper(controller, hints=hints, shared=tuple(shared))
