"""The environment ``handsim/Grasp-v0``."""

from dataclasses import asdict
from typing import Any, ClassVar

import gymnasium

from handsim.environments.asked import ControllerAsked, HandAsked, grasped, hand_asked
from handsim.environments.entries import (
    ActionKind,
    action_entry,
    box_of,
    checked_action,
    dict_of,
)
from handsim.environments.painting import Painter
from handsim.environments.rewards import SUCCESS
from handsim.environments.watched_runs import WatchedRuns
from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.glove import RATE
from handsim.grasping.rollout.record import Rollout
from handsim.tasks.task import Task
from handsim.types import Array, Base, Frame
from handsim.viewing.film.offscreen import View

RENDER_MODES = ("rgb_array",)


class GraspEnv(gymnasium.Env[dict[str, Array], Array]):
    """A grasp of `handsim grasp`, whose fingers a policy commands a hundred times a second.

    Scene, arm, glove, schedule, perturbations and rules are those of `handsim grasp`. The palm goes
    where the plan says, and from touch on fingers hold with a force as there, except where the
    policy tells joint targets.

    A run has as many steps as the task's schedule has readings. At its end the rules of the task
    judge it: ``terminated`` is then True, because the verdict is there, and ``truncated`` is too,
    because the task's time is over. Where the simulation diverges ``terminated`` alone is True; so
    it is with ``brief`` where the object is lost. ``info`` then has ``is_success``, ``reason`` (of
    failure, or empty) and ``outcome``, with all that `handsim grasp --json` says of a run;
    `rollout` is its record.

    The reward is that of `DenseReward`, and `SUCCESS` where the run succeeds.

    Parameters
    ----------
    task
        One of the 24 tasks by its name, or a task.
    hand
        A size, a side, or names of `handsim hands`: ``"left"``, ``"woman-5"``, ``"man-95 left"``.
    action
        ``components``: velocities in the controller's principal components; ``joints``: targets of
        the 22 joints, which go straight to the actuators. `action_meaning` says all of it.
    base
        What carries the hand: the person's ``arm``, or a ``free`` base.
    controller
        In whose components actions and observations are, and whose plans are used: a controller or
        its file; by default the built-in one.
    plan
        Where the palm goes; by default that of `handsim grasp`. One that is not known is searched,
        which takes a minute or more.
    perturbed
        Whether runs are perturbed as trials of `handsim grasp` are.
    brief
        End a run as soon as its object is lost. The reason is then told by what there is of it.
    render_mode
        ``rgb_array``, or None for none.
    camera, width, height
        Of pictures, as of `handsim.render`.

    Attributes
    ----------
    action_meaning, observation_meaning
        Names, units, frames and bounds of every entry.
    grasped
        Task, nominal conditions, controller and plan.
    rollout
        The record of the run that has ended last; None before the first has.

    Raises
    ------
    UnknownNameError
        If there is no such task, hand or kind of action.
    InputError
        If the hand is a file, or a size cannot be built or drawn.
    """

    metadata: ClassVar[dict[str, Any]] = {  # pyright: ignore[reportIncompatibleVariableOverride]
        "render_modes": list(RENDER_MODES),
        "render_fps": round(RATE),
    }

    def __init__(
        self,
        task: Task | str = "cube-raise",
        hand: HandAsked = None,
        action: ActionKind = "components",
        *,
        base: Base = "arm",
        controller: ControllerAsked = None,
        plan: GraspPlan | None = None,
        perturbed: bool = False,
        brief: bool = False,
        render_mode: str | None = None,
        camera: str = "view",
        width: int = 640,
        height: int = 480,
    ) -> None:
        if render_mode not in (None, *RENDER_MODES):
            raise InputError(f"render_mode '{render_mode}' is not known; give rgb_array or None")
        self.render_mode = render_mode
        action_entry(action, 1)  # before a plan is searched
        conditions = Conditions(hand=hand_asked(hand), base=base)
        self._painter = Painter(View(camera, width, height))
        known = grasped(task, conditions, controller, plan)
        self._runs = runs = WatchedRuns(known, action, perturbed=perturbed, brief=brief)
        self.grasped, self.task, self.schedule = known, runs.task, runs.schedule
        self.action_meaning, self.observation_meaning = (
            runs.action_meaning,
            runs.observation_meaning,
        )
        self.action_space = box_of(self.action_meaning)
        self.observation_space = dict_of(self.observation_meaning)
        self.rollout: Rollout | None = None

    @property
    def scene(self) -> Scene | None:
        """The scene of the latest run; None before the first."""
        return self._runs.scene

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Array], dict[str, Any]]:
        """Begin a run.

        Parameters
        ----------
        seed
            Of the glove's noise and of the perturbations, as of `handsim grasp`: the same seed is
            the same trial, to the bit. None draws one.
        options
            ``perturbed``: whether this run is perturbed; ``hard``: the one thing in which it is,
            and hard, as by ``--hard``.

        Returns
        -------
        observation, info
            ``info["trial"]`` says the conditions of the run, the seed among them.
        """
        super().reset(seed=seed)
        trial = int(self.np_random.integers(2**31)) if seed is None else seed
        conditions = self._runs.conditions(trial, options or {})
        (first,) = self._runs.begin([conditions])
        return self._runs.named(first), {"trial": conditions.as_dict()}

    def step(self, action: Array) -> tuple[dict[str, Array], float, bool, bool, dict[str, Any]]:
        """Command by an action and go on by a hundredth of a second.

        Raises
        ------
        InputError
            If the action has another size or a number is not finite, or if the run has ended.
        """
        runs = self._runs
        if runs.episode.over:
            raise InputError("the run has ended; reset the environment before the next step")
        given = checked_action(action, (self.action_meaning.size,))
        (row,), (parts,), (reward,) = runs.step(given[None])
        seen = runs.named(row)
        info: dict[str, Any] = {**parts}
        if not runs.episode.over:
            return seen, reward, False, False, info
        (self.rollout,) = runs.episode.records()
        info |= verdict_of(self.rollout)
        reward += SUCCESS * info["is_success"]
        whole = len(self.rollout.time) == runs.episode.n_readings
        return seen, reward, True, whole and not runs.episode.unstable[0], info

    def render(self) -> Frame | None:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Return a picture of the run as it stands, (height, width, 3); None without a mode."""
        if self.render_mode is None:
            gymnasium.logger.warn("render() draws nothing; make it with render_mode='rgb_array'")
            return None
        episode, scene = self._runs.episode, self._runs.scene
        assert scene is not None  # there is one once there is an episode
        return self._painter.paint(scene.model, episode.rows[0].qpos, episode.time)

    def close(self) -> None:
        """Free what pictures need."""
        self._painter.close()


def verdict_of(rollout: Rollout) -> dict[str, Any]:
    """Return what the last ``info`` of a run says of it."""
    outcome = rollout.outcome
    return {
        "is_success": outcome.success,
        "reason": outcome.reason or "",
        "outcome": asdict(outcome),
    }
