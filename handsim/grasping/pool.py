"""Do many jobs at once, in processes of this machine or on a Dask cluster.

A pool is a function. It is called with a job and with the job's arguments by key, and yields keys
and results as they come. When a process is killed, its job is done again.
"""

import os
import pickle
import signal
import traceback
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from itertools import islice
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from typing import Any, cast

from handsim.errors import HandsimError, InputError, MissingToolError, quiet_logs

Job = Callable[..., Any]
Keyed = tuple[Any, tuple[Any, ...]]
"""A key, and the arguments of a job."""
Arguments = Iterable[Keyed]
Pool = Callable[[Job, Arguments], Iterator[tuple[Any, Any]]]

INSTALL = "pip install 'handsim[cluster]'"
AHEAD = 2
"""Jobs handed out to a cluster for each thread of its workers."""
TRIES = 3
"""How often a job that kills its process is tried alone before it is given up."""
WAIT = 30.0
"""How long to wait for a scheduler, and for its first worker [s]."""
_ONE_THREAD = {f"{name}_NUM_THREADS": "1" for name in ("OMP", "OPENBLAS", "MKL")}


def one_by_one(job: Job, arguments: Arguments) -> Iterator[tuple[Any, Any]]:
    """Do the jobs in this process, one after the other."""
    for key, values in arguments:
        yield key, job(*values)


def in_order(pool: Pool, job: Job, arguments: Iterable[tuple[Any, ...]]) -> Iterator[Any]:
    """Do a job for each tuple of arguments and yield the results in the order of the arguments."""
    waiting: dict[int, Any] = {}
    following = 0
    for number, result in pool(job, enumerate(arguments)):
        waiting[number] = result
        while following in waiting:
            yield waiting.pop(following)
            following += 1


def processes(n_jobs: int) -> Pool:
    """Return a pool of ``n_jobs`` processes on this machine.

    A process does one job at a time, so that a killed process loses that job alone. The system
    kills processes for want of memory, for instance. A lost job is done again when all others are
    done, with no other beside it. Where it kills its process `TRIES` times then, the pool raises
    `HandsimError` after its last result. It raises at once where processes are killed `TRIES`
    times each without a single result in between.

    The processes are started afresh (``spawn``) and import the main script, whose work must
    therefore stand under ``if __name__ == "__main__":``. Jobs and results are pickled. When the
    caller stops asking for results, all processes are killed.
    """
    return one_by_one if n_jobs == 1 else partial(_in_processes, n_jobs)


def _in_processes(n_jobs: int, job: Job, arguments: Arguments) -> Iterator[tuple[Any, Any]]:
    workers = _Workers()
    try:
        lost: list[Keyed] = []
        yield from workers.do(job, arguments, n_jobs, lost)
        workers.kill()  # so that what is done alone has their memory as well
        given_up = False
        for each in lost:
            again: list[Keyed] = [each]
            for _ in range(TRIES):
                retried = again
                again = []
                yield from workers.do(job, retried, 1, again)
            given_up = given_up or bool(again)
        if given_up:
            raise _killed()
    finally:
        workers.kill()


class _Workers:
    """Processes, each of which does one job at a time."""

    def __init__(self) -> None:
        self._idle: list[_Worker] = []
        self._busy: dict[Connection, tuple[_Worker, Keyed]] = {}

    def do(
        self,
        job: Job,
        arguments: Arguments,
        n_at_once: int,
        lost: list[Keyed],
    ) -> Iterator[tuple[Any, Any]]:
        """Do each job once and yield the results; add those that were killed to ``lost``."""
        waiting = iter(arguments)
        n_killed = 0
        self._begin(job, list(islice(waiting, n_at_once)))
        while self._busy:
            answers: list[tuple[Any, bytes]] = []
            for connection in cast("list[Connection]", wait(list(self._busy))):
                worker, (key, values) = self._busy.pop(connection)
                try:
                    answers.append((key, connection.recv_bytes()))
                    self._idle.append(worker)
                except (EOFError, OSError):
                    worker.check_started()
                    lost.append((key, values))
                    n_killed += 1
            if answers:
                n_killed = 0
            elif n_killed >= TRIES * n_at_once > TRIES:
                raise _killed()
            # Before the results are looked at, which takes its time.
            self._begin(job, list(islice(waiting, n_at_once - len(self._busy))))
            for key, answer in answers:
                result, error = pickle.loads(answer)
                if error is not None:
                    raise error
                yield key, result

    def _begin(self, job: Job, arguments: list[Keyed]) -> None:
        """Give each of these jobs to a process that has none."""
        # All start before the first is spoken to, since that one has to be waited for.
        while len(self._idle) < len(arguments):
            self._idle.append(_Worker())
        for key, values in arguments:
            worker = self._idle.pop()
            self._busy[worker.connection] = worker, (key, values)
            worker.give(job, values)

    def kill(self) -> None:
        """End all processes, whatever they are doing."""
        for worker in (*self._idle, *(worker for worker, _ in self._busy.values())):
            worker.kill()
        self._idle.clear()
        self._busy.clear()


class _Worker:
    """A process, seen from the one that started it."""

    def __init__(self) -> None:
        context = get_context("spawn")
        self.connection, theirs = context.Pipe()
        self._process = context.Process(target=_work, args=(theirs,), daemon=True)
        with _environment(_ONE_THREAD):  # which libraries read when they are loaded
            self._process.start()
        theirs.close()

    def give(self, job: Job, values: tuple[Any, ...]) -> None:
        """Give it a job; its answer comes by the connection."""
        asked = pickle.dumps((job, values), pickle.HIGHEST_PROTOCOL)
        with suppress(OSError):  # it was killed: so its connection has ended, which is seen there
            self.connection.send_bytes(asked)

    def check_started(self) -> None:
        """Check that a process which has ended was killed.

        Raises
        ------
        HandsimError
            If it ended by an error before it could take a job.
        """
        self._process.join()
        code = self._process.exitcode
        self.kill()
        if code == 1:
            raise HandsimError(
                "a worker process ended with an error as it started (exit code 1, see above); in a "
                "script, put what starts workers under: if __name__ == '__main__':"
            )

    def kill(self) -> None:
        """End the process."""
        self.connection.close()
        self._process.kill()
        self._process.join()


def _work(connection: Connection) -> None:
    """Do jobs as they come, until the process that gives them is gone."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that gives the jobs decides
    with suppress(EOFError, OSError):
        while True:
            connection.send_bytes(_answer(connection.recv_bytes()))


def _answer(asked: bytes) -> bytes:
    """Do a pickled job and return its result and None, or None and its error, pickled."""
    try:
        job, values = pickle.loads(asked)
        return pickle.dumps((job(*values), None), pickle.HIGHEST_PROTOCOL)
    except BaseException as error:
        told = "".join(traceback.format_exception(error))
        error.add_note(f"In a worker process:\n{told}")
        try:
            answer = pickle.dumps((None, error))
            pickle.loads(answer)
        except Exception:
            return pickle.dumps((None, RuntimeError(told)))
        return answer


@contextmanager
def _environment(changes: dict[str, str]) -> Generator[None, None, None]:
    """Change environment variables for a while."""
    before = {name: os.environ.get(name) for name in changes}
    os.environ.update(changes)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _killed() -> HandsimError:
    return HandsimError(
        f"worker processes were killed {TRIES} times in a row, perhaps for want of memory; what is "
        "done is kept: go on with fewer --jobs"
    )


@contextmanager
def dask_cluster(address: str) -> Generator[Pool, None, None]:
    """Connect to a Dask scheduler and give a pool of its workers.

    The scheduler repeats the jobs of a lost worker. Jobs contain all that they need: workers need
    no files of this machine.

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
    with quiet_logs("distributed", "distributed.client"), client:
        try:
            client.wait_for_workers(1, timeout=WAIT)
        except TimeoutError as error:
            raise InputError(
                f"the Dask scheduler at {address} has no workers; start one: dask worker {address} "
                "--nthreads 1"
            ) from error
        yield lambda job, arguments: _on_cluster(client, job, arguments)


def _on_cluster(client: Any, job: Job, arguments: Arguments) -> Iterator[tuple[Any, Any]]:
    """Keep the workers busy, a few jobs ahead, and yield what is done."""
    from distributed import as_completed
    from distributed.client import FutureCancelledError
    from distributed.comm.core import CommClosedError
    from distributed.scheduler import KilledWorker

    waiting = iter(arguments)
    keys: dict[Any, Any] = {}

    def submit() -> list[Any]:
        """Hand out more jobs; the number of workers may have changed."""
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
