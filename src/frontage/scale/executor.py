"""Runs tasks one after the other or in a pool of processes, with the same bytes as output.

A task is a function of one picklable item that returns a picklable result. Tasks share nothing, so the number
of workers only changes the time. Every worker uses a single thread, because processes that each start a pool
of threads are slower, and because BLAS sums in a different order with a different number of threads.
"""

import ctypes
import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.process import BaseProcess
from types import TracebackType
from typing import Any, Protocol, Self, TypeVar

from frontage.errors import FrontageError

Item = TypeVar("Item")
Result = TypeVar("Result")

_PR_SET_PDEATHSIG = 1  # of prctl(2)
_M_TRIM_THRESHOLD, _M_TOP_PAD, _M_MMAP_THRESHOLD = -1, -2, -3  # of mallopt(3)
_KEPT_BYTES = 1 << 30  # of freed memory that a process may hold
_MAPPED_BYTES = 1 << 28  # larger arrays always get new memory and give it back
_GROWTH_BYTES = 1 << 26
_MOST_PER_CORE = 4  # processes; more of them only take memory
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


class Executor(Protocol):
    """Runs a task over items and returns the results in the order of the items."""

    @property
    def workers(self) -> int:
        """The number of tasks that run at once."""
        ...

    def map(
        self, task: Callable[[Item], Result], items: Sequence[Item], done: Callable[[int], None] | None = None
    ) -> list[Result]:
        """Returns the results of `task` in the order of `items`; calls `done(i)` when item i has finished."""
        ...

    def __enter__(self) -> Self: ...

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None: ...


class SerialExecutor:
    """Runs one task after the other in this process."""

    workers = 1

    def map(
        self, task: Callable[[Item], Result], items: Sequence[Item], done: Callable[[int], None] | None = None
    ) -> list[Result]:
        """See `Executor.map`."""
        return list(self._each(task, items, done))

    @staticmethod
    def _each(
        task: Callable[[Item], Result], items: Sequence[Item], done: Callable[[int], None] | None
    ) -> Iterator[Result]:
        for i, item in enumerate(items):
            yield task(item)
            if done:
                done(i)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return None


class ProcessExecutor:
    """Runs tasks in a pool of `workers` processes, which are spawned so that they inherit no state.

    The pool starts with the first task and ends with the `with` block. Any exception, including Ctrl-C,
    terminates the workers at once.
    """

    def __init__(self, workers: int) -> None:
        self.workers = workers
        self._pool: ProcessPoolExecutor | None = None

    def map(
        self, task: Callable[[Item], Result], items: Sequence[Item], done: Callable[[int], None] | None = None
    ) -> list[Result]:
        """See `Executor.map`. Raises FrontageError (W300) when a worker dies, mostly for lack of memory."""
        pool = self._started()
        with _undisturbed():  # the first task starts the workers
            futures: dict[Future[Result], int] = {pool.submit(task, item): i for i, item in enumerate(items)}
        pending: set[Future[Result]] = set(futures)
        results: dict[int, Result] = {}
        try:
            while pending:
                finished, pending = wait(pending, return_when=FIRST_COMPLETED)
                for future in sorted(finished, key=futures.__getitem__):
                    results[futures[future]] = future.result()
                    if done:
                        done(futures[future])
        except BrokenProcessPool:
            self._kill()
            raise FrontageError(
                f"a worker process was killed, most likely because memory ran out; run again with fewer than "
                f"{self.workers} --workers (finished results are kept)",
                code="W300",
            ) from None
        return [results[i] for i in range(len(items))]

    def _started(self) -> ProcessPoolExecutor:
        if self._pool is None:
            context = multiprocessing.get_context("spawn")
            started = min(self.workers, _MOST_PER_CORE * (os.cpu_count() or 1))
            self._pool = ProcessPoolExecutor(started, mp_context=context, initializer=_quiet_worker)
        return self._pool

    def _kill(self) -> None:
        pool, self._pool = self._pool, None
        if pool is None:
            return
        workers = list((getattr(pool, "_processes", None) or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for process in workers:
            process.terminate()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None:
            self._kill()
        elif self._pool is not None:
            self._pool.shutdown()
            self._pool = None


def make_executor(workers: int = 1) -> Executor:
    """Returns a serial executor for one worker and a process pool for more. Raises ValueError below 1."""
    if workers < 1:
        raise ValueError(f"workers must be at least 1, not {workers}")
    return SerialExecutor() if workers == 1 else ProcessExecutor(workers)


@contextmanager
def _undisturbed() -> Iterator[None]:
    """Puts SIGINT and SIGTERM off until the end of the block.

    A worker whose parent is interrupted while it starts it would end with a traceback.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    held: list[int] = []
    before = {n: signal.signal(n, lambda n, _: held.append(n)) for n in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)
        if held:
            signal.raise_signal(held[0])


def _quiet_worker() -> None:
    """Prepares a worker: it uses one thread, leaves Ctrl-C to its parent, and ends when its parent ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    _end_with_parent()
    for name in THREAD_VARIABLES:
        os.environ[name] = "1"
    cv2: Any = __import__("cv2")
    cv2.setNumThreads(1)
    keep_freed_memory()


def keep_freed_memory() -> None:
    """Lets this process use freed memory again instead of giving it back to the system, up to one gibibyte.

    Otherwise every array of some megabytes is new memory, which the kernel clears page by page: up to a fifth
    of the processor time of an ortho-image. Does nothing where the C library is not the one of GNU.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None) if sys.platform == "linux" else None
    if mallopt is not None:
        for parameter, size in (
            (_M_MMAP_THRESHOLD, _MAPPED_BYTES),
            (_M_TRIM_THRESHOLD, _KEPT_BYTES),
            (_M_TOP_PAD, _GROWTH_BYTES),
        ):
            mallopt(parameter, size)


def _end_with_parent() -> None:
    """Makes sure that a worker does not outlive its parent, which may be killed without a chance to say so.

    On Linux the kernel sends the signal, whatever the worker is doing; elsewhere a thread watches the parent.
    """
    parent = multiprocessing.parent_process()
    if parent is None:
        return
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: BaseProcess) -> None:
    parent.join()
    os._exit(1)
