"""A stand-in for the search for bars, which rectifies the photos and chooses layouts by rule."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import cv2
import numpy as np

from frontage.crossbars import CrossbarOptions, FoundBars, WindowEvidence
from frontage.geometry.arrays import Array
from frontage.model import Bar, Elements, Estimate, Facade, Glazing, Opening, Photo, Scan

COARSE = "the pixels of the photos are too coarse"
UNSEEN = "no photo shows it, and the scan is too sparse"


def stand_in(
    facade: Facade,
    elements: Elements,
    photos: Sequence[Photo],
    image_of: Callable[[str], Array],
    scan: Scan | None,
    options: CrossbarOptions | None = None,
) -> FoundBars:
    """Gives every window that a photo shows a mullion and a transom, every third one no resolved layout."""
    if options is not None and options.method == "none":
        return FoundBars(elements, ())
    known, found, windows = {p.id: p for p in photos}, list[Opening](), list[WindowEvidence]()
    for number, o in enumerate(elements.openings):
        if o.kind != "window":
            found.append(o)
            continue
        glazing = _glazing(o, number)
        found.append(replace(o, glazing=glazing))
        (x0, z0), (x1, z1) = o.ring.min(0) - 0.1, o.ring.max(0) + 0.1
        extent = (float(x0), float(z0), float(x1), float(z1))
        if o.photos:
            views = tuple((n, rectified(facade, extent, known[n], image_of(n))) for n in o.photos)
            grey = cv2.cvtColor(views[0][1], cv2.COLOR_RGB2GRAY)
            windows.append(WindowEvidence(o.id, extent, views, np.asarray(grey, np.uint8), glazing))
    return FoundBars(replace(elements, openings=tuple(found)), tuple(windows), ("a note on all windows",))


def _glazing(o: Opening, number: int) -> Glazing:
    if not o.photos:
        return Glazing(False, note=UNSEEN)
    if number % 3 == 2:
        return Glazing(False, sources=o.photos, note=COARSE)
    (x0, z0), (x1, z1) = o.ring.min(0), o.ring.max(0)
    bars = (
        Bar("vertical", float(x0 + x1) / 2, (float(z0), float(z1)), 0.06, 0.002, 0.004),
        Bar("horizontal", float(0.3 * z0 + 0.7 * z1), (float(x0), float(x1)), 0.05, 0.003),
    )
    width, depth = (Estimate(v, np.array([[0.003**2]]), 20.0) for v in (0.06, 0.15))
    return Glazing(True, bars, width, depth, 0.97, (*o.photos, "scan"))


def rectified(facade: Facade, extent: tuple[float, float, float, float], photo: Photo, image: Array) -> Array:
    """A photo rectified onto the wall, (h, w, 3) uint8 RGB at 1 cm."""
    x0, z0, x1, z1 = extent
    x, z = np.meshgrid(np.arange(x0, x1, 0.01), np.arange(z1, z0, -0.01))
    xyz = np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()])
    at = (photo.project(facade.frame.apply(xyz)) - 0.5).astype(np.float32).reshape(*x.shape, 2)
    return np.asarray(cv2.remap(np.asarray(image), at[..., 0], at[..., 1], cv2.INTER_LINEAR), np.uint8)
