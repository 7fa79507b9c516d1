"""The beams about an opening, as solid or open, where its curved borders see them."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Bool, Float, drawn
from frontage.openings.boxes import Box
from frontage.openings.wall.crossings import CrossingBeams
from frontage.openings.wall.evidence import PER_CELL
from frontage.openings.wall.raster import averaged

_MOST = 6000  # beams of a head: more tell nothing new
_FULL = 0.75  # share of the points of a wall that masonry shows at least, over 3 x 3 cells
RISE_OF_POINTED = float(np.sqrt(3.0))  # of an equilateral pointed arch, in halves of its width


@dataclass(frozen=True, eq=False)
class Fan:
    """Beams (n,) about an opening.

    x, z     m, where each is told to be solid or open
    solid    whether it is solid
    missing  beams per m2 that did not come back from the opening
    """

    x: Float
    z: Float
    solid: Bool
    missing: float

    def part(self, keep: Bool) -> "Fan":
        """Returns those that `keep` (n,) names, thinned to what a head needs."""
        k = np.flatnonzero(keep)
        k = k[drawn(np.column_stack([np.abs(self.x[k]), self.z[k]]), _MOST)]  # the same when mirrored
        return Fan(self.x[k], self.z[k], self.solid[k], self.missing * len(k) / max(int(keep.sum()), 1))


def fan_of(
    near: CrossingBeams,
    place: Box,
    *,
    face: float,
    frame: float | None,
    density: float,
    head: tuple[str, float] = ("rectangle", 0.0),
) -> Fan:
    """Returns the beams about an opening as its curved borders see them.

    face     m, depth of the solid face beside the head
    frame    m, depth of the frame, None where it is unknown
    density  beams per m2 that a wall sends back there
    head     shape and rise m, as far as known

    As at straight borders (`locate`), a beam that slants outwards ends on the reveal and counts on a plane
    within the wall; the others count on the face.
    """
    x0, z0, x1, z1 = place
    seen = (outward(*head, place, near.place) * near.slope).sum(0) > 0
    begin = max(face, 0.0) + near.wall
    back = max(frame - face, 2.0 * near.wall) if frame is not None else 2.0 * near.wall
    x, z = near.shifted(np.where(seen, begin, face))
    free = near.depth >= min(face, 0.0) - near.wall  # points further in front hide the border
    # a hood mould can stand out further than the frame lies back: the wall behind it counts as solid, too
    solid = near.depth <= np.where(seen, begin, max(face + back / 2, near.wall))
    if not near.rays and density > 0.0:
        free &= solid | ~_on_masonry(x, z, solid, density)
    box = (x > x0) & (x < x1) & (z > z0) & (z < z1 - 0.3 * (z1 - z0))
    through = float((box & ~solid).sum()) / max(0.7 * (x1 - x0) * (z1 - z0), 1e-6)
    return Fan(x[free], z[free], solid[free], max(density - through, 0.0))


def _on_masonry(x: Float, z: Float, solid: Bool, density: float) -> Bool:
    """Returns which beams (n,) lie where about as many `solid` ones are as a wall has (`density` per m2).

    Ceilings that were seen aslant through an opening seem to lie behind the wall beside it.
    """
    cell = PER_CELL / np.sqrt(density)
    row, column = (((v - v.min(initial=np.inf)) / cell).astype(np.int64) + 1 for v in (z, x))
    shape = row.max(initial=0) + 2, column.max(initial=0) + 2
    held = np.zeros(shape)
    np.add.at(held, (row[solid], column[solid]), 1.0)
    full = averaged(np.minimum(held, PER_CELL**2)) > _FULL * PER_CELL**2
    return np.asarray(full[row, column], np.bool_)


def outward(shape: str, rise: float, place: Box, xz: Float) -> Float:
    """Returns the directions (2, n), not normalised, from the nearest border outwards at xz (2, n) m."""
    x0, z0, x1, z1 = place
    half, middle = (x1 - x0) / 2, (x0 + x1) / 2
    side = np.where(xz[0] < middle, -1.0, 1.0)
    if shape == "triangular":
        found = np.stack([side * rise, np.full(len(side), half)])
    elif shape == "pointed":
        found = xz - np.stack([middle - side * half, np.full(len(side), z1 - RISE_OF_POINTED * half)])
    else:
        radius = (half**2 + rise**2) / (2.0 * rise) if shape == "segmental" else half
        low = z1 - radius if shape in ("segmental", "round") else max((z0 + z1) / 2, z1 - radius)
        found = xz - np.array([middle, low])[:, None]
    if rise > 0.0:
        found = np.where(xz[1] < z1 - rise, np.stack([side, np.zeros(len(side))]), found)
    return found
