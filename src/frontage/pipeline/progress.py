"""Who is told about the progress of long work."""

from typing import Protocol


class Progress(Protocol):
    """Is told what happens; every method may be called often and must be cheap."""

    def begin(self, stage: str, total: int) -> None:
        """A stage starts with `total` items (0 = unknown)."""

    def advance(self, stage: str) -> None:
        """One item is finished."""

    def end(self, stage: str, seconds: float, kept: bool, items: int) -> None:
        """A stage is finished and made `items` things; `kept` = nothing had to be done."""


class Silent:
    """Tells nobody."""

    def begin(self, stage: str, total: int) -> None:
        """See `Progress.begin`."""

    def advance(self, stage: str) -> None:
        """See `Progress.advance`."""

    def end(self, stage: str, seconds: float, kept: bool, items: int) -> None:
        """See `Progress.end`."""
