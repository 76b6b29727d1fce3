"""Grasps by replaying the recorded movements through a few principal components, nothing planned.

Run: .venv/bin/python tests/benchmarks/grasp_replay.py [--components N ...] [--trials N] [--seed N]

Each built-in recording is put through the components and played to the actuators in its own time;
the palm goes where the script has it and the squeeze is the script's. What this loses against the
script is what the components lose; what `handsim grasp` gains over it is what planning is worth.
"""

import argparse
from dataclasses import dataclass, replace

import numpy as np
from sklearn.decomposition import PCA

from handsim.files import data_folder
from handsim.grasping.conditions import Conditions, trial_conditions
from handsim.grasping.judging.rates import wilson_interval
from handsim.grasping.plan import schedule_for
from handsim.grasping.planning.demonstrator import scripted_plan
from handsim.grasping.rollout.compiled_scene import Scene
from handsim.grasping.rollout.record import Rollout
from handsim.grasping.rollout.run import simulate
from handsim.hand.mjcf import build_hand
from handsim.hand.model import HandModel
from handsim.joints import clip_to_range
from handsim.recordings.folder import read_recordings
from handsim.recordings.recording import Recording, RecordingSet
from handsim.tasks.table_one import task_by_name

COMPONENTS = (3, 5, 7, 22)


@dataclass(frozen=True)
class ReplayDriver:
    """Plays a movement whatever is read.

    Attributes
    ----------
    time, q : (n,) [s], (n, 22) [rad]
    """

    time: np.ndarray
    q: np.ndarray
    name: str = "replay"

    @property
    def reach(self) -> float:
        return float(self.time[-1])

    def start(self, n: int) -> np.ndarray:
        return np.empty((n, 0))

    def step(
        self, time: float, dt: float, reference: np.ndarray, readings: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        return np.array([np.interp(time, self.time, joint) for joint in self.q.T]), reference

    @property
    def destination(self) -> np.ndarray:
        return self.q[-1]

    def coordinates(self, readings: np.ndarray) -> np.ndarray:
        return np.empty((*readings.shape[:-1], 0))

    def arrived(self, reading: np.ndarray) -> bool:
        return True


def replay(recording: Recording, subspace: PCA, conditions: Conditions) -> Rollout:
    """Grasp as recorded, but for what lies outside the subspace."""
    task = task_by_name(recording.task)
    scene = Scene.build(task, conditions)
    q = clip_to_range(subspace.inverse_transform(subspace.transform(recording.q)))
    hand = HandModel.from_spec(build_hand(conditions.hand))
    scripted, _ = scripted_plan(scene.task, hand)
    plan = replace(scripted, q_start=q[0], q_goal=q[-1])
    driver = ReplayDriver(recording.time - recording.time[0], q)
    return simulate(scene, plan, driver, schedule=replace(schedule_for(task), reach=driver.reach))


def row(n: int, recordings: RecordingSet, conditions: list[Conditions]) -> str:
    """Grasp all with ``n`` components; the first conditions are the nominal ones."""
    subspace = PCA(n, svd_solver="full").fit(np.vstack([r.q for r in recordings]))
    runs = {r.task: [replay(r, subspace, each) for each in conditions] for r in recordings}
    nominal = sum(first.outcome.success for first, *_ in runs.values())
    objects = {task_by_name(t).object_name for t, (run, *_) in runs.items() if run.outcome.success}
    held = sum(run.outcome.success for _, *trials in runs.values() for run in trials)
    trials = len(runs) * (len(conditions) - 1)
    explained = 100 * float(subspace.explained_variance_ratio_.sum())
    perturbed = ""
    if trials:
        low, high = wilson_interval(held, trials)
        perturbed = f"{held} of {trials} ({100 * low:.0f} to {100 * high:.0f} %)"
    return f"| {n} | {explained:.1f} % | {nominal} of {len(runs)} | {len(objects)} | {perturbed} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--components", type=int, nargs="+", default=COMPONENTS)
    parser.add_argument("--trials", type=int, default=0)
    parser.add_argument("--seed", type=int, default=100)
    arguments = parser.parse_args()
    recordings = read_recordings(data_folder("assets") / "experiments")
    conditions = trial_conditions(Conditions(seed=arguments.seed), arguments.trials)
    print("| components | variance | nominal | objects | perturbed |\n|---|---|---|---|---|")
    for n in arguments.components:
        print(row(n, recordings, conditions), flush=True)


if __name__ == "__main__":
    main()
