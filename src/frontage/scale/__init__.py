"""Executors: the same tasks serially or in processes."""

from frontage.scale.executor import Executor, ProcessExecutor, SerialExecutor, make_executor

__all__ = ["Executor", "ProcessExecutor", "SerialExecutor", "make_executor"]
