"""Pools that do not lose what their workers were doing."""

import builtins
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from handsim.errors import HandsimError, InputError, MissingToolError
from handsim.grasping.pool import dask_cluster, in_order, one_by_one, processes


def double(x: int) -> int:
    return 2 * x


def die_once(x: int, folder: str) -> int:
    """Kill the own process, the first time a multiple of 4 comes."""
    mark = Path(folder) / str(x)
    if x % 4 == 0 and not mark.exists():
        mark.touch()
        time.sleep(0.1)
        os.kill(os.getpid(), signal.SIGKILL)
    return 2 * x


def die(x: int) -> int:
    if x == 3:
        time.sleep(0.1)
        os.kill(os.getpid(), signal.SIGKILL)
    return 2 * x


def die_first(x: int) -> int:
    """Kill the own process at the first job, while others take their time."""
    if x == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    time.sleep(0.3)
    return 2 * x


def refuse(x: int) -> int:
    raise InputError(f"{x} is too much")


def numbered(n: int, *more: object):
    return ((i, (i, *more)) for i in range(n))


@pytest.mark.parametrize("n_jobs", [1, 2])
def test_every_key_comes_back_with_its_result(n_jobs):
    assert dict(processes(n_jobs)(double, numbered(20))) == {i: 2 * i for i in range(20)}
    assert list(processes(n_jobs)(double, [])) == []


def test_results_come_in_the_order_of_the_arguments():
    def backwards(job, arguments):
        return reversed([(key, job(*values)) for key, values in arguments])

    for pool in (one_by_one, backwards, processes(2)):
        assert list(in_order(pool, double, [(i,) for i in range(9)])) == list(range(0, 18, 2))


def test_in_one_process_jobs_begin_when_their_results_are_asked_for():
    begun = []

    def arguments():
        for i in range(3):
            begun.append(i)
            yield i, (i,)

    results = one_by_one(double, arguments())
    assert next(results) == (0, 0)
    assert begun == [0]


def test_what_a_killed_process_was_doing_is_done_again(tmp_path):
    results = list(processes(2)(die_once, numbered(12, str(tmp_path))))
    assert sorted(results) == [(i, 2 * i) for i in range(12)]
    assert len(list(tmp_path.iterdir())) == 3


def test_what_kills_its_process_again_and_again_ends_the_work_when_all_else_is_done():
    results = {}
    with pytest.raises(HandsimError, match=r"killed 3 times in a row.* fewer --jobs"):
        for key, result in processes(2)(die, numbered(8)):
            results[key] = result
    assert results == {i: 2 * i for i in range(8) if i != 3}


def test_the_other_jobs_of_that_moment_are_done_before_the_work_ends():
    results = {}
    with pytest.raises(HandsimError, match="killed 3 times in a row"):
        for key, result in processes(2)(die_first, numbered(4)):
            results[key] = result
    assert results == {1: 2, 2: 4, 3: 6}


def test_where_nothing_can_be_done_it_is_not_tried_for_ever():
    with pytest.raises(HandsimError, match="killed 3 times in a row"):
        list(processes(2)(die, ((i, (3,)) for i in range(10**9))))


def nap(x: int) -> int:
    if x:
        time.sleep(60)
    return os.getpid()


def test_who_stops_asking_leaves_no_process_behind():
    psutil = pytest.importorskip("psutil")
    results = processes(2)(nap, numbered(5))
    _, worker = next(results)
    assert psutil.pid_exists(worker)
    results.close()
    deadline = time.monotonic() + 10
    while psutil.pid_exists(worker) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not psutil.pid_exists(worker)


def test_errors_of_a_job_are_passed_on():
    for n_jobs in (1, 2):
        with pytest.raises(InputError, match="is too much"):
            list(processes(n_jobs)(refuse, numbered(2)))


def fail_with_details(x: int) -> int:
    error = ValueError("the value")
    error.details = lambda: x  # which cannot be pickled
    raise error


def lambda_of(x: int):
    return lambda: x


def test_errors_and_results_that_cannot_be_pickled_are_told():
    for job, words in ((fail_with_details, "the value"), (lambda_of, "pickle")):
        with pytest.raises(Exception, match=words):
            list(processes(2)(job, numbered(2)))


def test_the_traceback_of_an_error_comes_with_it():
    with pytest.raises(InputError) as caught:
        list(processes(2)(refuse, numbered(1)))
    (note,) = caught.value.__notes__
    assert 'raise InputError(f"{x} is too much")' in note


def test_arguments_are_asked_for_when_a_process_is_free():
    asked = []

    def arguments():
        for i in range(10**9):
            asked.append(i)
            yield i, (i,)

    results = processes(2)(double, arguments())
    assert [next(results)[1] % 2 for _ in range(5)] == [0] * 5
    results.close()
    assert len(asked) <= 5 + 2 * 2


def environment_of(x: int) -> str | None:
    return os.environ.get("OPENBLAS_NUM_THREADS")


def test_workers_calculate_in_one_thread_and_this_process_as_before(monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "7")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    assert dict(processes(2)(environment_of, numbered(1))) == {0: "1"}
    assert os.environ["OPENBLAS_NUM_THREADS"] == "7"
    assert "MKL_NUM_THREADS" not in os.environ


def test_a_script_that_works_as_it_is_imported_is_told_what_to_do(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "from handsim.grasping.pool import processes\n"
        "from operator import neg\n"
        "print(list(processes(2)(neg, [(1, (1,))])))\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    last = done.stderr.strip().splitlines()[-1]
    assert "HandsimError: a worker process ended with an error as it started" in last
    assert "if __name__ == '__main__':" in last


def test_the_module_is_light():
    said = subprocess.run(
        [sys.executable, "-c", "import sys, handsim.grasping.pool; print(*sys.modules)"],
        capture_output=True, text=True, check=True,
    ).stdout.split()  # fmt: skip
    assert "handsim.grasping.pool" in said
    assert not {"numpy", "mujoco", "joblib", "distributed", "handsim.viewing"} & set(said)


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense", "", "ftp://x", "tcp://:x"])
def test_addresses_where_nobody_answers(address, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("handsim.grasping.pool.WAIT", 0.5)
    with pytest.raises(InputError, match="no Dask scheduler answers"):
        dask_cluster(address).__enter__()


def test_without_dask_the_remedy_is_named(monkeypatch):
    real = builtins.__import__

    def without(name, *args, **kwargs):
        if name == "distributed":
            raise ImportError(name)
        return real(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingToolError, match=r"pip install 'handsim\[cluster\]'"):
        dask_cluster("tcp://127.0.0.1:1").__enter__()
