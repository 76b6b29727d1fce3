"""How fast many grasps at once are: in the worlds of mujoco_warp, and on MuJoCo's batches.

Run: .venv/bin/python -m tests.benchmarks.many_worlds [--task NAME] [--worlds N ...] [--cpu N]

Perturbed trials of the built-in controller by its shipped plan. Each number of worlds is run twice,
since the first run compiles; the second one counts. Verdicts are compared run by run.
"""

import argparse
from time import perf_counter

import numpy as np

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions, perturb
from handsim.grasping.planning.plan_store import shipped_plans
from handsim.grasping.rollout.batch import grasp_batch
from handsim.grasping.rollout.record import Rollout
from handsim.learning.controller import GraspController
from handsim.tasks.table_one import task_by_name

FIRST_SEED = 20_001


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--task", default="cube-raise")
    parser.add_argument("--worlds", type=int, nargs="+", default=[64, 512])
    parser.add_argument("--cpu", type=int, default=64, help="runs on MuJoCo's batches")
    parser.add_argument("--threads", type=int, default=None)
    asked = parser.parse_args()
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    usual, task = Conditions(), task_by_name(asked.task)
    plan = shipped_plans(controller.digest, usual).read()[task.name]

    def timed(n: int, device) -> tuple[float, float, list[Rollout]]:
        trials = [perturb(usual, FIRST_SEED + i) for i in range(n)]
        began = perf_counter()
        runs = grasp_batch(controller, task, plan, trials, asked.threads, device)
        took = perf_counter() - began
        return took, sum(float(run.time[-1]) for run in runs), runs

    took, simulated, known = timed(asked.cpu, "cpu")
    print(
        f"{task.name}, MuJoCo, {asked.cpu} runs: {took:.1f} s, {asked.cpu / took:.1f} runs a "
        f"second, {simulated / took:.0f} s of simulated time a second, "
        f"{sum(run.outcome.success for run in known)} held",
        flush=True,
    )
    for n in asked.worlds:
        first, _, _ = timed(n, "warp")
        took, simulated, runs = timed(n, "warp")
        both = list(zip(runs, known, strict=False))
        same = sum(a.outcome.success == b.outcome.success for a, b in both)
        apart = [np.abs(a.qpos[: len(b.qpos)] - b.qpos[: len(a.qpos)]).max() for a, b in both]
        print(
            f"{task.name}, mujoco_warp, {n} worlds: {took:.1f} s (first time {first:.1f} s), "
            f"{n / took:.1f} runs a second, {simulated / took:.0f} s of simulated time a second, "
            f"{sum(run.outcome.success for run in runs)} held; verdict as MuJoCo's in {same} of "
            f"{len(both)}, coordinates {np.median(apart):.3f} apart in the median",
            flush=True,
        )


if __name__ == "__main__":
    main()
