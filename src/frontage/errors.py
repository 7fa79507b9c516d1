"""The exception tree and the numbered codes.

::

    FrontageError            every error that Frontage raises on purpose
    ├── InputError           a file or value that the user gave (I...)
    │   ├── FileError        missing, empty, truncated, corrupt (I1xx)
    │   ├── CrsError         coordinate reference systems (I2xx)
    │   └── OptionError      options and project files (I3xx)
    ├── MissingExtra         an optional dependency is not installed (X...)
    └── WorkspaceError       the run folder (W...)

Per-item failures that must not stop a run are values, not exceptions: see `frontage.model.Failed`.
"""


class FrontageError(Exception):
    """An error with a numbered code and one clear sentence: what is wrong and what to do."""

    code = "E000"

    def __init__(self, message: str, *, code: str | None = None) -> None:
        super().__init__(message)
        if code is not None:
            self.code = code


class InputError(FrontageError, ValueError):
    """Something the user gave cannot be used."""

    code = "I000"


class FileError(InputError):
    """A file is missing, empty, truncated or corrupt."""

    code = "I100"

    def __init__(self, path: object, problem: str, advice: str = "", *, code: str | None = None) -> None:
        """Build the sentence ``path: problem; advice``."""
        super().__init__(f"{path}: {problem}" + (f"; {advice}" if advice else ""), code=code)


class UnsupportedFormat(FileError):
    """A file is of a format, or a version of one, that is not read here."""

    code = "I114"


class CrsError(InputError):
    """A coordinate reference system is missing, wrong, mixed or cannot be transformed exactly."""

    code = "I200"


class OptionError(InputError):
    """An option or a project file entry is unknown or out of range."""

    code = "I300"


class WorkspaceError(FrontageError):
    """The run folder cannot be used."""

    code = "W100"


class MissingExtra(FrontageError, ImportError):
    """An optional dependency is needed and not installed."""

    code = "X100"

    def __init__(self, what: str, extra: str) -> None:
        """Say which extra to install for `what`."""
        super().__init__(
            f"{what} needs an optional dependency; install it with: pip install 'frontage[{extra}]'"
        )
