"""The exceptions that Frontage raises on purpose, and the numbered codes they carry.

::

    FrontageError            every error that Frontage raises on purpose
    ├── InputError           a file or value given by the user (I...)
    │   ├── FileError        missing, empty, truncated or corrupt files (I1xx)
    │   │   └── UnsupportedFormat
    │   ├── CrsError         coordinate reference systems (I2xx)
    │   └── OptionError      options and project files (I3xx)
    ├── MissingExtra         an optional dependency that is not installed (X...)
    └── WorkspaceError       the run folder (W...)

Failures of single items, which must not stop a run, are values rather than exceptions: see
`frontage.model.Failed`. `CODES` explains every code that an exception or a `Failed` can carry.
"""

from frontage.errors.codes import CODES, ErrorCode

__all__ = [
    "CODES",
    "CrsError",
    "ErrorCode",
    "FileError",
    "FrontageError",
    "InputError",
    "MissingExtra",
    "OptionError",
    "UnsupportedFormat",
    "WorkspaceError",
    "printable",
]


_LONGEST = 600  # characters of a message


class FrontageError(Exception):
    """An error with a numbered code and one clear sentence that says what is wrong and what to do."""

    code = "E000"

    def __init__(self, message: str, *, code: str | None = None) -> None:
        super().__init__(_one_line(message))
        if code is not None:
            self.code = code


def printable(text: str) -> str:
    """Returns text without control characters, which file names may hold and a terminal would obey."""
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


def _one_line(message: str) -> str:
    """Returns a message without line breaks and control characters, which damaged files may bring into it."""
    line = printable(" ".join(message.split()))
    return line if len(line) <= _LONGEST else f"{line[: _LONGEST // 2]} ... {line[-_LONGEST // 3 :]}"


class InputError(FrontageError, ValueError):
    """Something that the user gave cannot be used."""

    code = "I000"


class FileError(InputError):
    """A file is missing, empty, truncated or corrupt."""

    code = "I100"

    def __init__(self, path: object, problem: str, advice: str = "", *, code: str | None = None) -> None:
        """Builds the message ``path: problem; advice``."""
        super().__init__(f"{path}: {problem}" + (f"; {advice}" if advice else ""), code=code)


class UnsupportedFormat(FileError):
    """A file has a format, or a version of a format, that Frontage does not read."""

    code = "I114"


class CrsError(InputError):
    """A coordinate reference system is missing, unknown, inconsistent or cannot be transformed exactly."""

    code = "I200"


class OptionError(InputError):
    """An option or an entry of the project file is unknown or out of range."""

    code = "I300"


class WorkspaceError(FrontageError):
    """The run folder cannot be used."""

    code = "W100"


class MissingExtra(FrontageError, ImportError):
    """An optional dependency is needed but not installed."""

    code = "X100"

    def __init__(self, what: str, extra: str) -> None:
        """Names the extra that `what` needs and the command that installs it."""
        super().__init__(
            f"{what} needs an optional dependency; install it with: pip install 'frontage[{extra}]'"
        )
