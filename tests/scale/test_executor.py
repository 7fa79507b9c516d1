"""Executors: order, equality at any number of workers, failures."""

import os
import signal

import cv2
import pytest

from frontage.errors import FrontageError
from frontage.scale import ProcessExecutor, SerialExecutor, make_executor
from frontage.scale.executor import _undisturbed


def square(number: int) -> int:
    return number * number


def threads(_: int) -> tuple[int, str | None]:
    return cv2.getNumThreads(), os.environ.get("OMP_NUM_THREADS")


def fail_at_three(number: int) -> int:
    if number == 3:
        raise FrontageError("item 3 is bad")
    return number


def die(_: int) -> None:
    os._exit(9)


def test_serial_and_processes_give_the_same_in_order() -> None:
    finished: list[int] = []
    with make_executor(1) as one, make_executor(2) as two:
        assert isinstance(one, SerialExecutor) and isinstance(two, ProcessExecutor)
        assert (
            one.map(square, range(9))
            == two.map(square, range(9), finished.append)
            == [k * k for k in range(9)]
        )
    assert sorted(finished) == list(range(9))


def test_workers_use_one_thread_each() -> None:
    with make_executor(2) as executor:
        assert executor.map(threads, [0]) == [(1, "1")]


def test_an_error_of_a_task_is_raised_unchanged() -> None:
    for workers in (1, 2):
        with pytest.raises(FrontageError, match="item 3 is bad"), make_executor(workers) as executor:
            executor.map(fail_at_three, range(5))


def test_a_killed_worker_raises_one_clear_error() -> None:
    with pytest.raises(FrontageError, match="fewer than 2 --workers"), make_executor(2) as executor:
        executor.map(die, [0])


def test_fewer_than_one_worker_is_refused() -> None:
    with pytest.raises(ValueError, match="at least 1"):
        make_executor(0)


def test_an_interrupt_waits_until_the_workers_have_started() -> None:
    # A shell lets programs in its background ignore Ctrl-C, and these tests may be one.
    outside, started = signal.signal(signal.SIGINT, signal.default_int_handler), False
    try:
        with pytest.raises(KeyboardInterrupt), _undisturbed():
            signal.raise_signal(signal.SIGINT)
            started = True
        assert started and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, outside)
