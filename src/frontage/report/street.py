"""The elevation of the street: its facades in a row at one scale, as one walks along them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Float
from frontage.report.data import FacadeView, OrthoView
from frontage.report.figures import Tick, data_uri, nice
from frontage.report.plans import scale_bar

_WIDTH = 1050.0  # px of the longest row, unless that makes its facades too small
_LEAST_SCALE, _MOST_SCALE = 8.0, 40.0  # px per metre
_SAME_SIDE_COS = math.cos(math.radians(30.0))  # between the normals of facades of one side of a street
_OVERLAP = 0.2  # of a facade's width; one that overlaps another by more stands in another street
_SHARPNESS = 1.5  # pixels of a picture per pixel of the row
_JPEG_QUALITY = 82


@dataclass(frozen=True)
class RowFacade:
    """A facade in a row: place and size of its picture (or of its outline) in px, outlines of openings."""

    id: str
    label: str
    x: float
    y: float
    width: float
    height: float
    href: str
    outline: str
    openings: tuple[str, ...]


@dataclass(frozen=True)
class StreetRow:
    """A side of a street: size in px, facades from left to right, heights above datum, scale bar."""

    width: float
    height: float
    facades: tuple[RowFacade, ...]
    levels: tuple[Tick, ...]
    bar: float
    bar_label: str


@dataclass(frozen=True, eq=False)
class _Placed:
    """A facade with the place of its frame's origin along the row (m), and its extent there."""

    view: FacadeView
    at: float

    @property
    def span(self) -> tuple[float, float]:
        x0, _, x1, _ = self.view.facade.extent
        return self.at + x0, self.at + x1


def street_rows(views: Sequence[FacadeView]) -> tuple[StreetRow, ...]:
    """Return a row for every side of a street, the longest first, all at one scale.

    Facades face the same way up to 30 degrees. Each is shown in its own plane, so lengths are true, and
    stands where its middle lies along the row. A facade that overlaps others here begins another row.
    """
    rows: list[list[_Placed]] = []
    for view in sorted(views, key=lambda v: (-_width(v), v.facade.id)):
        for row in rows:
            placed = _along(row[0].view, view)
            if placed is not None and not any(_overlap(placed, other) for other in row):
                row.append(placed)
                break
        else:
            rows.append([_Placed(view, 0.0)])
    rows.sort(key=lambda row: -sum(_width(p.view) for p in row))
    longest = max((_ends(row)[1] - _ends(row)[0] for row in rows), default=1.0)
    scale = float(np.clip(_WIDTH / longest, _LEAST_SCALE, _MOST_SCALE))
    return tuple(_drawn(sorted(row, key=lambda p: p.span), scale) for row in rows)


def _ends(row: Sequence[_Placed]) -> tuple[float, float]:
    return min(p.span[0] for p in row), max(p.span[1] for p in row)


def _width(view: FacadeView) -> float:
    x0, _, x1, _ = view.facade.extent
    return float(x1 - x0)


def _along(first: FacadeView, view: FacadeView) -> _Placed | None:
    """Place a facade on the row of another one; None where it faces elsewhere."""
    frame, own = first.facade.frame, view.facade.frame
    if own.R[:, 1] @ frame.R[:, 1] < _SAME_SIDE_COS:
        return None
    x0, _, x1, _ = view.facade.extent
    middle = (x0 + x1) / 2
    at = float((own.t + middle * own.R[:, 0] - frame.t) @ frame.R[:, 0])
    return _Placed(view, at - middle)


def _overlap(one: _Placed, other: _Placed) -> bool:
    shared = min(one.span[1], other.span[1]) - max(one.span[0], other.span[0])
    return shared > _OVERLAP * min(_width(one.view), _width(other.view))


def _drawn(row: list[_Placed], scale: float) -> StreetRow:
    left, right = _ends(row)
    heights = [_height(p.view) + z for p in row for z in p.view.facade.extent[1::2]]
    low, high = min(heights), max(heights)
    bar, label = scale_bar(scale)
    step = max(nice((high - low) / 6), 1.0)
    marks = np.arange(math.ceil(low / step), math.floor(high / step) + 1) * step
    return StreetRow(
        (right - left) * scale,
        (high - low) * scale,
        tuple(_facade(p, np.array([left, high]), scale) for p in row),
        tuple(Tick((high - mark) * scale, f"{mark:g}") for mark in marks.tolist()),
        bar,
        label,
    )


def _height(view: FacadeView) -> float:
    """Height in m above datum of z = 0 of the facade frame."""
    facade = view.facade
    return float(facade.world.to_world(facade.frame.t)[2])


def _facade(placed: _Placed, corner: Float, scale: float) -> RowFacade:
    """Draw a facade; `corner` (2,) m: position along the row and height of the upper left corner."""
    view, shift = placed.view, np.array([placed.at, _height(placed.view)])

    def place(ring: Float) -> Float:
        return np.asarray((ring + shift - corner) * scale * (1.0, -1.0))

    x0, z0, x1, z1 = view.ortho.extent if view.ortho else view.facade.extent
    (left, bottom), (right, top) = place(np.array([[x0, z0], [x1, z1]])).tolist()
    size = right - left, bottom - top
    href = data_uri(_small(view.ortho, size[0]), "jpeg") if view.ortho else ""
    openings = view.elements.openings if view.elements else ()
    return RowFacade(
        view.facade.id, view.facade.building, left, top, *size, href,
        _points(place(view.facade.outline)), tuple(_points(place(o.ring)) for o in openings),
    )  # fmt: skip


def _points(ring: Float) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in ring)


def _small(ortho: OrthoView, width: float) -> bytes:
    """Reduce a picture to what a row shows of it."""
    image = cv2.imdecode(np.frombuffer(ortho.jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    scale = _SHARPNESS * width / image.shape[1]
    if scale < 1:
        image = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    return bytes(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[1])
