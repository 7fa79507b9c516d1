"""What happened while a solid was built: notes, and the reliefs that were left out."""

from dataclasses import dataclass, field

from frontage.model import Failed
from frontage.solids.relief import Relief


@dataclass
class Log:
    """What happened on the way."""

    notes: list[str] = field(default_factory=list)
    failed: list[Failed] = field(default_factory=list)

    def refuse(self, code: str, relief: Relief, why: str, hint: str = "") -> None:
        """Leave a relief out."""
        self.failed.append(Failed(code, f"{relief.id}: {why}", hint))
