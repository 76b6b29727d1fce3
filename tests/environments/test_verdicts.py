"""Verdicts of environments are those of `handsim grasp`, whoever commands."""

from typing import Any

import numpy as np
import pytest

pytest.importorskip("gymnasium", reason="comes with handsim[gym]")

from handsim.environments.policies import ControllerPolicy, played_again
from handsim.environments.rewards import SUCCESS
from handsim.errors import InputError
from handsim.grasping.conditions import Conditions, made_hard, perturb
from handsim.grasping.one_grasp import grasp
from handsim.grasping.rollout.record import Rollout
from handsim.types import HandSize

N_REACH = 121
"""Readings of the reach, the last of which is at 1.2 s."""


def run_through(env: Any, policy: Any, seed: int, **options: Any) -> tuple[float, dict[str, Any]]:
    """Let a policy command a whole run; return the sum of rewards and the last info."""
    seen, _ = env.reset(seed=seed, options=options)
    total, over = 0.0, False
    while not over:
        seen, reward, terminated, truncated, info = env.step(policy(seen))
        total += reward
        over = terminated or truncated
    return total, info


def by_handsim(env: Any, conditions: Conditions) -> Rollout:
    known = env.unwrapped.grasped
    return grasp(known.controller, known.task, conditions, known.plan)


@pytest.mark.parametrize(
    ("task", "seed", "perturbed"),
    [("cube-raise", 3, False), ("pen-write", 2, True), ("mouse-left-click", 1, True)],
)
def test_the_controller_gets_the_verdict_of_handsim_grasp(make, task, seed, perturbed):
    """The same movement to the bit while the hand reaches, and as good as the same after it."""
    env = make(task=task)
    total, info = run_through(env, ControllerPolicy(env), seed, perturbed=perturbed)
    conditions = perturb(Conditions(), seed) if perturbed else Conditions(seed=seed)
    ours, theirs = env.unwrapped.rollout, by_handsim(env, conditions)
    assert ours.conditions == theirs.conditions
    assert (ours.outcome.success, ours.outcome.reason) == (
        theirs.outcome.success, theirs.outcome.reason
    )  # fmt: skip
    assert (info["is_success"], info["reason"]) == (
        theirs.outcome.success, theirs.outcome.reason or ""
    )  # fmt: skip
    np.testing.assert_array_equal(ours.qpos[:N_REACH], theirs.qpos[:N_REACH])
    hand = env.unwrapped.scene.hand.qpos_index
    np.testing.assert_allclose(ours.qpos[:, hand], theirs.qpos[:, hand], atol=0.02)
    assert info["outcome"]["lift_m"] == pytest.approx(theirs.outcome.lift_m, abs=1e-3)
    assert (total > SUCCESS) == theirs.outcome.success


@pytest.mark.parametrize("hard", ["friction", "mass", "latency"])
def test_a_failure_has_the_reason_of_handsim_grasp(make, hard):
    env = make(task="pen-write")
    _, info = run_through(env, ControllerPolicy(env), 1, hard=hard)
    outcome = by_handsim(env, made_hard(Conditions(), 1, hard)).outcome
    assert (info["is_success"], info["reason"]) == (outcome.success, outcome.reason or "")


@pytest.mark.parametrize(
    ("task", "base"), [("pen-write", "arm"), ("mouse-left-click", "arm"), ("stapler-use", "free")]
)
def test_joint_targets_played_again_are_the_same_grasp(make, task, base):
    """Nothing is added to them: no grip, no click of the task's own."""
    plan = make(task=task).unwrapped.grasped.plan  # none is kept for a free base
    env = make(task=task, action="joints", base=base, plan=plan)
    run = by_handsim(env, Conditions(seed=2, base=base))
    actions = iter(played_again(env, run))
    _, info = run_through(env, lambda seen: next(actions), 2)
    again = env.unwrapped.rollout
    np.testing.assert_allclose(again.ctrl, run.ctrl, atol=1e-5)
    np.testing.assert_allclose(again.qpos, run.qpos, atol=1e-4)
    assert (info["is_success"], info["reason"]) == (run.outcome.success, run.outcome.reason or "")
    assert run.outcome.success


def test_another_hand_grasps_by_the_same_rules(make):
    """By a plan that is given: none is kept for a small left hand, and to search one takes long."""
    plan = make(task="mouse-left-click").unwrapped.grasped.plan
    env = make(task="mouse-left-click", hand="woman-50 left", plan=plan)
    _, info = run_through(env, ControllerPolicy(env), 0)
    size = HandSize(0.1811, 0.0782, "left")
    assert env.unwrapped.rollout.conditions.hand == size
    outcome = by_handsim(env, Conditions(hand=size)).outcome
    assert (info["is_success"], info["reason"]) == (outcome.success, outcome.reason or "")
    assert env.unwrapped.task.rule.pressed[0].fingers == ("middle",)


def test_a_hand_that_does_nothing_misses(make):
    env = make(task="pen-write")
    total, info = run_through(env, lambda seen: np.zeros(3), 0)
    outcome = info["outcome"]
    assert not info["is_success"] and info["reason"] == outcome["reason"] != ""
    assert 0.0 < total < 1.0


def test_a_run_ends_early_where_its_object_is_lost(make):
    env = make(task="cube-raise", brief=True)
    env.reset(seed=0)
    n, over = 0, False
    while not over:
        *_, terminated, truncated, info = env.step(np.zeros(3))
        n, over = n + 1, terminated or truncated
    assert terminated and not truncated
    assert info["reason"] == "not arrived"
    assert n < 400
    with pytest.raises(InputError, match="reset the environment"):
        env.step(np.zeros(3))


def test_a_run_that_diverges_says_so_and_shows_nothing_absurd(make):
    env = make(task="pen-write")
    seen, _ = env.reset(seed=0)
    env.step(np.zeros(3))
    env.unwrapped.scene.hand.data.qvel[0] = np.nan
    seen, reward, terminated, truncated, info = env.step(np.zeros(3))
    assert terminated and not truncated and reward == 0.0
    assert info["reason"] == "unstable"
    assert env.observation_space.contains(seen)
    assert env.unwrapped.rollout.outcome.reason == "unstable"
    seen, _ = env.reset(seed=0)
    assert env.observation_space.contains(seen)
    assert not env.step(np.zeros(3))[2]
