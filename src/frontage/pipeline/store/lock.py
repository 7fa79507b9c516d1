"""One run at a time: a lock file in the run folder that names the process which holds it."""

import json
import os
import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from frontage.errors import WorkspaceError

NAME = ".lock"
_WRITING_S = 1.0  # longer than it takes to write a lock
_BOOT = Path("/proc/sys/kernel/random/boot_id")


@contextmanager
def locked(out: Path) -> Iterator[None]:
    """Hold the lock of a run folder in the block.

    A lock whose process has ended, on this host, is stale and taken over. Raises WorkspaceError if another
    process holds it, or one on another host might.
    """
    path = out / NAME
    mine = _owner()
    while not _taken(path, mine):
        holder = _read(path)
        if holder is None:
            _clear_torn(path)
        elif _is_alive(holder):
            raise WorkspaceError(_refusal(out, path, holder), code="W110")
        else:
            _drop(path, holder)
    try:
        yield
    finally:
        _drop(path, mine)


def _owner() -> dict[str, object]:
    """What tells a process from all others: host, boot, number, and the time it started."""
    pid = os.getpid()
    return {"host": socket.gethostname(), "boot": _boot(), "pid": pid, "started": _started(pid)}


def _taken(path: Path, mine: dict[str, object]) -> bool:
    """Create the lock unless there is one."""
    try:
        handle = os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o644)
    except FileExistsError:
        return False
    except OSError as error:
        raise WorkspaceError(
            f"{path.parent} cannot be written ({error.strerror}); give another run folder"
        ) from None
    with os.fdopen(handle, "w") as file:
        json.dump(mine, file)
    return True


def _clear_torn(path: Path) -> None:
    """Remove a lock that was cut off while it was written; one that is just being written is waited for."""
    with suppress(FileNotFoundError):
        if time.time() - path.stat().st_mtime > _WRITING_S:
            path.unlink()
        else:
            time.sleep(_WRITING_S / 20)


def _read(path: Path) -> dict[str, object] | None:
    try:
        holder = json.loads(path.read_text())
    except (OSError, ValueError):
        return None
    return holder if isinstance(holder, dict) and isinstance(holder.get("pid"), int) else None


def _drop(path: Path, owner: dict[str, object]) -> None:
    """Remove the lock if it is this owner's."""
    if _read(path) == owner:
        with suppress(OSError):
            path.unlink()


def _is_alive(holder: dict[str, object]) -> bool:
    """Tell whether the process that wrote a lock may still run; on other hosts that cannot be known."""
    if holder.get("host") != socket.gethostname():
        return True
    if holder.get("boot") != _boot():
        return False
    pid = holder["pid"]
    assert isinstance(pid, int)
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True  # it runs under another user
    started = _started(pid)  # the number may have been given to a new process
    return started is None or holder.get("started") in (None, started)


def _refusal(out: Path, path: Path, holder: dict[str, object]) -> str:
    where = f"process {holder['pid']} on {holder.get('host')}"
    advice = "wait until it ends, or stop it"
    if holder.get("host") != socket.gethostname():
        advice = f"wait until it ends; if it has ended, remove {path}"
    return f"{out} is in use by another run ({where}); {advice}"


def _boot() -> str | None:
    try:
        return _BOOT.read_text().strip()
    except OSError:
        return None


def _started(pid: int) -> str | None:
    """When a process started, in clock ticks since boot; None where the system does not tell."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[19]
    except (OSError, IndexError):
        return None
