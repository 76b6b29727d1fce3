"""Pools that do not lose what their workers were doing."""

import builtins
import os
import signal
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
