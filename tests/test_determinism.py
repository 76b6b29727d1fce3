"""The same seed gives the same bits, in this process and in another."""

import hashlib
import os
import subprocess
import sys

import pytest

GRASP = """
import hashlib, sys
from handsim import Conditions, GraspController, data_folder, demonstrate, task_by_name
from handsim.grasping.planning.grasper import ControllerGrasper
from handsim.grasping.conditions import perturb

task, conditions = task_by_name("cube-raise"), perturb(Conditions(), int(sys.argv[2]))
if sys.argv[1] == "demonstrator":
    rollout = demonstrate(task, conditions)
else:
    controller = GraspController.load(data_folder("assets") / "controller.npz")
    rollout = ControllerGrasper(controller, "replay")(task, conditions)
print(hashlib.sha256(rollout.qpos.tobytes() + rollout.ctrl.tobytes()).hexdigest())
"""

LEARN = """
import hashlib
from handsim import data_folder, learn_controller, read_recordings

recordings = read_recordings(data_folder("assets") / "experiments")[:8]
print(learn_controller(recordings, seed=3).controller.digest)
"""


def fresh_process(code: str, *args: object, threads: int = 1) -> str:
    environment = os.environ | {
        "OMP_NUM_THREADS": str(threads),
        "OPENBLAS_NUM_THREADS": str(threads),
    }
    done = subprocess.run(
        [sys.executable, "-c", code, *map(str, args)],
        capture_output=True,
        text=True,
        check=True,
        env=environment,
    )
    return done.stdout.strip()


@pytest.mark.ci
@pytest.mark.slow
@pytest.mark.parametrize("driver", ["demonstrator", "controller"])
def test_grasps_repeat_to_the_bit_across_processes(driver):
    first = fresh_process(GRASP, driver, 1)
    assert len(first) == hashlib.sha256().digest_size * 2
    assert fresh_process(GRASP, driver, 1) == first
    assert fresh_process(GRASP, driver, 2) != first


def test_learning_repeats_to_the_bit_across_processes_and_thread_counts():
    assert fresh_process(LEARN, threads=1) == fresh_process(LEARN, threads=2)
