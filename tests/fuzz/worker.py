"""The process that reads: one case per line on standard input, one result per line on standard output.

Its memory is limited to what it has after its imports and `MEMORY_MB` more, its processor time per case to
`SECONDS`. It dies of a crash in native code; the harness then starts another one.
"""

import json
import os
import resource
import sys
import time
import warnings
from contextlib import suppress
from pathlib import Path
from typing import Any

MEMORY_MB = 1024
SECONDS = 10
_MB = 1 << 20
_NEEDED = (
    "pye57", "laspy", "lazrs", "lxml.etree", "shapely", "pyproj", "tifffile", "PIL.Image", "sqlite3",
    "frontage.io.scans.las", "frontage.io.scans.e57", "frontage.io.scans.ply", "frontage.io.scans.xyz",
    "frontage.io.scans.ptx", "frontage.io.scans.pcd", "frontage.io.citymodels.citygml.read",
    "frontage.io.citymodels.geopackage",
    "frontage.io.citymodels.cityjson.read", "frontage.io.citymodels.geojson",
    "frontage.io.shapes.gmlfile", "frontage.io.shapes.jsonfile",
)  # fmt: skip


def _status(name: str) -> int:
    """A memory figure of this process in MB: VmSize, VmRSS, VmHWM."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next((int(line.split()[1]) // 1024 for line in lines if line.startswith(name + ":")), 0)


def _start_measuring() -> None:
    """Set the peak of the memory in use back to what is in use now."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def _allow_seconds(seconds: int) -> None:
    used = resource.getrusage(resource.RUSAGE_SELF)
    soft = int(used.ru_utime + used.ru_stime) + seconds + 1
    resource.setrlimit(resource.RLIMIT_CPU, (soft, resource.RLIM_INFINITY))


def _allow_memory() -> None:
    limit = (_status("VmSize") + MEMORY_MB) * _MB
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def read(reader: str, path: Path) -> dict[str, Any]:
    """Read one file; returns the outcome ("read", "refused", "error", "nonsense") and its message."""
    from frontage.errors import FrontageError
    from fuzz.readers import READERS, NonsenseError

    try:
        READERS[reader](path)
    except FrontageError as error:
        return {"outcome": "refused", "message": str(error), "code": error.code}
    except NonsenseError as error:
        return {"outcome": "nonsense", "message": str(error)}
    except BaseException as error:
        return {"outcome": "error", "message": _traced(error)}
    return {"outcome": "read", "message": ""}


def _traced(error: BaseException) -> str:
    """The exception with the last line of the library that it passed."""
    where, trace = "", error.__traceback__
    while trace is not None:
        file = trace.tb_frame.f_code.co_filename
        if f"{os.sep}frontage{os.sep}" in file:
            where = f"{file.rsplit(f'{os.sep}frontage{os.sep}', 1)[1]}:{trace.tb_lineno}"
        trace = trace.tb_next
    return f"{type(error).__name__}: {' '.join(str(error).split())[:300]} ({where})"


def main() -> None:
    """Answer until standard input ends."""
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # what libraries print does not mix with the answers
    import cv2

    import fuzz.readers  # noqa: F401  (all imports happen before the memory is limited)

    cv2.setNumThreads(1)
    warnings.simplefilter("ignore")
    _warm_up()
    _allow_memory()
    for line in sys.stdin:
        case = json.loads(line)
        _start_measuring()
        before, start = _status("VmRSS"), time.perf_counter()
        _allow_seconds(SECONDS)
        result = read(case["reader"], Path(case["path"]))
        result |= {"seconds": time.perf_counter() - start, "mb": max(0, _status("VmHWM") - before)}
        answers.write(json.dumps(result) + "\n")
        answers.flush()


def _warm_up() -> None:
    """Import what readers import when they are first used, before the memory is limited."""
    from importlib import import_module

    for name in _NEEDED:
        import_module(name)


if __name__ == "__main__":
    main()
