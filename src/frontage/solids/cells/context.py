"""The context of a build: its options and its log."""

from dataclasses import dataclass

from frontage.solids.brep import GRID_PER_M
from frontage.solids.build_log import BuildLog
from frontage.solids.options import BuildOptions


@dataclass(frozen=True, eq=False)
class BuildContext:
    """The options of a build, and the log of what was changed or left out."""

    options: BuildOptions
    log: BuildLog

    @property
    def gap(self) -> float:
        """The narrowest strip or step in 0.1 mm."""
        return self.options.gap * GRID_PER_M
