"""What environments cost beside MuJoCo alone; run by `make bench`.

Beside a bare loop that gives the same commands to the same model, with all its sensors, in as many
steps. The bars are ratios of CPU time, taken in turns: of each stretch of readings the cheapest
round counts.
"""
# pyright: reportAttributeAccessIssue=false

from collections.abc import Callable
from contextlib import closing
from copy import copy
from time import process_time
from typing import Any

import mujoco
import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="comes with handsim[gym]")

import handsim.environments  # noqa: E402
from handsim.environments.policies import ControllerPolicy  # noqa: E402

pytestmark = pytest.mark.slow

STEPS = 5
"""Between two readings."""
STRETCH = 60
"""Readings that are timed together."""
TASKS = ("pen-write", "cube-raise", "tall-glass-drink")
"""The cheapest scene, a scene of usual cost, and one of the dearest."""
ONE = {"pen-write": 0.6, "cube-raise": 0.68, "tall-glass-drink": 0.78}
"""What one environment has where other work keeps all cores busy; with less of it 0.70, 0.77 and
0.83."""


def of_stretches(step: Callable[[int], object], n: int) -> list[float]:
    """CPU seconds of the stretches of n readings [s]."""
    costs = []
    for first in range(0, n, STRETCH):
        start = process_time()
        for tick in range(first, min(first + STRETCH, n)):
            step(tick)
        costs.append(process_time() - start)
    return costs


def throughput(task: str, n_envs: int, rounds: int) -> float:
    """Readings a second beside those of a bare loop, one environment or several."""
    name = handsim.environments.ID
    actions: list[Any] = []
    with closing(gymnasium.make(name, task=task)) as env:
        policy, over = ControllerPolicy(env), False
        seen, _ = env.reset(seed=0)
        while not over:
            actions.append(policy(seen))
            seen, _, over, *_ = env.step(actions[-1])
        run, model = env.unwrapped.rollout, copy(env.unwrapped.scene.model)
    make = gymnasium.make if n_envs == 1 else gymnasium.make_vec
    values = {"task": task} | ({} if n_envs == 1 else {"num_envs": n_envs})
    given = [action if n_envs == 1 else np.tile(action, (n_envs, 1)) for action in actions]
    n, ours, alone = len(actions) - 1, [], []  # the last step judges
    with closing(make(name, **values)) as env:
        for _ in range(rounds):
            env.reset(seed=0)
            ours.append(of_stretches(lambda tick: env.step(given[tick]), n))
            env.step(given[-1])
            data = mujoco.MjData(model)
            data.qpos[:], data.ctrl[:] = run.qpos[0], run.ctrl[0]
            mujoco.mj_forward(model, data)

            def bare(tick: int, data: mujoco.MjData = data) -> None:
                data.ctrl[:] = run.ctrl[tick]
                mujoco.mj_step(model, data, nstep=STEPS)

            alone.append(of_stretches(bare, n))
        np.testing.assert_allclose(data.qpos, run.qpos[-1], atol=1e-6)
    ratio = n_envs * np.min(alone, axis=0).sum() / np.min(ours, axis=0).sum()
    print(
        f"{task}, {n_envs}: {ratio:.3f} of {n / np.min(alone, axis=0).sum():.0f} readings a second"
    )
    return float(ratio)


@pytest.mark.parametrize("task", TASKS)
def test_many_have_most_of_the_throughput_of_mujoco_alone(task):
    assert throughput(task, 32, rounds=3) >= 0.8


@pytest.mark.parametrize(("task", "share"), ONE.items())
def test_one_has_most_of_it(task, share):
    """What a step costs in Python hardly depends on the scene, and is shared by nobody."""
    assert throughput(task, 1, rounds=6) >= share
