"""Compares what a raster needs with what the machine has, before the work."""

import contextlib
import os
import shutil
import tempfile
from pathlib import Path

from frontage.errors import InputError

GIB = float(1 << 30)
NOT_METRES = "the coordinates are probably not in metres; export the scan in metres or state its units"
"""The likely cause of a raster that is too large, and what to do."""

_MEMINFO = Path("/proc/meminfo")
_GROUP = Path("/sys/fs/cgroup")  # of a container


def require_memory(need: float, what: str, remedy: str = NOT_METRES) -> None:
    """Raises InputError (I322) if `what` needs more bytes of memory than are available."""
    free = available_memory()
    if free is not None and need > free:
        raise InputError(
            f"{what} needs {need / GIB:.3g} GiB of memory, and {free / GIB:.3g} GiB are available; {remedy}",
            code="I322",
        )


def require_scratch(need: float, what: str, remedy: str = NOT_METRES) -> None:
    """Raises InputError (I322) if `what` needs more bytes in the folder of temporary files than are free."""
    folder = tempfile.gettempdir()
    free = shutil.disk_usage(folder).free
    if need > free:
        raise InputError(
            f"{what} needs {need / GIB:.3g} GiB in {folder}, and {free / GIB:.3g} GiB are free; {remedy}",
            code="I322",
        )


def available_memory() -> float | None:
    """Bytes that can be used without swapping: of the machine, or of its container; None if nothing tells."""
    limits = [*_of_machine(), *_of_container()]
    return min(limits) if limits else None


def _of_machine() -> list[float]:
    with contextlib.suppress(OSError, ValueError):
        for line in _MEMINFO.read_text().splitlines():
            if line.startswith("MemAvailable:"):
                return [1024.0 * int(line.split()[1])]
    with contextlib.suppress(OSError, ValueError, AttributeError):  # AttributeError: not on Windows
        return [float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE")]
    return []


def _of_container() -> list[float]:
    """What the limit of a control group leaves; pages of files that it may drop count as free."""
    with contextlib.suppress(OSError, ValueError, KeyError):
        limit = int((_GROUP / "memory.max").read_text())  # "max" without a limit: a ValueError
        used = int((_GROUP / "memory.current").read_text())
        lines = (_GROUP / "memory.stat").read_text().splitlines()
        table = {name: int(value) for name, value in (line.split() for line in lines)}
        return [float(limit - used + table["inactive_file"])]
    return []
