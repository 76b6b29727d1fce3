"""Several grasps side by side: each as by itself, beginning and ending together."""

from collections.abc import Iterator
from contextlib import closing
from typing import Any

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="comes with handsim[gym]")

import handsim.environments  # noqa: E402
from handsim.environments.grasp_env import GraspEnv  # noqa: E402
from handsim.environments.grasp_vector_env import GraspVectorEnv  # noqa: E402
from handsim.environments.policies import ControllerPolicy  # noqa: E402
from handsim.environments.rewards import PARTS, SUCCESS  # noqa: E402
from handsim.errors import InputError  # noqa: E402
from handsim.grasping.conditions import Conditions, perturb  # noqa: E402

TASK, N = "mouse-left-click", 3
N_READINGS = 341


@pytest.fixture
def envs() -> Iterator[Any]:
    with closing(gymnasium.make_vec(handsim.environments.ID, num_envs=N, task=TASK)) as made:
        yield made


def test_make_vec_takes_one_batch(envs):
    assert isinstance(envs, GraspVectorEnv)
    assert envs.action_space.shape == (N, 3)
    seen, _ = envs.reset(seed=0)
    assert envs.observation_space.contains(seen)


def test_each_run_is_as_by_itself_and_new_ones_begin_when_all_have_ended(envs):
    """Trial and verdict as well; nothing is stepped by the action that begins new runs."""
    seen, info = envs.reset(seed=4, options={"perturbed": True})
    assert info["trial"]["seed"].tolist() == [4, 5, 6]
    with closing(GraspEnv(TASK)) as alone:
        policy = ControllerPolicy(alone)
        own, _ = alone.reset(seed=5, options={"perturbed": True})
        for tick in range(N_READINGS):
            for name, value in own.items():
                np.testing.assert_array_equal(seen[name][1], value, err_msg=name)
            actions = np.stack([policy({n: v[i] for n, v in seen.items()}) for i in range(N)])
            seen, rewards, terminated, truncated, info = envs.step(actions)
            own, reward, over, *_, its = alone.step(actions[1])
            assert rewards[1] == reward
            assert all(info[name][1] == its[name] for name in PARTS)
            assert terminated.tolist() == truncated.tolist() == [tick == N_READINGS - 1] * N
        assert over
        assert envs.rollouts[1].conditions == perturb(Conditions(), 5) == alone.rollout.conditions
        np.testing.assert_array_equal(envs.rollouts[1].qpos, alone.rollout.qpos)
        assert envs.rollouts[1].outcome == alone.rollout.outcome
    assert info["is_success"].tolist() == [run.outcome.success for run in envs.rollouts]
    assert info["outcome"]["lift_m"][2] == envs.rollouts[2].outcome.lift_m
    assert (rewards > SUCCESS).tolist() == info["is_success"].tolist()
    seen, rewards, terminated, truncated, info = envs.step(np.full((N, 3), 9.0))
    assert not rewards.any() and not terminated.any() and not truncated.any()
    assert seen["time"].ravel().tolist() == [0.0] * N
    assert not info["trial"]["nominal"].any()
    assert envs.step(np.zeros((N, 3)))[0]["time"][0, 0] == 0.01


def test_one_that_diverges_waits_for_the_others(envs):
    seen, _ = envs.reset(seed=[7, 8, 9])
    sound = seen
    runs = envs._runs.episode._runs
    for tick in range(N_READINGS):
        if tick == 30:
            sound = seen
            runs.simulations.qvel[1, 0] = 1e9
        seen, rewards, terminated, truncated, info = envs.step(np.zeros((N, 3)))
        assert envs.observation_space.contains(seen)
        if tick >= 30:
            assert rewards[1] == 0.0 < rewards[0]
            np.testing.assert_array_equal(seen["posture"][1], sound["posture"][1])
    assert terminated.all()
    assert truncated.tolist() == [True, False, True]
    assert info["reason"][1] == "unstable"
    assert info["reason"][0] == info["reason"][2] == "not arrived"


@pytest.mark.parametrize("actions", [np.zeros((2, 3)), np.zeros(3), np.full((N, 3), np.inf)])
def test_actions_that_are_none_are_refused(envs, actions):
    envs.reset(seed=0)
    with pytest.raises(InputError, match="3 x 3 finite numbers"):
        envs.step(actions)


def test_seeds_are_one_each(envs):
    with pytest.raises(InputError, match="2 seeds for 3"):
        envs.reset(seed=[1, 2])
    with pytest.raises(InputError, match="1 or more"):
        GraspVectorEnv(0)
