"""Pictures of what the layout of a window was chosen from: its views, and the evidence of bars."""

import cv2
import numpy as np

from frontage.crossbars.lines import WIDTHS_M, Bars
from frontage.crossbars.observe import Observation, Sight
from frontage.crossbars.rectify import Grid
from frontage.geometry.arrays import Array

_MOST_VIEWS = 6
_STRONGEST = 2.0  # nats per strip and view that are drawn white


def view_pictures(sight: Sight) -> tuple[tuple[str, Array], ...]:
    """Returns names of photos with their views (h, w, 3) uint8 on the plane of the frame, top row first."""
    depth = sight.depth.value if sight.depth is not None else 0.0
    found = []
    for view in sight.views[:_MOST_VIEWS]:
        image = np.clip(np.rint(view.at(sight.grid, depth, view.image)[::-1]), 0, 255)
        found.append((view.name, np.ascontiguousarray(image.astype(np.uint8))))
    return tuple(found)


def evidence_picture(seen: Observation) -> Array:
    """Returns how strongly every pixel (h, w) uint8 speaks for a bar in either direction, top row first."""
    best = np.maximum(*(_strength(bars, seen.sight.grid) for bars in seen.bars))
    scale = _STRONGEST * max(float(seen.weights.sum()), 1.0)
    return np.ascontiguousarray(np.clip(best[::-1] * (255 / scale), 0, 255).astype(np.uint8))


def _strength(bars: Bars, grid: Grid) -> Array:
    """Returns the evidence (h, w) of the best bar whose middle lies on a pixel, of its strip alone."""
    narrow = np.flatnonzero(bars.widths * bars.px <= WIDTHS_M[1])
    strips = np.diff(bars.total[:, :, narrow], axis=0)
    best = np.zeros(strips.shape[:2], np.float32)
    for k, width in enumerate(bars.widths[narrow]):
        half = int(width) // 2
        best[:, half:] = np.maximum(best[:, half:], strips[:, : strips.shape[1] - half, k])
    rows, columns = grid.shape
    size = (columns, rows) if bars.axis == 0 else (rows, columns)
    whole = cv2.resize(best[:, : size[0]], size, interpolation=cv2.INTER_NEAREST)
    return np.asarray(whole if bars.axis == 0 else whole.T)
