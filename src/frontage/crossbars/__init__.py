"""Window bars: mullions and transoms from oriented photos and the scan (paper B, section 3.3)."""

from frontage.crossbars.found import FoundBars, WindowEvidence
from frontage.crossbars.options import CrossbarOptions
from frontage.crossbars.window import Window, WindowView

__all__ = ["CrossbarOptions", "FoundBars", "Window", "WindowEvidence", "WindowView"]
