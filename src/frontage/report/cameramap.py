"""The cameras in plan: where they stand, what they look at, and the magnified errors of their places."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from frontage.geometry.arrays import Float
from frontage.geometry.camera import unproject
from frontage.report.data import ReportData
from frontage.report.figures import facade_ends, plan_image, to_figure
from frontage.report.plans import Ellipse, error_ellipse, half_axes, magnification, scale_bar

_WIDTH, _HEIGHT, _FINEST = 860.0, 620.0, 40.0  # px, px, px per metre
_AROUND = 25.0  # m about the cameras in which points of the street are shown
_ASTRAY = 40.0  # m between approximate and adjusted position beyond which the former lies off the map
_EDGE = np.array([70.0, 24.0])  # px left free on every side: room for labels
_LONE = 2.0  # m about a single camera
_SHORT, _LONG = 9.0, 20.0  # px, length of the sides of a field of view; between crowded cameras it is short
_WIDEST = np.radians(75.0)  # half a field of view that can be drawn as a triangle
_TYPICAL, _LONGEST = (
    0.8,
    3.0,
)  # of these sides: the median and the longest half-axis of ellipses come up to it
_LETTER, _LINE = 6.6, 13.0  # px, size of a letter in a label


@dataclass(frozen=True)
class CameraMark:
    """A camera in the map, px: its place, field of view as a polygon, ellipse, approximate place, label."""

    name: str
    verdict: str
    x: float
    y: float
    view: str
    error: Ellipse | None
    given: tuple[float, float] | None
    label: str
    label_x: float
    label_y: float
    anchor: str


@dataclass(frozen=True)
class CameraMap:
    """A plan: picture of the street's points, walls (x1, y1, x2, y2) px, cameras, how much ellipses grow."""

    width: float
    height: float
    href: str
    walls: tuple[tuple[float, ...], ...]
    cameras: tuple[CameraMark, ...]
    magnified: int
    bar: float
    bar_label: str


def camera_map(data: ReportData) -> CameraMap | None:
    """The oriented photos of a run from above, north up; None without any."""
    if data.orientation is None or not data.orientation.record["photos"]:
        return None
    photos, origin = data.orientation.record["photos"], data.orientation.origin
    places = np.array([p["center"] for p in photos], np.float64)[:, :2] - origin[:2]
    given = _given(photos, origin)
    low, high = _shown(places, given, data.street)
    scale = float(min(*((_WIDTH, _HEIGHT) - 2 * _EDGE) / (high - low), _FINEST))
    low, high = low - _EDGE / scale, high + _EDGE / scale
    pixel = partial(to_figure, origin=np.array([low[0], high[1]]), scale=scale)
    size, reach = (high - low) * scale, _reach(pixel(places))
    half = [_half_axes(p["covariance"]) for p in photos]
    magnified = _magnified([axes[0] * scale for axes in half if axes], reach)
    ellipses = [
        error_ellipse(at, axes, scale * magnified) if axes else None
        for at, axes in zip(pixel(places), half, strict=True)
    ]
    inside = ((data.street > low) & (data.street < high)).all(1)
    points = pixel(data.street[inside])
    bar, bar_label = scale_bar(scale)
    return CameraMap(
        width=float(size[0]),
        height=float(size[1]),
        href=plan_image(points, np.full(len(points), -1), size) if len(points) else "",
        walls=_walls(data, pixel, size),
        cameras=_marks(photos, pixel(places), pixel(given), ellipses, reach),
        magnified=magnified,
        bar=bar,
        bar_label=bar_label,
    )


def _given(photos: Sequence[dict[str, Any]], origin: Float) -> Float:
    """Approximate positions (n, 2) m local; NaN where there is none."""
    nowhere = [np.nan] * 3
    return np.array([p["given"] or nowhere for p in photos], np.float64)[:, :2] - origin[:2]


def _shown(places: Float, given: Float, points: Float) -> tuple[Float, Float]:
    """Corners (2,) m of the map: cameras, their approximate positions, the points around them."""
    close = given[np.linalg.norm(given - places, axis=1) < _ASTRAY]
    cameras = np.vstack([places, close])
    low, high = cameras.min(0), cameras.max(0)
    near = points[((points > low - _AROUND) & (points < high + _AROUND)).all(1)]
    some = np.vstack([cameras, near])
    return some.min(0) - _LONE, some.max(0) + _LONE


def _reach(places: Float) -> float:
    """How long the sides of fields of view are drawn, px: shorter where cameras stand close together."""
    if len(places) < 2:
        return _LONG
    apart, _ = cKDTree(places).query(places, [2])
    return float(np.clip(1.5 * np.median(apart), _SHORT, _LONG))


def _half_axes(covariance: Any) -> tuple[float, float, float] | None:
    """Half-axes of the ellipse in plan; None where the covariance is not known."""
    C = np.array(covariance, np.float64)[:2, :2]
    return half_axes(C) if np.isfinite(C).all() else None


def _magnified(longest: list[float], reach: float) -> int:
    """Magnification that shows most ellipses well and lets none cover the map."""
    if not longest:
        return 1
    decisive = max(float(np.median(longest)) / _TYPICAL, max(longest) / _LONGEST)
    return magnification(decisive, reach)


def _walls(data: ReportData, pixel: partial[Float], size: Float) -> tuple[tuple[float, ...], ...]:
    """The facades in plan, or the walls of the city model where no facade was found."""
    walls = [facade_ends(f) for b in data.buildings for f in b.facades]
    if not walls and data.registration is not None:
        walls = list(data.registration.walls)
    ends = pixel(np.array(walls).reshape(-1, 2)).reshape(-1, 2, 2)
    inside = (ends.max(1) > 0).all(1) & (ends.min(1) < size).all(1)
    return tuple(map(tuple, ends[inside].reshape(-1, 4).tolist()))


def _marks(
    photos: Sequence[dict[str, Any]],
    places: Float,
    given: Float,
    ellipses: Sequence[Ellipse | None],
    reach: float,
) -> tuple[CameraMark, ...]:
    """Cameras at `places` (n, 2) px. A label that would cover another is left out."""
    marks, taken = [], np.empty((0, 2))
    for photo, at, before, ellipse in zip(photos, places, given, ellipses, strict=True):
        mark, middle = _mark(photo, at, before, ellipse, reach)
        apart = (np.abs(taken - middle) < (len(mark.label) * _LETTER, _LINE)).all(1)
        if apart.any():
            mark = replace(mark, label="")
        else:
            taken = np.vstack([taken, middle])
        marks.append(mark)
    return tuple(marks)


def _mark(
    photo: dict[str, Any], at: Float, given: Float, error: Ellipse | None, reach: float
) -> tuple[CameraMark, Float]:
    """A camera with its label behind it, and the middle (2,) px of the label."""
    left, right = _edges(photo)
    corners = np.array([at, at + reach * left, at + reach * right])
    x, y = (left + right) / max(float(np.hypot(*(left + right))), 1e-9)
    anchor, side = ("end", -0.5) if x > 0.5 else ("start", 0.5) if x < -0.5 else ("middle", 0.0)
    label = PurePosixPath(photo["photo"]).stem
    behind = 8.0 + min(0.7 * error.major if error else 0.0, 30.0)
    spot = at - (behind * x, (behind if side else behind + 6.0) * y - 4.0)
    mark = CameraMark(
        name=photo["photo"],
        verdict=photo["verdict"],
        x=float(at[0]),
        y=float(at[1]),
        view=" ".join(f"{u:.1f},{v:.1f}" for u, v in corners),
        error=error,
        given=(float(given[0]), float(given[1])) if np.isfinite(given).all() else None,
        label=label,
        label_x=float(spot[0]),
        label_y=float(spot[1]),
        anchor=anchor,
    )
    return mark, np.array([spot[0] + side * len(label) * _LETTER, spot[1]])


def _edges(photo: dict[str, Any]) -> tuple[Float, Float]:
    """The sides of the field of view in the map, unit vectors (2,) with y down.

    A photo taken upright lies on its side in the world: then its upper and lower edges are what bounds the
    view to the left and right.
    """
    camera = photo["camera"]
    w, h = float(camera["width"]), float(camera["height"])
    R = np.array(photo["camera_from_world"], np.float64)[:, :3]
    level = abs(R[0, 2]) <= abs(R[1, 2])
    ends = [[0.0, h / 2], [w, h / 2]] if level else [[w / 2, 0.0], [w / 2, h]]
    rays = unproject(camera["model"], np.array(camera["params"], np.float64), np.array(ends))
    half = float(np.arccos(np.clip(rays[:, 2], -1.0, 1.0)).mean())
    half = min(half, _WIDEST) if np.isfinite(half) else float(_WIDEST)
    azimuth = np.arctan2(R[2, 1], R[2, 0])
    left, right = azimuth + half, azimuth - half
    return np.array([np.cos(left), -np.sin(left)]), np.array([np.cos(right), -np.sin(right)])
