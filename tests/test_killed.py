"""Killed at any moment, a writer leaves the old file or the new one."""

import subprocess
import sys

import pytest

SCRIPT = """
import os, random, signal, sys, time
from pathlib import Path

from handsim import GraspController, data_folder, demonstrate, Conditions, task_by_name
from handsim import read_rollout, write_rollout
from handsim.baseline import read_baseline, write_baseline
from handsim.baseline.check import record_baseline

folder, kills = Path(sys.argv[1]), int(sys.argv[2])
controller = GraspController.load(data_folder("assets") / "controller.npz")
baseline = record_baseline(controller)
rollout = demonstrate(task_by_name("cube-raise"), Conditions())

def write():
    controller.save(folder / "controller.npz")
    write_baseline(baseline, folder / "baseline.npz")
    write_rollout(rollout, folder / "rollout.npz")

def read():
    assert GraspController.load(folder / "controller.npz").digest == controller.digest
    assert read_baseline(folder / "baseline.npz").results.inputs == baseline.results.inputs
    assert len(read_rollout(folder / "rollout.npz").time) == len(rollout.time)

start = time.perf_counter()
write()
took = time.perf_counter() - start
moments = random.Random(7)
unfinished = 0
for _ in range(kills):
    child = os.fork()
    if child == 0:
        write()
        os._exit(0)
    time.sleep(moments.uniform(0.0, took))
    os.kill(child, signal.SIGKILL)
    unfinished += os.WIFSIGNALED(os.waitpid(child, 0)[1])
    read()
print(unfinished)
"""


@pytest.mark.ci
@pytest.mark.slow
def test_fifty_kills_leave_no_unreadable_file(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(tmp_path), "50"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) >= 25  # else the moments were too late to hit the writing
