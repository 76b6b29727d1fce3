"""Train a residual in three components on top of the learned controller, by CMA-ES.

Run: python residual_on_controller.py [--task pen-write] [--generations 8] [--seeds 3]
"""

import argparse

import cma
import gymnasium
import numpy as np

import handsim.environments
from handsim.environments.policies import ResidualEnv


def features(seen):
    """What the residual depends on, (14,): way to the destination, forces, progress."""
    way = seen["destination"] - seen["components"]
    return np.concatenate([[1.0], way, np.tanh(seen["forces"] / seen["need"]), seen["progress"]])


def grasped(env, weights, seed):
    """Sum of rewards, and whether the grasp held, of one perturbed trial."""
    seen, info = env.reset(seed=seed, options={"perturbed": True})
    total, over = 0.0, False
    while not over:
        seen, reward, terminated, truncated, info = env.step(np.tanh(weights @ features(seen)))
        total, over = total + reward, terminated or truncated
    return total, info["is_success"]


def train(task, generations, n_seeds, popsize=6, share=0.05):
    """Search the weights (3, 14); print the mean reward, and return weights and both scores."""
    env = ResidualEnv(gymnasium.make(handsim.environments.ID, task=task), share)
    shape, seeds = (env.action_space.shape[0], 14), range(1, 1 + n_seeds)
    search = cma.CMAEvolutionStrategy(
        np.zeros(np.prod(shape)), 0.3, {"popsize": popsize, "seed": 1, "verbose": -9}
    )
    best, known = np.zeros(shape), np.mean([grasped(env, np.zeros(shape), s)[0] for s in seeds])
    print(f"the controller alone: {known:.3f}")
    alone = known
    for generation in range(generations):
        tried = search.ask()
        scores = [np.mean([grasped(env, x.reshape(shape), s)[0] for s in seeds]) for x in tried]
        search.tell(tried, [-score for score in scores])
        if max(scores) > known:
            best, known = tried[int(np.argmax(scores))].reshape(shape), max(scores)
        print(f"generation {generation + 1}: best {max(scores):.3f}, so far {known:.3f}")
    env.close()
    return best, alone, known


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--task", default="pen-write")
    parser.add_argument("--generations", type=int, default=8)
    parser.add_argument("--seeds", type=int, default=3)
    asked = parser.parse_args()
    train(asked.task, asked.generations, asked.seeds)
