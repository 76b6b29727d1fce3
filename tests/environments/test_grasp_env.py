"""The environment keeps Gymnasium's contract, and its rules are those of `handsim grasp`."""

import json
import subprocess
import sys
from contextlib import closing
from typing import Any

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="comes with handsim[gym]")

from gymnasium.utils.env_checker import check_env  # noqa: E402, only where it is installed

import handsim.environments  # noqa: E402
from handsim.environments.entries import SPEED, action_of, targets_of  # noqa: E402
from handsim.environments.grasp_env import GraspEnv  # noqa: E402
from handsim.environments.policies import (  # noqa: E402
    ControllerPolicy,
    ResidualEnv,
)
from handsim.environments.rewards import NEAR, PARTS  # noqa: E402
from handsim.errors import InputError, UnknownNameError  # noqa: E402
from handsim.grasping.conditions import Conditions, perturb  # noqa: E402
from handsim.joints import FINGERS, LOWER, UPPER  # noqa: E402
from handsim.tasks.table_one import TASKS  # noqa: E402
from handsim.types import HandSize  # noqa: E402

ID = handsim.environments.ID
CI = ("book-read", "scissors-use")
N_RANDOM = 1000


# The contract.


@pytest.mark.parametrize("action", ["components", "joints"])
def test_the_checker_of_gymnasium_has_nothing_to_say(make, action):
    """A warning would be an error here."""
    env = make(action=action, width=64, height=48, render_mode="rgb_array")
    check_env(env.unwrapped)


def test_it_is_registered_by_its_name_alone_and_without_an_import():
    code = (
        "import gymnasium; env = gymnasium.make('handsim.environments:handsim/Grasp-v0'); "
        "env.reset(seed=0); print(env.spec.id, env.unwrapped.task.name)"
    )
    told = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True
    )
    assert told.stdout.split() == [ID, "cube-raise"]


def random_steps(env: Any, n: int) -> None:
    """Check every number of n random steps, run after run."""
    env.action_space.seed(7)
    env.reset(seed=7, options={"perturbed": True})
    for _ in range(n):
        seen, reward, terminated, truncated, info = env.step(env.action_space.sample())
        assert env.observation_space.contains(seen)
        assert all(np.isfinite(value).all() for value in seen.values())
        assert np.isfinite(reward)
        assert all(np.isfinite(info[name]) for name in PARTS)
        if terminated or truncated:
            assert isinstance(info["is_success"], bool)
            env.reset()


def long_runs() -> list[Any]:
    slow = {task.name: [pytest.mark.slow] for task in TASKS}
    for name in CI:
        slow[name].append(pytest.mark.ci)
    return [
        pytest.param(task.name, action, marks=slow[task.name])
        for task in TASKS
        for action in ("components", "joints")
    ]


@pytest.mark.parametrize(("task", "action"), long_runs())
def test_a_thousand_random_steps_of_each_task_are_numbers(make, task, action):
    random_steps(make(task=task, action=action), N_RANDOM)


@pytest.mark.parametrize(
    ("task", "action"), [("pen-write", "components"), ("mouse-slide", "joints")]
)
def test_random_steps_are_numbers(make, task, action):
    random_steps(make(task=task, action=action), 400)


def test_the_same_seed_is_the_same_run_to_the_bit(make):
    first, second = make(task="pen-write"), make(task="pen-write")
    actions = np.random.default_rng(0).uniform(-0.2, 0.2, (130, 3))
    for options in ({}, {"perturbed": True}):
        first.reset(seed=4, options=options)
        for _ in range(20):
            first.step(actions[0])  # what was before does not matter
        begun = [env.reset(seed=5, options=options)[0] for env in (first, second)]
        for action in actions:
            ours, theirs = begun
            for name, value in ours.items():
                np.testing.assert_array_equal(value, theirs[name], err_msg=name)
            begun = [env.step(action)[0] for env in (first, second)]
    assert not np.array_equal(first.reset(seed=6)[0]["posture"], second.reset(seed=7)[0]["posture"])


def test_a_run_without_a_seed_has_a_seed_of_its_own(make):
    env = make()
    env.reset(seed=3)
    seeds = [env.reset()[1]["trial"]["seed"] for _ in range(2)]
    env.reset(seed=3)
    assert [env.reset()[1]["trial"]["seed"] for _ in range(2)] == seeds
    assert len({3, *seeds}) == 3


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_several_go_at_once(mode):
    with closing(
        gymnasium.make_vec(ID, num_envs=2, vectorization_mode=mode, task="pen-write")
    ) as envs:
        seen, _ = envs.reset(seed=[1, 2])
        assert seen["posture"].shape == (2, 22)
        for _ in range(5):
            seen, reward, *_ = envs.step(np.zeros((2, 3)))
    with closing(GraspEnv("pen-write")) as alone:
        alone.reset(seed=2)
        for _ in range(5):
            own, its_reward, *_ = alone.step(np.zeros(3))
    assert reward[1] == its_reward
    for name, value in own.items():
        np.testing.assert_array_equal(seen[name][1], value, err_msg=name)


# What actions and observations say.


def test_spaces_are_as_their_meaning_says(make):
    env = make(task="stapler-use").unwrapped
    assert {entry.name: entry.size for entry in env.observation_meaning} == {
        name: space.shape[0] for name, space in env.observation_space.items()
    }
    assert env.action_space.shape == (env.action_meaning.size,)
    for entry in (*env.observation_meaning, env.action_meaning):
        assert entry.unit and entry.meaning and entry.low < entry.high


def test_observations_are_what_the_run_measured(make):
    env = make(task="cube-raise")
    policy, seen = ControllerPolicy(env), env.reset(seed=1)[0]
    observed = [seen]
    for _ in range(400):
        seen, *_ = env.step(policy(seen))
        observed.append(seen)
    while not env.step(np.zeros(3))[2]:
        pass
    run, inner = env.unwrapped.rollout, env.unwrapped
    for tick in (0, 60, 200, 400):
        at = observed[tick]
        assert at["time"][0] == run.time[tick]
        np.testing.assert_array_equal(at["posture"], run.reading[tick])
        np.testing.assert_allclose(at["forces"], run.contact_force[tick], atol=1e-9)
        inner.scene.hand.data.qpos[:] = run.qpos[tick]
    import mujoco

    model, data = inner.scene.model, mujoco.MjData(inner.scene.model)
    data.qpos[:] = run.qpos[400]
    mujoco.mj_forward(model, data)
    body, palm = data.body("object"), data.body("palm")
    turn = body.xmat.reshape(3, 3).T
    at = observed[400]
    np.testing.assert_allclose(at["palm_position"], turn @ (palm.xpos - body.xpos), atol=2e-4)
    want = np.zeros(9)
    mujoco.mju_quat2Mat(want, at["palm_orientation"])
    np.testing.assert_allclose(want.reshape(3, 3), turn @ palm.xmat.reshape(3, 3), atol=5e-3)
    tips = np.array([data.site(f"{f}_tip").xpos for f in ("thumb", "index")])
    np.testing.assert_allclose(
        at["fingertips"].reshape(5, 3)[:2], (tips - body.xpos) @ turn.T, atol=5e-4
    )
    rise = run.qpos[400] - run.qpos[0]
    assert at["object_shift"][2] > 0.08 and rise.max() > 0.08
    assert at["need"][0] == inner.grasped.need > 0.0
    np.testing.assert_array_equal(at["destination"], inner.grasped.plan.z_goal)
    np.testing.assert_allclose(observed[60]["progress"], [0.5, 0, 0, 0], atol=1e-9)
    np.testing.assert_allclose(observed[145]["progress"], [1, 0.5, 0, 0], atol=1e-9)


def test_what_is_turned_at_its_hinge_is_observed_and_paid_for(make):
    """The angle of the rule's joint, and the distance of the fingertips that grasp."""
    env = make(task="stapler-use")
    env.reset(seed=0)
    inner = env.unwrapped
    model, data = inner.scene.model, inner.scene.hand.data
    hinge = model.joint(inner.task.rule.joint)
    data.qvel[hinge.dofadr[0]] = -2.0
    for _ in range(3):
        seen, _, _, _, info = env.step(np.zeros(3))
    assert seen["hinge"][0] == data.qpos[hinge.qposadr[0]] != 0.0
    tips = seen["fingertips"].reshape(5, 3)
    grasping = [i for i, f in enumerate(FINGERS) if f in {"thumb", *inner.task.grasp.fingers}]
    away = np.linalg.norm(tips[grasping] - model.site("grasp").pos, axis=1).mean()
    assert info["distance"] == pytest.approx(np.exp(-away / NEAR))


def test_what_is_beyond_the_bounds_of_a_space_is_cut_off(make):
    env = make(task="cube-raise")
    env.reset(seed=0)
    data, cube = env.unwrapped.scene.hand.data, env.unwrapped.scene.model.body("object")
    free = int(env.unwrapped.scene.model.jnt_qposadr[cube.jntadr[0]])
    data.qpos[free : free + 2] = -9.0, 9.0
    seen, *_ = env.step(np.zeros(3))
    assert env.observation_space.contains(seen)
    np.testing.assert_array_equal(seen["object_shift"][:2], [-3.0, 3.0])


def test_a_velocity_moves_the_hand_in_its_component(make):
    env = make(task="cube-raise")
    start = env.reset(seed=0)[0]["components"]
    action = np.array([0.25, 0.0, 0.0])
    for _ in range(10):
        seen, *_ = env.step(action)
    assert seen["components"][0] - start[0] == pytest.approx(10 * 0.01 * 0.25 * SPEED, rel=0.15)
    _, high = env.unwrapped.grasped.controller.reach
    for _ in range(200):
        seen, *_ = env.step(np.ones(3))
    np.testing.assert_allclose(seen["components"], high)


def test_joint_targets_span_the_ranges_of_motion(make):
    for end, limit in ((-1.0, LOWER), (1.0, UPPER)):
        np.testing.assert_allclose(targets_of(np.full(22, end)), limit, atol=1e-15)
    q = np.random.default_rng(1).uniform(LOWER, UPPER, (4, 22))
    np.testing.assert_allclose(targets_of(action_of(q)), q, atol=1e-12)
    env = make(task="cube-raise", action="joints")
    env.reset(seed=0)
    action = action_of(0.5 * (LOWER + UPPER))
    for _ in range(40):
        seen, *_ = env.step(action)
    off = np.abs(seen["posture"] - 0.5 * (LOWER + UPPER))[:19]
    assert np.rad2deg(off.max()) < 3.0


def test_a_residual_of_nothing_is_the_controller_and_others_are_not(make):
    plain, residual = make(task="pen-write"), ResidualEnv(make(task="pen-write"), share=0.1)
    policy, seen, same = ControllerPolicy(plain), plain.reset(seed=1)[0], residual.reset(seed=1)[0]
    for _ in range(60):
        seen, same = plain.step(policy(seen))[0], residual.step(np.zeros(3))[0]
    for name, value in seen.items():
        np.testing.assert_array_equal(value, same[name], err_msg=name)
    other = residual.step(np.ones(3))[0]
    seen = plain.step(policy(seen))[0]
    moved = other["components"] - seen["components"]
    np.testing.assert_allclose(moved, 0.01 * 0.1 * SPEED, rtol=0.1)


def test_pictures_are_those_of_the_camera(make):
    env = make(task="cube-raise", render_mode="rgb_array", camera="side", width=120, height=90)
    env.reset(seed=0)
    first = env.render()
    for _ in range(60):
        env.step(np.full(3, 0.3))
    second = env.render()
    assert first.shape == (90, 120, 3) and first.dtype == np.uint8
    assert first.std() > 10
    assert np.abs(first.astype(int) - second).mean() > 0.5


# What is refused.


@pytest.mark.parametrize(
    ("values", "error", "words"),
    [
        ({"task": "cup-drnk"}, UnknownNameError, "cup-drink"),
        ({"action": "torques"}, UnknownNameError, "action"),
        ({"hand": "leap.xml"}, InputError, "handsim grasp --hand FILE"),
        ({"hand": "woman-6"}, UnknownNameError, "woman-5"),
        ({"width": 4}, InputError, "width of 4"),
    ],
)
def test_what_cannot_be_made_is_refused_in_a_line(make, values, error, words):
    with pytest.raises(error, match=words) as caught:
        make(**values)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("action", [np.zeros(4), np.full(3, np.nan), np.zeros((1, 3))])
def test_actions_that_are_none_are_refused(make, action):
    env = make()
    env.reset(seed=0)
    with pytest.raises(InputError, match="3 finite numbers"):
        env.unwrapped.step(action)


def test_options_of_reset_are_checked(make):
    env = make()
    with pytest.raises(UnknownNameError, match="perturbed"):
        env.reset(options={"perturb": True})
    with pytest.raises(UnknownNameError, match="friction"):
        env.reset(options={"hard": "frictoin"})


def test_residuals_and_the_controller_need_components(make):
    env = make(action="joints")
    with pytest.raises(InputError, match="action='components'"):
        ControllerPolicy(env)
    with pytest.raises(InputError, match="share"):
        ResidualEnv(make(), share=0.0)


def test_hands_are_named_as_on_the_command_line():
    from handsim.environments.asked import hand_asked

    assert hand_asked(None) == HandSize()
    assert hand_asked("left").side == "left"
    assert hand_asked("woman-5 left") == HandSize(0.165, 0.072, "left")
    assert hand_asked(HandSize(0.18, 0.08)) == HandSize(0.18, 0.08)


def test_what_a_reset_says_is_the_trial_of_the_command_line(make):
    env = make(perturbed=True)
    _, info = env.reset(seed=11)
    assert info["trial"] == perturb(Conditions(), 11).as_dict()
    assert json.dumps(info["trial"])
    _, info = env.reset(seed=11, options={"perturbed": False})
    assert info["trial"] == Conditions(seed=11).as_dict()


def test_without_gymnasium_the_remedy_is_named():
    code = (
        "import sys; sys.modules['gymnasium'] = None\n"
        "import handsim\n"
        "try:\n    import handsim.environments\n"
        "except handsim.MissingToolError as error:\n    print(error)\n"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "pip install 'handsim[gym]'" in told.stdout
