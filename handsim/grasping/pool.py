"""Do many jobs at once, on this machine or on a Dask cluster, whatever becomes of single workers.

A pool is called with a job and with its arguments by key, and yields keys and results as they
come. What a killed worker was doing is done again.
"""

import logging
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import contextmanager
from itertools import islice
from typing import Any

from handsim.errors import HandsimError, InputError, MissingToolError

Job = Callable[..., Any]
Arguments = Iterable[tuple[Any, tuple[Any, ...]]]
"""Keys, each with the arguments for the job."""
Pool = Callable[[Job, Arguments], Iterator[tuple[Any, Any]]]

INSTALL = "pip install 'handsim[cluster]'"
AHEAD = 2
"""How many jobs are handed out for each that can be done at once."""
TRIES = 3
"""How often in a row a pool of processes may break without a single result."""
WAIT = 30.0
"""For a scheduler, and for its first worker [s]."""
IDLE = 30
"""After which a process that has nothing to do ends, as it does when its driver is gone [s]."""
_ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}


def one_by_one(job: Job, arguments: Arguments) -> Iterator[tuple[Any, Any]]:
    """Do the jobs in this process, one after the other."""
    for key, values in arguments:
        yield key, job(*values)


def in_order(pool: Pool, job: Job, arguments: Iterable[tuple[Any, ...]]) -> Iterator[Any]:
    """Do a job for each tuple of arguments and yield the results in their order, as they come."""
    waiting: dict[int, Any] = {}
    following = 0
    for number, result in pool(job, enumerate(arguments)):
        waiting[number] = result
        while following in waiting:
            yield waiting.pop(following)
            following += 1


def processes(n_jobs: int) -> Pool:
    """Return a pool of processes on this machine.

    Processes that are killed, by the system for want of memory for instance, are replaced. What
    they were doing is done again at the end, job by job, so that a job that kills its process
    keeps no other from being done; the pool raises `HandsimError` when it does so again and again.
    """
    if n_jobs == 1:
        return one_by_one

    def pool(job: Job, arguments: Arguments) -> Iterator[tuple[Any, Any]]:
        lost: list[tuple[Any, tuple[Any, ...]]] = []
        yield from _in_processes(job, arguments, n_jobs, AHEAD * n_jobs, lost)
        for each in lost:
            again = [each]
            for _ in range(TRIES):
                retried, again = again, []
                yield from _in_processes(job, retried, n_jobs, 1, again)
            if again:
                raise _killed()

    return pool


def _in_processes(
    job: Job, arguments: Arguments, n_jobs: int, ahead: int, lost: list[tuple[Any, tuple[Any, ...]]]
) -> Iterator[tuple[Any, Any]]:
    """Do each job once, ``ahead`` of them handed out; add those to ``lost`` that were killed."""
    # Of joblib's own pool, not through its Parallel: a result that is there stays when others are
    # lost.
    from joblib.externals.loky import get_reusable_executor
    from joblib.externals.loky.process_executor import BrokenProcessPool

    waiting = iter(arguments)
    begun: dict[Future[Any], tuple[Any, tuple[Any, ...]]] = {}
    breaks = 0
    try:
        while True:
            # A pool that broke is replaced here.
            executor = get_reusable_executor(n_jobs, timeout=IDLE, env=_ONE_THREAD)
            for key, values in islice(waiting, ahead - len(begun)):
                begun[executor.submit(job, *values)] = (key, values)
            if not begun:
                return
            done = wait(begun, return_when=FIRST_COMPLETED).done
            killed = [
                future for future in done if isinstance(future.exception(), BrokenProcessPool)
            ]
            lost += [begun.pop(future) for future in killed]
            for future in done.difference(killed):
                breaks = 0
                yield begun.pop(future)[0], future.result()
            breaks += bool(killed)
            if breaks == TRIES and ahead > 1:
                raise _killed()
    finally:
        if begun:  # interrupted
            get_reusable_executor(n_jobs, timeout=IDLE, env=_ONE_THREAD).shutdown(kill_workers=True)


def _killed() -> HandsimError:
    return HandsimError(
        f"worker processes were killed {TRIES} times in a row, perhaps for want of memory; what is "
        "done is kept: go on with fewer --jobs"
    )


@contextmanager
def dask_cluster(address: str) -> Iterator[Pool]:
    """Connect to a Dask scheduler and give a pool of its workers.

    The scheduler does again what a lost worker was doing. Jobs carry all that they need, so that
    workers share no files with this machine.

    Parameters
    ----------
    address
        Such as ``tcp://10.0.0.1:8786``.

    Raises
    ------
    MissingToolError
        If Dask is not installed.
    InputError
        If no scheduler answers there, or it has no workers.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise MissingToolError(f"Dask is not installed; install it with {INSTALL}") from error
    try:
        if "://" not in address:  # of nothing, the client would make a cluster of its own
            raise ValueError("no address")
        client = Client(address, timeout=WAIT, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f"no Dask scheduler answers at '{address}'; start one (dask scheduler) and give its "
            "address, such as tcp://10.0.0.1:8786"
        ) from error
    with _quiet("distributed", "distributed.client"), client:
        try:
            client.wait_for_workers(1, timeout=WAIT)
        except TimeoutError as error:
            raise InputError(
                f"the Dask scheduler at {address} has no workers; start one: dask worker {address} "
                "--nthreads 1"
            ) from error
        yield lambda job, arguments: _on_cluster(client, job, arguments)


@contextmanager
def _quiet(*loggers: str) -> Iterator[None]:
    """Keep loggers from telling with a traceback what is told in one line."""
    kept = {name: logging.getLogger(name).level for name in loggers}
    for name in loggers:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for name, level in kept.items():
            logging.getLogger(name).setLevel(level)


def _on_cluster(client: Any, job: Job, arguments: Arguments) -> Iterator[tuple[Any, Any]]:
    """Keep the workers busy, a few jobs ahead, and yield what is done."""
    from distributed import as_completed
    from distributed.client import FutureCancelledError
    from distributed.comm.core import CommClosedError
    from distributed.scheduler import KilledWorker

    waiting, keys = iter(arguments), {}

    def submit() -> list[Any]:
        """Hand out more; how many workers there are changes."""
        ahead = AHEAD * max(1, sum(client.nthreads().values()))
        jobs = list(islice(waiting, max(1, ahead - len(keys))))
        begun = {client.submit(job, *values, pure=False): key for key, values in jobs}
        keys.update(begun)
        return list(begun)

    try:
        done = as_completed(submit(), loop=client.loop, raise_errors=False)
        for future in done:
            result = future.result()
            yield keys.pop(future), result
            done.update(submit())
    except KilledWorker as error:
        raise HandsimError(
            "a run was lost with its Dask worker several times, perhaps for want of memory; what "
            "is done is kept: give the workers more and go on"
        ) from error
    except (FutureCancelledError, CommClosedError, TimeoutError) as error:
        raise HandsimError(
            "the Dask scheduler was lost; what is done is kept: start it again and go on"
        ) from error
    except ImportError as error:
        raise HandsimError(f"Dask workers lack a package ({error}); {INSTALL} there") from error
