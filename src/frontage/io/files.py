"""Safe access to files: clear errors when reading, complete files or none when writing."""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from frontage.errors import CrsError, FileError, MissingExtra

_SHORT = 160  # characters of another program's message that are shown


def require_file(path: str | Path) -> Path:
    """The path of a file, checked to exist and to hold something.

    Raises FileError when it is missing, a folder, unreadable or empty.
    """
    p = Path(path)
    if not p.exists():
        raise FileError(p, "no such file", "check the path", code="I101")
    if p.is_dir():
        raise FileError(p, "is a folder, not a file", "name the file inside it", code="I101")
    if not os.access(p, os.R_OK):
        raise FileError(p, "may not be read", "check its permissions", code="I101")
    if p.stat().st_size == 0:
        raise FileError(p, "the file is empty", "export or copy it again", code="I102")
    return p


def text_of(path: Path, hint: str) -> str:
    """Return the text of a file that a user names. Raises FileError with `hint` if it cannot be read."""
    try:
        return path.read_text("utf-8")
    except FileNotFoundError:
        raise FileError(path, "no such file", hint) from None
    except (OSError, UnicodeDecodeError) as error:
        raise FileError(path, f"cannot be read as text ({error})", hint) from None


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
    except Exception as problem:
        raise FileError(
            path, f"not a readable {kind} file ({_brief(problem)})", advice, code="I103"
        ) from problem
    except BaseException as problem:
        if type(problem).__name__ != "PanicException":
            raise
        raise FileError(
            path, f"not a readable {kind} file (its data is corrupt)", advice, code="I103"
        ) from problem


def _brief(problem: BaseException) -> str:
    """The first line of an exception, short enough for one sentence."""
    text = " ".join(str(problem).split()) or type(problem).__name__
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
