"""A street front in plan."""

from dataclasses import dataclass, replace

import numpy as np

from frontage.geometry.arrays import Float, Int


@dataclass(frozen=True, eq=False)
class StreetFront:
    """A street front in plan.

    origin   (2,) m local; the front's line is ``origin + s * along`` for s from `lo` to `hi` m
    along    (2,) unit; `out` (2,) unit, across it
    members  (k,) wall columns of the front; `block` they belong to

    Where `faces_street`, `out` points to the street and `along` to the right as seen from there.
    """

    origin: Float
    along: Float
    out: Float
    lo: float
    hi: float
    members: Int
    block: int
    faces_street: bool = False

    @property
    def length(self) -> float:
        """Length of the front, m."""
        return self.hi - self.lo

    def coordinates(self, xy: Float) -> tuple[Float, Float]:
        """Returns s along the front and distance d in front of it, (n,) m each, of points (n, 2) m local."""
        q = xy - self.origin
        return q @ self.along, q @ self.out

    def facing(self, side: float) -> "StreetFront":
        """Returns the front turned so that `out` points to its street.

        The street lies on the side of `out` (+1) or on the opposite side (-1). If the side is
        unknown (0), the front stays as it is.
        """
        if side == 0:
            return self
        out = self.out * side
        along = np.array([-out[1], out[0]])
        flip = float(along @ self.along)
        lo, hi = sorted((flip * self.lo, flip * self.hi))
        return replace(self, along=along, out=out, lo=lo, hi=hi, faces_street=True)
