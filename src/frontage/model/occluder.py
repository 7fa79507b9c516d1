"""What stood before a facade when it was scanned."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, freeze

OCCLUDER_KINDS = ("tree", "car", "lamp", "person", "sign", "wire", "other")


@dataclass(frozen=True, eq=False)
class Occluder:
    """A thing that stands free before a facade, as the scan shows it.

    id           such as "B07/F1/X3"
    chances      (7,) probabilities of `OCCLUDER_KINDS`, their sum is 1
    centre       (3,) m in the facade frame: middle of its box
    size         (3,) m: length and width in plan, height; length >= width
    heading      rad, of the length in plan, from the facade's x towards its y, in (-pi/2, pi/2]
    sigma        m, standard error of a side of the box: what the spacing of the scan leaves open
    points       number of points of the scan
    """

    id: str
    chances: Float
    centre: Float
    size: Float
    heading: float
    sigma: float
    points: int

    def __post_init__(self) -> None:
        freeze(self, chances=((len(OCCLUDER_KINDS),), np.float64))
        freeze(self, centre=((3,), np.float64), size=((3,), np.float64))

    @property
    def kind(self) -> str:
        """The most likely of `OCCLUDER_KINDS`."""
        return OCCLUDER_KINDS[int(np.argmax(self.chances))]

    @property
    def confidence(self) -> float:
        """The probability of that kind."""
        return float(self.chances.max())

    @property
    def corners(self) -> Float:
        """The corners (8, 3) m of the box in the facade frame, the four lower ones first."""
        cos, sin = np.cos(self.heading), np.sin(self.heading)
        signs = np.array([(a, b, c) for c in (-1, 1) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
        along, across, up = (0.5 * signs * self.size).T
        plan = np.column_stack([along * cos - across * sin, along * sin + across * cos, up])
        return np.asarray(self.centre + plan)
