"""Depth buffers of point clouds."""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float

MAX_RADIUS_PX = 24  # very close points would cover the picture; no gap between samples is that wide


def splat_depth(xy: Float, depth: Float, radius: Float, shape: tuple[int, int]) -> Array:
    """Returns the nearest depth (h, w) float32 at every pixel, inf where there is no point.

    Each point covers a disc: xy (n, 2) px (first pixel centre at 0.5), depth (n,) m, radius (n,) px. Points
    are grouped by whole radius, written with a minimum, and grown with a minimum filter, so that the time
    does not depend on the size of the discs.
    """
    h, w = shape
    out = np.full(shape, np.inf, np.float32)
    with np.errstate(invalid="ignore"):
        inside = (xy[:, 0] >= 0) & (xy[:, 0] < w) & (xy[:, 1] >= 0) & (xy[:, 1] < h) & (depth > 0)
    column, row = xy[inside].astype(np.int64).T
    cell, depth = row * w + column, depth[inside].astype(np.float32)
    size = np.clip(np.rint(radius[inside]), 0, MAX_RADIUS_PX).astype(np.int64)
    for r in np.unique(size):
        own = size == r
        layer = np.full(h * w, np.inf, np.float32)
        np.minimum.at(layer, cell[own], depth[own])
        layer = layer.reshape(shape)
        if r > 0:
            disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * int(r) + 1,) * 2)
            layer = cv2.erode(layer, disc, borderType=cv2.BORDER_REPLICATE)
        np.minimum(out, layer, out=out)
    return out


def local_spacing(xyz: Float, samples_per_cell: int = 8) -> tuple[Float, Float]:
    """Returns the spacing (n,) m of a cloud (n, 3) of surfaces and the number of points (n,) around each.

    Points are counted in cubes. A surface that crosses a cube of edge e with k points has a spacing of
    ``e / sqrt(k)``. The edge doubles from 25 cm until the median cube holds `samples_per_cell` points.
    """
    edge = 0.25
    if len(xyz) == 0:
        return np.empty(0), np.empty(0)
    while True:
        key = np.floor((xyz - xyz.min(0)) / edge).astype(np.int64)
        shape = key.max(0) + 1
        flat = (key[:, 0] * shape[1] + key[:, 1]) * shape[2] + key[:, 2]
        _, inverse, count = np.unique(flat, return_inverse=True, return_counts=True)
        k = count[inverse].astype(np.float64)
        if np.median(k) >= samples_per_cell or edge >= 8.0:
            return edge / np.sqrt(k), k
        edge *= 2.0
