"""A sweep killed anywhere goes on to the table of an undisturbed one, to the byte."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

psutil = pytest.importorskip("psutil")

SCRIPT = """
import os, random, signal, sys, time
from pathlib import Path
from types import SimpleNamespace

from handsim import task_by_name
from handsim.grasping.sweep.runner import COLUMNS, sweep
from handsim.grasping.sweep.graspers import Source, SweepGraspers
from handsim.grasping.pool import one_by_one
from handsim.grasping.sweep.spec import SweepSpec
from handsim.grasping.sweep.table import open_table
from handsim.tasks.rules import Outcome

folder, kills = Path(sys.argv[1]), int(sys.argv[2])
outcome = Outcome(True, None, 0.12, 0.001, 2.0, 3.1, 4, 0.0005)

def pretend(task, conditions):
    return SimpleNamespace(outcome=outcome, conditions=conditions)

sources = {"script": Source("1", lambda conditions: pretend)}
spec = SweepSpec((task_by_name("cube-raise"),), ("script",), seeds=tuple(range(60)))

def scattered(job, arguments):
    "Results come in any order."
    arguments = list(arguments)
    random.Random(os.getpid()).shuffle(arguments)
    return one_by_one(job, arguments)

def run(path, pool):
    with open_table(path, "key", COLUMNS, spec.n_runs) as table:
        sweep(spec, SweepGraspers(spec, sources, table), table, pool)

def rows(path):
    return path.read_bytes().count(b"\\n") - 1 if path.is_file() else 0

run(folder / "undisturbed.csv", one_by_one)
longest = 0.2  # until a child is killed [s]; becomes what hits it in its work
moments = random.Random(7)
unfinished = amidst = tables = 0
while amidst < kills and unfinished < 20 * kills:
    tables += 1
    path = folder / f"{tables}.csv"
    while True:
        before = rows(path)
        child = os.fork()
        if child == 0:
            run(path, scattered)
            os._exit(0)
        time.sleep(moments.uniform(0.0, longest))
        os.kill(child, signal.SIGKILL)
        if not os.WIFSIGNALED(os.waitpid(child, 0)[1]):
            longest *= 0.8
            break
        unfinished += 1
        amidst += rows(path) > before
        longest *= 1.0 if rows(path) > before else 1.05
    assert path.read_bytes() == (folder / "undisturbed.csv").read_bytes()
print(amidst, tables)
"""


@pytest.mark.ci
@pytest.mark.slow
def test_killed_forty_times_amidst_its_work(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, str(tmp_path), "40"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    amidst, tables = map(int, done.stdout.split())
    assert amidst >= 40
    assert tables > 1


MAIN = """
import signal
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored by what a shell runs in the back
from handsim.cli import main
main()
"""
FEW = """
tasks = ["cube-raise"]
controllers = ["demonstrator", "built-in"]
seeds = 5
"""
FIVE_HUNDRED = """
tasks = ["tall-glass-top-move", "mouse-slide", "cup-top-move", "ashtray-move", "cube-raise",
         "pen-move", "jar-move", "jar-unscrew", "phone-view", "stapler-use"]
controllers = ["demonstrator", "built-in"]
seeds = 25
"""


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(FEW, id="few", marks=[pytest.mark.slow, pytest.mark.ci]),
        pytest.param(FIVE_HUNDRED, id="five hundred", marks=pytest.mark.slow),
    ],
)
def undisturbed(request, tmp_path_factory) -> tuple[Path, bytes]:
    """A sweep's file, and the table it gives when nothing happens."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "sweep.toml").write_text(request.param)
    with running(folder / "sweep.toml", folder / "undisturbed.csv", "--jobs", 2) as sweep:
        assert sweep.wait() == 0
    return folder / "sweep.toml", (folder / "undisturbed.csv").read_bytes()


@contextlib.contextmanager
def running(
    file: Path, output: Path, *options: object, stderr: int | None = None
) -> Iterator[subprocess.Popen]:
    """Run `handsim sweep`; at the end nothing of it is left."""
    arguments = ["sweep", str(file), "-o", str(output), *map(str, options)]
    command = [sys.executable, "-c", MAIN, *arguments]
    process = subprocess.Popen(
        command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=stderr
    )
    try:
        yield process
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)  # its own group: orphaned workers as well
        process.wait()


def wait_for_rows(process: subprocess.Popen, output: Path, n: int) -> None:
    """Wait until a table has ``n`` rows, while the sweep runs."""
    while not output.is_file() or output.read_bytes().count(b"\n") < 1 + n:
        assert process.poll() is None, "it ended before there was anything to kill"
        time.sleep(0.02)


def workers_of(process: subprocess.Popen) -> list[psutil.Process]:
    children = psutil.Process(process.pid).children(recursive=True)
    return [child for child in children if busy(child)]


def busy(process: psutil.Process) -> bool:
    """Whether it is a worker, and not what counts shared resources (`resource_tracker`)."""
    return "resource_tracker" not in " ".join(process.cmdline())


@pytest.mark.timeout(3600)
def test_driver_and_worker_killed(undisturbed, tmp_path):
    file, expected = undisturbed
    n_runs, output = expected.count(b"\n") - 1, tmp_path / "results.csv"
    with running(file, output, "--jobs", 2) as sweep:
        wait_for_rows(sweep, output, n_runs // 5)
        workers_of(sweep)[0].kill()
        wait_for_rows(sweep, output, n_runs // 2)
        sweep.kill()
        assert sweep.wait() == -signal.SIGKILL
    interrupted = output.read_bytes()
    assert n_runs // 2 <= interrupted.count(b"\n") - 1 < n_runs
    with running(file, output, "--jobs", 2) as sweep:
        assert sweep.wait() == 0
    assert output.read_bytes() == expected


@pytest.mark.timeout(3600)
def test_a_cluster_loses_one_of_two_workers(undisturbed, tmp_path):
    pytest.importorskip("distributed")
    file, expected = undisturbed
    n_runs, output = expected.count(b"\n") - 1, tmp_path / "results.csv"
    with (
        cluster(tmp_path) as (address, _, workers),
        running(file, output, "--dask", address) as sweep,
    ):
        wait_for_rows(sweep, output, n_runs // 5)
        workers[0].kill()
        assert sweep.wait() == 0
        assert workers[1].poll() is None
    assert output.read_bytes() == expected


@pytest.mark.slow
def test_a_lost_scheduler_is_told_in_a_line_and_what_is_done_is_kept(tmp_path):
    pytest.importorskip("distributed")
    file, output = tmp_path / "sweep.toml", tmp_path / "results.csv"
    file.write_text(FEW)
    with (
        cluster(tmp_path) as (address, scheduler, _),
        running(file, output, "--dask", address, stderr=subprocess.PIPE) as sweep,
    ):
        wait_for_rows(sweep, output, 3)
        scheduler.kill()
        assert sweep.wait() == 2
        assert sweep.stderr is not None
        with sweep.stderr as told:
            said = told.read().decode().splitlines()
    assert len(said) == 2  # how many runs are there already, and this
    assert said[1].startswith("handsim: the Dask scheduler was lost; what is done is kept")
    with running(file, output, "--jobs", 2) as sweep:
        assert sweep.wait() == 0
    assert output.read_bytes().count(b"\n") == 1 + 10


@pytest.mark.ci
@pytest.mark.slow
def test_an_interrupt_ends_driver_and_workers(tmp_path):
    file, output = tmp_path / "sweep.toml", tmp_path / "results.csv"
    file.write_text(FEW)
    with running(file, output, "--jobs", 2) as sweep:
        wait_for_rows(sweep, output, 3)
        workers = workers_of(sweep)
        assert len(workers) == 2
        sweep.send_signal(signal.SIGINT)
        assert sweep.wait(20) == 130
        _, alive = psutil.wait_procs(workers, 10)
        assert not alive


@contextlib.contextmanager
def cluster(folder: Path) -> Iterator[tuple[str, subprocess.Popen, list[subprocess.Popen]]]:
    """A Dask scheduler and two workers with one thread each, as processes."""
    import json

    where = folder / "scheduler.json"
    quiet = {"cwd": folder, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    dask = [sys.executable, "-m", "dask"]
    host = ["--host", "127.0.0.1", "--no-dashboard", "--scheduler-file", str(where)]
    started = [subprocess.Popen([*dask, "scheduler", "--port", "0", *host], **quiet)]
    try:
        while not (where.is_file() and where.stat().st_size):
            assert started[0].poll() is None
            time.sleep(0.05)
        options = ["--nthreads", "1", "--no-nanny", "--local-directory", str(folder)]
        started += [subprocess.Popen([*dask, "worker", *host, *options], **quiet) for _ in "12"]
        yield json.loads(where.read_text())["address"], started[0], started[1:]
    finally:
        for process in started:
            process.kill()
            process.wait()
