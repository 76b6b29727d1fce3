"""Runs of one grasp that a policy commands, with what it sees of them and is paid for."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, get_args

import numpy as np

from handsim.environments.asked import Grasped
from handsim.environments.entries import ActionKind, action_entry, observation_entries
from handsim.environments.grasp_episode import GraspEpisode
from handsim.environments.observing import Observer
from handsim.environments.rewards import PARTS, DenseReward
from handsim.errors import UnknownNameError
from handsim.grasping.conditions import Conditions, Hard, made_hard, perturb
from handsim.grasping.plan import schedule_for
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.types import Array

Observed = dict[str, Array]
_OPTIONS = ("perturbed", "hard")


class WatchedRuns:
    """Runs of one grasp, one episode after the other.

    Parameters
    ----------
    known
        Task, hand, controller and plan.
    kind
        What actions are.
    perturbed
        Whether runs are perturbed where nothing else is said.
    brief
        End each run as soon as its object is lost.

    Attributes
    ----------
    task, schedule
        For the hand's side, and its timing.
    action_meaning, observation_meaning
        Names, units, frames and bounds.
    scene
        Of the first of the latest runs; None before there are any.
    """

    def __init__(
        self, known: Grasped, kind: ActionKind, *, perturbed: bool = False, brief: bool = False
    ) -> None:
        self.known, self._perturbed, self._brief = known, perturbed, brief
        self._kind: ActionKind = kind
        self.task = known.task.for_side(known.conditions.hand.side)
        self.schedule = schedule_for(self.task)
        self._goal = known.plan.goal_in(known.controller.subspace)
        self.action_meaning = action_entry(kind, len(self._goal))
        self.observation_meaning = observation_entries(len(self._goal), self.schedule.end)
        self._reward = DenseReward(self.task, known.need)
        self._scenes: dict[Conditions, Scene] = {}
        self.scene: Scene | None = None

    def conditions(self, seed: int, options: Mapping[str, Any]) -> Conditions:
        """Return the conditions of a run.

        Parameters
        ----------
        seed
        options
            ``perturbed`` and ``hard``, as of `reset`.

        Raises
        ------
        UnknownNameError
            If there is no such option, or nothing of that name is made hard.
        """
        for name in options:
            if name not in _OPTIONS:
                raise UnknownNameError("option of reset", name, _OPTIONS)
        nominal, hard = self.known.conditions, options.get("hard")
        if hard is not None:
            if hard not in get_args(Hard):
                raise UnknownNameError("hard trial", str(hard), get_args(Hard))
            return made_hard(nominal, seed, hard)
        if options.get("perturbed", self._perturbed):
            return perturb(nominal, seed)
        return replace(nominal, seed=seed)

    def begin(self, conditions: Sequence[Conditions]) -> Array:
        """Begin runs under conditions, one each; return observations, (n, size)."""
        known, scenes = self.known, self._scenes_for(conditions)
        self.scene = scenes[0]
        self.episode = GraspEpisode(
            scenes, known.plan, known.controller, self._kind, brief=self._brief
        )
        self._observer = Observer(self.scene, self.observation_meaning, self._goal, known.need)
        self._observer.begin(self.episode)
        self._share = 1.0 / (len(PARTS) * self.episode.n_readings)
        self._latest, _ = self._observer.look(self.episode)
        return self._latest.copy()

    def named(self, seen: Array) -> Observed:
        """Return observations (..., size) by the names of their entries."""
        return self._observer.named(seen)

    def step(self, actions: Array) -> tuple[Array, list[dict[str, float]], list[float]]:
        """Command by actions (n, size) and go on to the next reading.

        A run that has diverged shows what it showed last, and gives nothing.

        Returns
        -------
        observations, parts, rewards
            Observations as of `begin`, the parts of the dense reward, and the reward without that
            for success.
        """
        episode = self.episode
        episode.step(actions)
        seen, felt = self._observer.look(episode)
        parts = list(map(self._reward.parts, felt))
        if any(episode.unstable):
            for i in np.flatnonzero(episode.unstable).tolist():
                seen[i], parts[i] = self._latest[i], dict.fromkeys(PARTS, 0.0)
            self._latest = seen.copy()
        else:
            self._latest = seen
        share = self._share
        return seen, parts, [share * sum(each.values()) for each in parts]

    def _scenes_for(self, conditions: Sequence[Conditions]) -> list[Scene]:
        """Return scenes of runs: those of the runs before, where they were built alike."""
        kept: dict[Conditions, Scene] = {}
        found = []
        for each in conditions:
            built_for = replace(each, seed=0, nominal=True, shake=0.0)  # these leave it as it is
            scene = kept.get(built_for) or self._scenes.get(built_for)
            kept[built_for] = scene = scene or Scene.build(self.known.task, each)
            found.append(replace(scene, conditions=each))
        self._scenes = kept
        return found
