"""Pictures of what openings were found from: beams on the wall, or the paper's edge points and cells."""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float, Int
from frontage.openings.paper.availability import AvailabilityMap
from frontage.openings.paper.cells import FACADE, OUTSIDE, UNCERTAIN, WINDOW
from frontage.openings.paper.find import Decomposition
from frontage.openings.wall.beams import Beams
from frontage.openings.wall.evidence import Evidence

Extent = tuple[float, float, float, float]

_LEAST = 900  # px of the longer side that a picture has about
_STEP = 2.0  # nats between the three strengths of a colour
_TOLD = 0.5  # nats: cells that say less are unknown
# RGBA of a beam picture: outside, unknown, blocked; wall, no return, through from weak to strong
_BEAMS = np.array(
    [(0, 0, 0, 0), (222, 220, 217, 255), (158, 158, 162, 255),
     (190, 208, 226, 255), (122, 162, 200, 255), (58, 110, 160, 255),
     (250, 238, 180, 255), (244, 217, 105, 255), (230, 188, 35, 255),
     (248, 196, 155, 255), (236, 140, 76, 255), (200, 82, 22, 255)], np.uint8
)  # fmt: skip
_WALL, _MISSING, _THROUGH = 2, 5, 8  # the colour before the weakest of each
# RGBA of the paper's classes, by their numbers, as in its figure 7
_CLASSES = np.zeros((4, 4), np.uint8)
_CLASSES[[FACADE, WINDOW, UNCERTAIN, OUTSIDE]] = [
    (176, 176, 174, 255), (255, 255, 255, 255), (24, 24, 24, 255), (0, 0, 0, 0)
]  # fmt: skip
_PLANE = (96, 96, 96, 255)
_UPRIGHT, _LEVEL = (196, 42, 32, 255), (24, 92, 190, 255)  # edge points of sides, of sills and lintels


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture of a facade: file stem, caption, (h, w, 4) uint8 BGRA, its edges x0, z0, x1, z1 in m."""

    name: str
    caption: str
    image: Array
    extent: Extent

    @property
    def png(self) -> bytes:
        """The image as a PNG file."""
        return png_bytes(self.image)


def png_bytes(image: Array) -> bytes:
    """A picture as a PNG file; OpenCV's own choice makes flat areas eight times as large."""
    small = [cv2.IMWRITE_PNG_COMPRESSION, 6, cv2.IMWRITE_PNG_STRATEGY, cv2.IMWRITE_PNG_STRATEGY_DEFAULT]
    return bytes(cv2.imencode(".png", image, small)[1])


def beam_picture(beams: Beams, evidence: Evidence) -> Picture:
    """What the beams say of every cell of the wall, the surer the stronger the colour."""
    raster, llr = evidence.raster, evidence.llr
    level = np.clip(np.ceil(np.abs(llr) / _STEP), 1, 3).astype(np.int64)
    stopped = raster.count(*beams.blocked.T) > 0
    kind = np.where(evidence.open > 0, _THROUGH, _MISSING) + level
    kind = np.where(llr < 0, _WALL + level, kind)
    kind = np.where(np.abs(llr) < _TOLD, np.where(stopped, 2, 1), kind)
    kind = np.where(evidence.inside, kind, 0)
    (x0, z0), (h, w) = raster.corner, raster.shape
    return Picture(
        "evidence",
        "Beams: blue ended on the wall, orange went through it, yellow were due and did not return (the "
        "stronger the colour, the surer), dark grey were stopped before it; light grey tells nothing",
        _enlarged(_bgra(_BEAMS[kind[::-1]])),
        (x0, z0, x0 + w * raster.cell, z0 + h * raster.cell),
    )


def cell_pictures(d: Decomposition) -> tuple[Picture, Picture, Picture]:
    """The published method's steps, as in its figures 6 and 7."""
    edges = (
        "Edge points (red of left and right borders, blue of lower and upper ones) and the lines through "
        "them, on the map of the grid elements that hold points"
    )
    before = "Cells by their share of points: facade grey, window white, uncertain black"
    after = "Cells after the rules of neighbourhood: facade grey, window white"
    return (
        Picture("evidence", edges, _edge_image(d), _map_extent(d.seen)),
        _class_picture("cells_before", before, d.cells.first, d),
        _class_picture("cells", after, d.cells.final, d),
    )


def _map_extent(seen: AvailabilityMap) -> Extent:
    (x0, z0), (h, w) = seen.corner, seen.available.shape
    return x0, z0, x0 + w * seen.cell, z0 + h * seen.cell


def _edge_image(d: Decomposition) -> Array:
    seen = d.seen
    kind = np.where(seen.inside, np.where(seen.available, FACADE, WINDOW), OUTSIDE)
    image = _enlarged(_bgra(_CLASSES[kind[::-1]]))
    scale = image.shape[0] / seen.available.shape[0] / seen.cell
    x0, _, _, z1 = _map_extent(seen)
    for border in d.borders:
        ends = [(border.position, z) if border.upright else (z, border.position) for z in border.extent]
        (xa, ya), (xb, yb) = ((np.array(ends) - (x0, z1)) * (scale, -scale)).round().astype(int).tolist()
        cv2.line(image, (xa, ya), (xb, yb), (0, 0, 0, 255), 1)
    for rows, colour in (((0, 1), _UPRIGHT), ((2, 3), _LEVEL)):
        edge = d.xz[d.edges[list(rows)].any(0)]
        c, r = ((edge - (x0, z1)) * (scale, -scale)).astype(np.int64).T
        inside = (c >= 0) & (c < image.shape[1]) & (r >= 0) & (r < image.shape[0])
        image[r[inside], c[inside]] = _bgra(np.array(colour, np.uint8))
    return image


def _class_picture(name: str, caption: str, classes: Array, d: Decomposition) -> Picture:
    x0, z0, x1, z1 = (float(v) for v in (d.cells.xs[0], d.cells.zs[0], d.cells.xs[-1], d.cells.zs[-1]))
    scale = _LEAST / max(x1 - x0, z1 - z0)
    w, h = max(round((x1 - x0) * scale), 1), max(round((z1 - z0) * scale), 1)
    column = _cell_of((np.arange(w) + 0.5) / scale, d.cells.xs - x0)
    row = _cell_of((h - 0.5 - np.arange(h)) / scale, d.cells.zs - z0)
    image = _bgra(_CLASSES[classes[row][:, column]])
    solid = image[..., 3] > 0
    edge = np.zeros((h, w), np.bool_)
    edge[:, 1:] |= np.diff(column) != 0
    edge[1:] |= (np.diff(row) != 0)[:, None]
    image[edge & solid] = _PLANE
    return Picture(name, caption, image, (x0, z0, x1, z1))


def _cell_of(at: Array, planes: Float) -> Int:
    return np.clip(np.searchsorted(planes, at, side="right") - 1, 0, len(planes) - 2).astype(np.int64)


def _enlarged(image: Array) -> Array:
    """Every cell as a square of whole pixels."""
    times = max(1, round(_LEAST / max(image.shape[:2])))
    return np.ascontiguousarray(image.repeat(times, axis=0).repeat(times, axis=1))


def _bgra(rgba: Array) -> Array:
    return np.ascontiguousarray(rgba[..., [2, 1, 0, 3]])
