"""Leaded lights: small panes between lead cames all over a window, which are told but not divided.

Cames lie a few centimetres behind the frame, so that the plane of the frame shows them displaced from view to
view. The autocorrelation of a picture does not know about displacements. That of a mesh of diamonds has peaks
at whole diamonds and at half ones to both sides at once, and none at half a diamond straight across; that of
small rectangles has them at whole ones in both directions, and none between. No bars and no curtains have the
one, and the other is too small for panes between glazing bars.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from scipy import fft
from scipy.ndimage import map_coordinates

from frontage.crossbars.candidates import Box
from frontage.crossbars.rectify import Grid, PlaneView
from frontage.geometry.arrays import Array

_STEP_M = 0.004  # raster of the autocorrelation
_LOCAL_M = 0.05  # about a pixel, whose mean is removed: a came stands out from its panes
_STRONGEST = 3.0  # times the mean difference beyond which a pixel counts no more
_WIDTHS_M = np.arange(0.07, 0.165, 0.004)  # of small panes
_RATIOS = np.arange(0.9, 2.0, 0.05)  # of their heights by their widths
_FEW = 2.5  # small panes across a window, without which a mesh is not told
_MESH = 0.03  # contrast of the autocorrelation, higher at whole panes than between; noise makes a third of it
_WIDEST_CAME_M = 0.0145
_FEWEST_CAMES = 4
_MULLION_M = 0.06  # bars between lights may be of wood or stone
_MESHES = {
    "diamonds": (((0.5, 0.5), (0.5, -0.5), (1.0, 0.0), (0.0, 1.0)), ((0.5, 0.0), (0.0, 0.5))),
    "rectangles": (((1.0, 0.0), (0.0, 1.0), (1.0, 1.0)), ((0.5, 0.0), (0.0, 0.5), (0.5, 0.5))),
}
"""Displacements, in sizes of a small pane, at which a mesh falls on itself, and those between."""


def leaded(grid: Grid, views: Sequence[PlaneView], box: Box) -> str:
    """Returns what the small panes of a leaded light are, "diamonds" or "rectangles"; "" without any.

    box  x0, z0, x1, z1 m inside the frame
    """
    contrast = mesh_contrasts(grid, views, box)
    best = max(contrast, key=lambda kind: contrast[kind])
    return best if contrast[best] > _MESH else ""


def mesh_contrasts(grid: Grid, views: Sequence[PlaneView], box: Box) -> dict[str, float]:
    """Returns how clearly the panes are a mesh of small ones of every kind, -1..1."""
    total = _autocorrelation(grid, views, box)
    return {kind: _contrast(total, box, kind) for kind in _MESHES}


def _contrast(total: Array | None, box: Box, kind: str) -> float:
    w, ratio = np.meshgrid(_WIDTHS_M, _RATIOS, indexing="ij")
    h = w * ratio
    fits = (w * _FEW < box[2] - box[0]) & (h * _FEW < box[3] - box[1])
    if total is None or not fits.any():
        return -1.0
    peaks, between = ([_at(total, a * w, b * h) for a, b in places] for places in _MESHES[kind])
    return float(np.where(fits, np.min(peaks, axis=0) - np.max(between, axis=0), -1.0).max())


def _autocorrelation(grid: Grid, views: Sequence[PlaneView], box: Box) -> Array | None:
    """Returns the mean autocorrelation of the views inside the frame, zero displacement in the middle."""
    x, z = grid.centres(0), grid.centres(1)
    columns = np.flatnonzero((x > box[0]) & (x < box[2]))
    rows = np.flatnonzero((z > box[1]) & (z < box[3]))
    size = (round((box[2] - box[0]) / _STEP_M), round((box[3] - box[1]) / _STEP_M))
    if min(size) < 20 or not len(views):
        return None
    part = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    # Displacements beyond the largest pane are not asked for, and may fall on others.
    reach = round(_WIDTHS_M[-1] * _RATIOS[-1] / _STEP_M) + 2
    shape = fft.next_fast_len(size[1] + reach, real=True), fft.next_fast_len(size[0] + reach, real=True)
    power, overlap = (np.zeros((shape[0], shape[1] // 2 + 1), np.float32) for _ in range(2))
    for view in views:
        fine, known = _standing_out(view.grey[part], view.inside[part] > 0.9, size)
        power += np.abs(fft.rfft2(fine, shape)) ** 2
        overlap += np.abs(fft.rfft2(known, shape)) ** 2
    together, shown = fft.irfft2(power, shape), fft.irfft2(overlap, shape)
    if together[0, 0] <= 0.0:
        return None
    mean = np.where(shown > 0.1 * shown[0, 0], together / np.maximum(shown, 1e-6), 0.0)
    return np.asarray(fft.fftshift(mean / mean[0, 0]))


def _standing_out(grey: Array, known: Array, size: tuple[int, int]) -> tuple[Array, Array]:
    """Returns how much every pixel differs from its surroundings, and where this is known."""
    grey = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    seen = (cv2.resize(known.astype(np.float32), size, interpolation=cv2.INTER_AREA) > 0.99).astype(
        np.float32
    )
    reach = 2 * round(0.5 * _LOCAL_M / _STEP_M) + 1
    local = cv2.blur(grey * seen, (reach, reach)) / np.maximum(cv2.blur(seen, (reach, reach)), 1e-3)
    away = (grey - local) * seen
    most = _STRONGEST * float(np.abs(away).sum() / max(float(seen.sum()), 1.0))
    return np.clip(away, -most, most), seen


def _at(total: Array, x: Array, z: Array) -> Array:
    middle = np.array(total.shape) // 2
    at = np.stack([middle[0] + z / _STEP_M, middle[1] + x / _STEP_M])
    return np.asarray(map_coordinates(total, at, order=1, mode="constant"))


def are_cames(widths: Sequence[float]) -> bool:
    """Whether bars of these widths m are as thin as the lead that holds small panes, mullions aside.

    Cames are 6 to 13 mm wide; bars of wood and iron that carry glass have 16 mm and more.
    """
    thin = [width for width in widths if width < _MULLION_M]
    return len(thin) >= _FEWEST_CAMES and bool(np.median(thin) < _WIDEST_CAME_M)
