"""Safe access to files: clear errors when reading, complete files or none when writing."""

import contextlib
import os
import re
import stat
from collections.abc import Iterator
from pathlib import Path

from frontage.errors import CrsError, FileError, MissingExtra

MALFORMED = (ValueError, KeyError, TypeError, IndexError, OverflowError, AttributeError, RecursionError)
"""What taking a damaged record apart may raise."""

_SHORT = 160  # characters of another program's message that are shown


def require_file(path: str | Path) -> Path:
    """The path of a file, checked to be a regular file that can be read and holds something.

    Reading a pipe, a socket or a device could wait for ever, so these are refused.

    Raises FileError when it is missing, not a regular file, unreadable or empty.
    """
    p = Path(path)
    try:
        found = os.stat(p)
    except (OSError, ValueError) as problem:
        raise _not_found(p, problem) from None
    if stat.S_ISDIR(found.st_mode):
        raise FileError(p, "is a folder, not a file", "name the file inside it", code="I101")
    if not stat.S_ISREG(found.st_mode):
        raise FileError(
            p, "is a pipe, socket or device, not a file", "copy its contents to a file first", code="I101"
        )
    if not os.access(p, os.R_OK):
        raise FileError(p, "may not be read", "check its permissions", code="I101")
    if found.st_size == 0:
        raise FileError(p, "the file is empty", "export or copy it again", code="I102")
    return p


def _not_found(path: Path, problem: OSError | ValueError) -> FileError:
    """The error for a path that the system does not accept; a ValueError means a null character."""
    if isinstance(problem, ValueError):
        shown = str(path).replace("\0", "\\0")
        return FileError(shown, "no path can hold a null character", "correct the path", code="I101")
    if isinstance(problem, FileNotFoundError | NotADirectoryError):
        return FileError(path, "no such file", "check the path", code="I101")
    if isinstance(problem, PermissionError):
        return FileError(path, "may not be read", "check its permissions", code="I101")
    why = problem.strerror or "it cannot be opened"
    shown = str(path) if len(str(path)) < 2 * _SHORT else str(path)[: 2 * _SHORT] + "..."
    return FileError(shown, f"not a path of a file ({why})", "check the path", code="I101")


def require_length(path: Path, what: str, need: int, has: int) -> None:
    """Raise FileError when `what`, as a header states it, needs more bytes than the file has.

    Readers call this before they believe a count: otherwise a damaged header makes them wait or run out of
    memory.
    """
    if not 0 <= need <= has:
        raise FileError(
            path,
            f"truncated or damaged: its header states {what}, which do not fit into the {has} bytes there",
            "export or copy it again",
            code="I103",
        )


def text_of(path: Path, hint: str) -> str:
    """Return the text of a regular file that a user names. Raises FileError with `hint` if there is none."""
    try:
        regular = stat.S_ISREG(os.stat(path).st_mode)
    except FileNotFoundError:
        raise FileError(path, "no such file", hint) from None
    except (OSError, ValueError) as problem:
        raise _not_found(path, problem) from None
    if not regular:
        raise FileError(path, "is not a regular file", hint, code="I101")
    try:
        return path.read_text("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read as text ({error})", hint) from None


def out_of_memory(path: str | Path, problem: MemoryError) -> FileError:
    """The error for contents that do not fit into memory: the file's size, what was asked for, the remedy."""
    size = _amount(os.stat(path).st_size)
    asked = re.search(r"Unable to allocate ([\d.]+ \w+)", str(problem))
    more = f"; {asked[1]} more were asked for" if asked else ""
    return FileError(
        path,
        f"does not fit into memory (the file has {size}{more})",
        "split it, thin it, or use a computer with more memory",
        code="I115",
    )


def _amount(size: int) -> str:
    """Bytes as text for a message."""
    return f"{size / 1e9:.1f} GB" if size >= 1e8 else f"{size / 1e6:.1f} MB"


@contextlib.contextmanager
def reading(path: str | Path, kind: str, advice: str = "export or copy it again") -> Iterator[None]:
    """Turn whatever a parser raises inside the block into one FileError that names the file and its `kind`.

    FileError, CrsError and MissingExtra pass unchanged. Readers written in Rust panic with exceptions outside
    `Exception`; those are caught by name.
    """
    try:
        yield
    except (FileError, CrsError, MissingExtra):
        raise
    except MemoryError as problem:
        raise out_of_memory(path, problem) from problem
    except Exception as problem:
        if "Insufficient memory" in str(problem):  # OpenCV has an error of its own
            raise out_of_memory(path, MemoryError()) from problem
        raise FileError(
            path, f"not a readable {kind} file ({brief(problem)})", advice, code="I103"
        ) from problem
    except BaseException as problem:
        if type(problem).__name__ != "PanicException":
            raise
        raise FileError(
            path, f"not a readable {kind} file (its data is corrupt)", advice, code="I103"
        ) from problem


def brief(problem: BaseException) -> str:
    """The first line of an exception, short enough for one sentence."""
    if isinstance(problem, RecursionError):
        return "it is nested too deeply"
    words = " ".join(str(problem).split()) or type(problem).__name__
    text = "".join(c if c.isprintable() else "?" for c in words)
    return text if len(text) <= _SHORT else text[:_SHORT] + "..."


@contextlib.contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """A temporary path beside `path` that replaces it when the block succeeds and is removed when it fails.

    Raises FileError when the folder or the file cannot be written.
    """
    p = Path(path)
    temporary = p.with_name(f".{p.name}.{os.getpid()}.part")
    try:
        p.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        os.replace(temporary, p)
    except OSError as problem:
        raise FileError(
            p,
            f"cannot be written ({problem.strerror or problem})",
            "check the folder and the free space",
            code="I104",
        ) from problem
    finally:
        temporary.unlink(missing_ok=True) if p.parent.is_dir() else None
