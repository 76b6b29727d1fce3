"""Evaluate the learned controller as a policy: verdicts over tasks and seeds.

Run: python evaluate_controller.py [--tasks cube-raise pen-write] [--trials 3] [--hand left]
"""

import argparse

import gymnasium

import handsim.environments
from handsim.environments.policies import ControllerPolicy


def verdicts(task, n_trials, hand=None):
    """Seed and verdict of the nominal run and of perturbed trials, as of `handsim grasp`."""
    env = gymnasium.make(handsim.environments.ID, task=task, hand=hand)
    policy, found = ControllerPolicy(env), []
    for seed in range(1 + n_trials):
        seen, info = env.reset(seed=seed, options={"perturbed": seed > 0})
        over = False
        while not over:
            seen, _, terminated, truncated, info = env.step(policy(seen))
            over = terminated or truncated
        found.append((seed, "held" if info["is_success"] else info["reason"]))
    env.close()
    return found


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tasks", nargs="+", default=["cube-raise", "pen-write", "mouse-slide"])
    parser.add_argument("--trials", type=int, default=3)
    parser.add_argument("--hand")
    asked = parser.parse_args()
    for task in asked.tasks:
        of_task = verdicts(task, asked.trials, asked.hand)
        print(f"{task:24}", ", ".join(f"seed {seed}: {verdict}" for seed, verdict in of_task))
