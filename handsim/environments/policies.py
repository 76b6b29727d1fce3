"""The learned controller as a policy, commands played again, and residuals on top of it."""

from collections.abc import Mapping
from typing import Any, SupportsFloat, cast

import gymnasium
import numpy as np

from handsim.environments.entries import SPEED, action_of
from handsim.environments.grasp_env import GraspEnv
from handsim.errors import InputError
from handsim.grasping.rollout.glove import RATE
from handsim.grasping.rollout.record import Rollout
from handsim.types import Array

Observed = dict[str, Array]
AnyEnv = gymnasium.Env[Observed, Array]


class ControllerPolicy:
    """Does what the controller of an environment does: gives its actions for observations.

    In the reach they are the controller's velocities, to the bit. Then the hand goes to the planned
    destination, as it does while `handsim grasp` squeezes.

    Parameters
    ----------
    env
        A `GraspEnv` with actions of kind ``components``, or wrappers around it.

    Raises
    ------
    InputError
        If actions are of another kind.
    """

    def __init__(self, env: AnyEnv) -> None:
        inner = grasp_env_in(env)
        if inner.action_meaning.name != "velocity":
            raise InputError(
                "the controller's actions are velocities of components, and the environment's are "
                "joint targets; make it with action='components'"
            )
        known, schedule = inner.grasped, inner.schedule
        controller, plan = known.controller, known.plan
        goal, start = (
            plan.goal_in(controller.subspace),
            controller.subspace.transform(plan.q_start),
        )
        self._reach = schedule.reach
        self._timing = controller.timing(start, goal, schedule.reach, known.task.object_name)

    def __call__(self, observation: Mapping[str, Array]) -> Array:
        """Return the action (n_components,) for an observation."""
        z, time = observation["components"], float(observation["time"][0])
        if time <= self._reach:
            velocity = self._timing.velocities(z[None], time)[0]
        else:
            velocity = RATE * (observation["destination"] - z)
        return np.minimum(np.maximum(velocity / SPEED, -1.0), 1.0)


def played_again(env: AnyEnv, rollout: Rollout) -> Array:
    """Return the actions (n, 22) of kind ``joints`` that command a hand as in a rollout.

    Parameters
    ----------
    env
        An environment of the same task, hand and base.
    rollout
    """
    inner = grasp_env_in(env)
    if inner.scene is None:
        inner.reset()
    assert inner.scene is not None  # it is built by the first reset
    return action_of(rollout.ctrl[:, inner.scene.hand.ctrl_index])


class ResidualEnv(gymnasium.Wrapper[Observed, Array, Observed, Array]):
    """Adds an action to the controller's: 0 does as the controller does.

    Parameters
    ----------
    env
        With actions of kind ``components``.
    share
        How much of the range of actions the residual has, 0 to 1.

    Raises
    ------
    InputError
        If actions are of another kind, or the share is outside.
    """

    def __init__(self, env: AnyEnv, share: float = 0.1) -> None:
        super().__init__(env)
        if not 0.0 < share <= 1.0:
            raise InputError(f"share of {share:g} for the residual; give more than 0 and up to 1")
        self._policy, self._share = ControllerPolicy(env), share

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observed, dict[str, Any]]:
        """Begin a run."""
        self._seen, info = self.env.reset(seed=seed, options=options)
        return self._seen, info

    def step(self, action: Array) -> tuple[Observed, SupportsFloat, bool, bool, dict[str, Any]]:
        """Go on by what the controller does and a residual, (n_components,) from -1 to 1."""
        asked = self._policy(self._seen) + self._share * np.asarray(action, dtype=float)
        whole = np.minimum(np.maximum(asked, -1.0), 1.0)
        self._seen, reward, terminated, truncated, info = self.env.step(whole)
        return self._seen, reward, terminated, truncated, info


def grasp_env_in(env: AnyEnv) -> GraspEnv:
    """Return the `GraspEnv` inside wrappers.

    Raises
    ------
    InputError
        If there is none.
    """
    inner = cast(Any, env.unwrapped)
    if not isinstance(inner, GraspEnv):
        raise InputError(f"{inner} is no environment of handsim; make handsim/Grasp-v0")
    return inner
