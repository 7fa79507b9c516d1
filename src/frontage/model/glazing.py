"""What divides a glazed opening: its frame, and the bars in the plane of the frame."""

from dataclasses import dataclass
from math import inf

from frontage.geometry.arrays import Float
from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate, Provenance

AXES = ("vertical", "horizontal")
"""The directions of window bars: mullions, transoms."""

FRAME_THICKNESS_M = 0.065
"""Usual thickness of a window frame, which neither photos nor scans show."""


@dataclass(frozen=True)
class Bar:
    """A mullion (`axis` "vertical", position x) or a transom ("horizontal", position z); all in m.

    position  of the centre line, in the facade frame
    extent    both ends of the centre line, along the other axis
    sigma     standard error of the position; `sigma_width` that of the width
    """

    axis: str
    position: float
    extent: tuple[float, float]
    width: float
    sigma: float
    sigma_width: float = inf
    provenance: Provenance = Provenance.MEASURED

    def __post_init__(self) -> None:
        if self.axis not in AXES:
            raise ValueError(f"a bar is vertical or horizontal, not {self.axis!r}")

    @property
    def ring(self) -> Float:
        """Its outline (4, 2) m (x, z), counter-clockwise as seen from the street."""
        (low, high), half = self.extent, self.width / 2
        across = (self.position - half, self.position + half)
        if self.axis == "vertical":
            return rectangle(across[0], low, across[1], high)
        return rectangle(low, across[0], high, across[1])


@dataclass(frozen=True)
class Glazing:
    """The frame and the bars of one opening, as far as photos or the scan resolve them.

    resolved     whether the layout was decided; without bars, it then is a single pane
    bars         from left to right, then from the bottom upwards; empty where not resolved
    frame_width  m, how far the frame reaches into the opening from its borders; None = not measured
    depth        m behind the wall, positive = recess, of the plane in which the front faces of the bars lie;
                 without bars, of the sashes, casements or frame that hold the glass; None = not measured.
                 Of two sashes that slide, the plane of the front one. The front of a fixed frame may lie
                 some centimetres nearer: `Opening.depth`
    confidence   probability that the layout is the true one, 0..1
    sources      names of the photos that decided it, "scan" where scan points did
    note         why it is not resolved, or what to be careful about; "" = nothing
    """

    resolved: bool
    bars: tuple[Bar, ...] = ()
    frame_width: Estimate[float] | None = None
    depth: Estimate[float] | None = None
    confidence: float = 0.0
    sources: tuple[str, ...] = ()
    note: str = ""

    @property
    def counts(self) -> tuple[int, int]:
        """The numbers of upright bars and of transoms."""
        upright = sum(bar.axis == "vertical" for bar in self.bars)
        return upright, len(self.bars) - upright
