"""Gathers what shows each window: crops of the photos, and scan points about the plane of its frame."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from frontage.crossbars.window import Window, WindowView
from frontage.geometry.arrays import Array, Float
from frontage.geometry.ring import ring_contains
from frontage.model import Elements, Facade, Opening, OpeningKind, Photo, Scan

GLAZED = frozenset({OpeningKind.WINDOW, OpeningKind.SHOPFRONT, OpeningKind.BASEMENT})
"""The kinds of opening that are closed by glass; doors, gates and passages are not looked at."""

MOST_VIEWS = 8  # of a window, the finest; more cost time and add little
_MARGIN_M = 0.12  # around the outline on the wall: errors of poses and of the outline, and the wall beside it
_BEHIND_M = 0.7  # behind the wall: no frame lies deeper
_BEFORE_M = 0.03  # before the wall: frames flush with it, and noise
_FINEST_M = 0.0015  # px size on the wall beyond which photos are reduced: bars are at least ten times as wide
_MOST_PX = 120e6  # of all crops of a facade: 360 MB
_AROUND_M = 0.4  # of wall about a window, whose points tell the spacing
_FEW = 30  # points that tell their spacing
_CELL_M = 0.15  # side of the cells in which they are counted


@dataclass(frozen=True, eq=False)
class _Cut:
    """What to cut from a photo: first (column, row) and size (w, h) px, whole factor of reduction."""

    window: int
    corner: tuple[int, int]
    size: tuple[int, int]
    factor: int
    visible: float
    gsd: float
    cosine: float


def collect_windows(
    facade: Facade,
    elements: Elements,
    photos: Sequence[Photo],
    image_of: Callable[[str], Array],
    scan: Scan | None,
) -> tuple[Window, ...]:
    """Returns the glazed openings of a facade with their views and scan points, in the elements' order.

    photos    the oriented photos; those that `Opening.photos` names are the views of an opening
    image_of  returns the pixels (h, w, 3) uint8 RGB of a photo; called once per photo that is needed
    scan      the cloud that `facade.support` counts in; None = no scan

    Only the outline on the wall is cut out, with a margin: whatever lies behind the wall is seen through it.
    Crops much finer than bars need are reduced by a whole number, so that all crops of a facade stay below
    about 400 MB.
    """
    glazed = [o for o in elements.openings if o.kind in GLAZED]
    known = {p.id: p for p in photos if p.local_from_camera is not None}
    cuts = _cuts(facade, elements, glazed, known)
    views: list[list[WindowView]] = [[] for _ in glazed]
    for name in sorted(cuts):
        image = image_of(name)
        for cut in cuts[name]:
            views[cut.window].append(_view(known[name], image, cut))
    cloud = _cloud(facade, scan)
    return tuple(
        _window(facade, opening, elements.wall_y(opening), own, cloud)
        for opening, own in zip(glazed, views, strict=True)
    )


def _cuts(
    facade: Facade, elements: Elements, glazed: Sequence[Opening], known: Mapping[str, Photo]
) -> dict[str, list[_Cut]]:
    """Returns what to cut out of which photo."""
    whole: list[tuple[str, _Cut]] = []
    for k, opening in enumerate(glazed):
        cuts = [
            (name, cut)
            for name in opening.photos
            if name in known and (cut := _cut(facade, opening, elements.wall_y(opening), known[name], k))
        ]
        whole += sorted(cuts, key=lambda named: (named[1].gsd, named[0]))[:MOST_VIEWS]
    pixels = sum(cut.size[0] * cut.size[1] / _factor(cut, _FINEST_M) ** 2 for _, cut in whole)
    finest = _FINEST_M * max(1.0, float(np.sqrt(pixels / _MOST_PX)))
    found: dict[str, list[_Cut]] = {}
    for name, cut in whole:
        f = _factor(cut, finest)
        size = (cut.size[0] // f * f, cut.size[1] // f * f)
        found.setdefault(name, []).append(
            _Cut(cut.window, cut.corner, size, f, cut.visible, cut.gsd * f, cut.cosine)
        )
    return found


def _factor(cut: _Cut, finest: float) -> int:
    """Returns by which whole number a crop is reduced, so that it is not much finer than `finest`."""
    return max(1, int(finest / cut.gsd + 0.25))


def _cut(facade: Facade, opening: Opening, wall_y: float, photo: Photo, number: int) -> _Cut | None:
    """Returns the part of a photo that shows an opening; None where the photo looks past it."""
    low, high = opening.ring.min(0) - _MARGIN_M, opening.ring.max(0) + _MARGIN_M
    x, z = (np.linspace(low[k], high[k], 9) for k in (0, 1))
    grid = np.stack([g.ravel() for g in np.meshgrid(x, [wall_y], z, indexing="ij")], axis=1)
    middle = facade.frame.apply(grid.mean(0, keepdims=True))[0]
    way = middle - photo.pose.t
    cosine = float(way @ facade.frame.R[:, 1] / np.linalg.norm(way))
    at = photo.project(facade.frame.apply(grid))
    size = np.array([photo.camera.width, photo.camera.height])
    with np.errstate(invalid="ignore"):
        inside = ((at >= 0) & (at < size)).all(1)
    if cosine <= 0.05 or not inside.any():
        return None
    first = np.maximum(np.floor(np.nanmin(at, axis=0)), 0).astype(int)
    last = np.minimum(np.ceil(np.nanmax(at, axis=0)), size).astype(int)
    if (last - first < 8).any():
        return None
    corner, extent = (int(first[0]), int(first[1])), (int(last[0] - first[0]), int(last[1] - first[1]))
    gsd = _gsd(facade, middle, photo)
    return _Cut(number, corner, extent, 1, float(inside.mean()), gsd, cosine) if np.isfinite(gsd) else None


def _gsd(facade: Facade, middle: Float, photo: Photo) -> float:
    """Returns m on the wall per px, in the direction in which it is coarser."""
    step = 0.01
    right, up = facade.frame.R[:, 0], facade.frame.R[:, 2]
    at = photo.project(np.array([middle, middle + step * right, middle + step * up]))
    return step / float(np.linalg.norm(at[1:] - at[0], axis=1).min())


def _view(photo: Photo, image: Array, cut: _Cut) -> WindowView:
    (c, r), (w, h) = cut.corner, cut.size
    pixels = image[r : r + h, c : c + w]
    if cut.factor > 1:
        pixels = cv2.resize(pixels, (w // cut.factor, h // cut.factor), interpolation=cv2.INTER_AREA)
    return WindowView(
        photo, np.ascontiguousarray(pixels), cut.corner, cut.visible, cut.gsd, cut.cosine, 1.0 / cut.factor
    )


def _cloud(facade: Facade, scan: Scan | None) -> Float:
    """Returns the facade's scan points (n, 3) m in its frame, from left to right."""
    if scan is None:
        return np.empty((0, 3))
    points = facade.frame.inverse.apply(scan.xyz[facade.support])
    return np.asarray(points[np.argsort(points[:, 0], kind="stable")])


def _spacing(wall: Float) -> float:
    """Returns the spacing m of points (n, 3) on a wall, which has holes: from cells that hold points."""
    cell = np.floor((wall[:, [0, 2]] - wall[:, [0, 2]].min(0)) / _CELL_M).astype(np.int64)
    count = np.bincount(cell[:, 0] * (cell[:, 1].max() + 1) + cell[:, 1])
    return float(_CELL_M / np.sqrt(np.median(count[count > 0])))


def _window(
    facade: Facade, opening: Opening, wall_y: float, views: Sequence[WindowView], cloud: Float
) -> Window:
    low, high = opening.ring.min(0), opening.ring.max(0)
    first, last = np.searchsorted(cloud[:, 0], [low[0] - _AROUND_M, high[0] + _AROUND_M])
    near = cloud[first:last]
    near = near[(near[:, 2] > low[1] - _AROUND_M) & (near[:, 2] < high[1] + _AROUND_M)]
    within = ring_contains(opening.ring, near[:, [0, 2]])
    deep = (near[:, 1] > wall_y - _BEFORE_M) & (near[:, 1] < wall_y + _BEHIND_M)
    wall = near[~within & (np.abs(near[:, 1] - wall_y) < 2 * _BEFORE_M)]
    spacing = _spacing(wall) if len(wall) >= _FEW else facade.spacing
    ordered = tuple(sorted(views, key=lambda v: (v.gsd, v.photo.id)))
    return Window(opening, facade.frame, wall_y, ordered, near[within & deep], spacing)
