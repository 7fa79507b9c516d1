"""Executors, which run the same tasks one after the other or in a pool of processes.

`make_executor` is the entry function. Results come back in the order of the items, and the number of workers
changes the time a run takes but never a byte of its output.
"""

from frontage.scale.executor import Executor, ProcessExecutor, SerialExecutor, make_executor

__all__ = ["Executor", "ProcessExecutor", "SerialExecutor", "make_executor"]
