"""What the room returns: the openings with their frames and bars, and what these were chosen from."""

from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Array, freeze
from frontage.model import Elements, Glazing


@dataclass(frozen=True, eq=False)
class WindowEvidence:
    """What the layout of one window was chosen from, as pictures for people.

    opening   the window's id
    extent    (x0, z0, x1, z1) m of all pictures, in the facade frame
    views     names of photos with (h, w, 3) uint8 RGB, rectified onto the plane of the frame
    evidence  (h, w) uint8, how strongly each pixel speaks for a bar; None where nothing could be compared
    glazing   the layout chosen
    """

    opening: str
    extent: tuple[float, float, float, float]
    views: tuple[tuple[str, Array], ...] = field(repr=False)
    evidence: Array | None = field(repr=False)
    glazing: Glazing

    def __post_init__(self) -> None:
        if self.evidence is not None:
            freeze(self, evidence=((None, None), np.uint8))


@dataclass(frozen=True, eq=False)
class FoundBars:
    """The elements of a facade with their glazing, the evidence of every window, and notes for the user."""

    elements: Elements
    windows: tuple[WindowEvidence, ...]
    notes: tuple[str, ...] = ()
