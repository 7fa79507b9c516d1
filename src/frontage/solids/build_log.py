"""What happened while a solid was built: notes for the user, and the reliefs that were left out."""

from dataclasses import dataclass, field

from frontage.model import Failed
from frontage.solids.relief import Relief, names_of


@dataclass
class BuildLog:
    """Collects notes on what was changed, and a `Failed` for everything that was left out."""

    notes: list[str] = field(default_factory=list)
    failed: list[Failed] = field(default_factory=list)

    def note(self, text: str) -> None:
        """Adds a note."""
        self.notes.append(text)

    def refuse(self, code: str, relief: Relief, reason: str, hint: str = "") -> None:
        """Records that a relief, with those on its surface, is not in the solid, and why."""
        _, *others = names_of(relief)
        more = f"; left out with it: {', '.join(others)}" if others else ""
        self.failed.append(Failed(code, f"{relief.id}: {reason}{more}", hint))
