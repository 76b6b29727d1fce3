"""Several grasps side by side in one batch of simulations: what `gymnasium.make_vec` makes."""

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from handsim.environments.asked import ControllerAsked, HandAsked, grasped, hand_asked
from handsim.environments.entries import (
    ActionKind,
    action_entry,
    box_of,
    checked_action,
    dict_of,
)
from handsim.environments.grasp_env import verdict_of
from handsim.environments.rewards import PARTS, SUCCESS
from handsim.environments.watched_runs import Observed, WatchedRuns
from handsim.errors import InputError
from handsim.grasping.conditions import Conditions
from handsim.grasping.plan import GraspPlan
from handsim.grasping.rollout.record import Rollout
from handsim.tasks.task import Task
from handsim.types import Array, Base, Mask
from handsim.wording import number_of


class GraspVectorEnv(VectorEnv[Observed, Array, Any]):
    """Grasps of one task and hand as of `GraspEnv`, whose runs begin and end together.

    They are stepped in one of MuJoCo's batches, which costs less than one by one: what is commanded
    is computed for all at once. Each run gives the bits that it gives by itself. One that diverges
    shows what it showed last, and ends with the others. When all have ended the next step begins
    new ones (``AutoresetMode.NEXT_STEP``).

    Parameters
    ----------
    num_envs
        How many.
    task, hand, action, base, controller, plan, perturbed
        As of `GraspEnv`.

    Attributes
    ----------
    grasped, action_meaning, observation_meaning
        As of `GraspEnv`.
    rollouts
        The records of the runs that have ended last.

    Raises
    ------
    UnknownNameError, InputError
        As of `GraspEnv`.
    """

    metadata: ClassVar[dict[str, Any]] = {  # pyright: ignore[reportIncompatibleVariableOverride]
        "autoreset_mode": AutoresetMode.NEXT_STEP
    }

    def __init__(
        self,
        num_envs: int = 1,
        task: Task | str = "cube-raise",
        hand: HandAsked = None,
        action: ActionKind = "components",
        *,
        base: Base = "arm",
        controller: ControllerAsked = None,
        plan: GraspPlan | None = None,
        perturbed: bool = False,
    ) -> None:
        if num_envs < 1:
            raise InputError(f"{num_envs} environments; give 1 or more")
        action_entry(action, 1)  # before a plan is searched
        conditions = Conditions(hand=hand_asked(hand), base=base)
        known = grasped(task, conditions, controller, plan)
        self._runs = runs = WatchedRuns(known, action, perturbed=perturbed)
        self.grasped, self.num_envs = known, num_envs
        self.action_meaning, self.observation_meaning = (
            runs.action_meaning,
            runs.observation_meaning,
        )
        self.single_action_space = box_of(self.action_meaning)
        self.single_observation_space = dict_of(self.observation_meaning)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.rollouts: list[Rollout] = []
        self._options: dict[str, Any] = {}

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observed, dict[str, Any]]:
        """Begin runs.

        Parameters
        ----------
        seed
            Of each run, or of the first: the others have those that follow.
        options
            As of `GraspEnv.reset`; runs that begin by themselves later have them too.
        """
        first = seed if isinstance(seed, int) else None
        super().reset(seed=first)
        seeds = [None] * self.num_envs if seed is None else seed
        if isinstance(seeds, int):
            seeds = range(seeds, seeds + self.num_envs)
        if len(seeds) != self.num_envs:
            raise InputError(
                f"{number_of(len(seeds), 'seed')} for {self.num_envs} environments; give one each"
            )
        self._options = options or {}
        return self._begin(seeds)

    def step(self, actions: Array) -> tuple[Observed, Array, Mask, Mask, dict[str, Any]]:
        """Command by actions (num_envs, size), or begin new runs where all have ended.

        Raises
        ------
        InputError
            If one of them is none, as of `GraspEnv.step`.
        """
        n, runs = self.num_envs, self._runs
        over = np.zeros(n, dtype=bool)
        if runs.episode.over:
            seen, info = self._begin([None] * n)
            return seen, np.zeros(n), over, over.copy(), info
        given = checked_action(actions, (n, self.action_meaning.size))
        rows, parts, rewards = runs.step(given)
        seen = runs.named(rows)
        reward, info = np.array(rewards), dict[str, Any]()
        for name in PARTS:
            info[name] = np.array([each[name] for each in parts])
            info[f"_{name}"] = np.ones(n, dtype=bool)
        if not runs.episode.over:
            return seen, reward, over, over.copy(), info
        self.rollouts = runs.episode.records()
        for i, rollout in enumerate(self.rollouts):
            verdict = verdict_of(rollout)
            info = self._add_info(info, verdict, i)
            reward[i] += SUCCESS * verdict["is_success"]
        return seen, reward, ~over, ~np.array(runs.episode.unstable), info

    def _begin(self, seeds: Sequence[int | None]) -> tuple[Observed, dict[str, Any]]:
        conditions = [
            self._runs.conditions(
                int(self.np_random.integers(2**31)) if seed is None else seed, self._options
            )
            for seed in seeds
        ]
        info: dict[str, Any] = {}
        for i, each in enumerate(conditions):
            info = self._add_info(info, {"trial": each.as_dict()}, i)
        return self._runs.named(self._runs.begin(conditions)), info
