"""Pictures of single windows: rectified views, evidence, and the chosen layout drawn on the finest view."""

from dataclasses import dataclass

import cv2
import numpy as np
import shapely

from frontage.crossbars import WindowEvidence
from frontage.geometry.arrays import Array, Float
from frontage.model import Bar, Glazing
from frontage.report.colours import COLOURS

_LARGE = 360  # px of the longer side of the picture of the layout
_SMALL = _LARGE // 2
_GAP = 4
_VIEWS = 3  # that are shown besides the evidence
_QUALITY = 82
_LEAST = 160  # px of the longer side: smaller pictures show nothing
_STRENGTH = 0.35  # of the bars over the photo, which must stay visible
_GREY = 139  # between the panels
_FRAME = (255, 213, 74)  # RGB, as the outline of facades
_FINE = 4  # binary digits of a pixel that outlines are drawn to


@dataclass(frozen=True, eq=False)
class WindowTile:
    """A picture of a window: id of the opening, file in the facade's folder, JPEG, names of its panels.

    The first panel is the large one on the left; the others follow row by row.
    """

    opening: str
    file: str
    jpeg: bytes
    panels: tuple[str, ...]


def window_tile(window: WindowEvidence, ring: Float) -> WindowTile | None:
    """Draw what the layout of a window was chosen from; None where neither a photo nor the scan shows it.

    ring  (k, 2) m, the outline of the opening in the facade frame
    """
    small = [(name, image) for name, image in window.views[:_VIEWS]]
    if window.evidence is not None:
        small.append(("evidence", cv2.cvtColor(np.asarray(window.evidence), cv2.COLOR_GRAY2RGB)))
    if not small:
        return None
    x0, z0, x1, z1 = window.extent
    side = np.array([x1 - x0, z1 - z0])
    large, less = (np.maximum(np.round(side * px / side.max()), 1).astype(int) for px in (_LARGE, _SMALL))
    ground = _resized(small[0][1], large)
    title = "layout" if window.glazing.resolved else "not resolved"
    panels = (f"{title} on {small[0][0]}", *(name for name, _ in small))
    image = _arranged(_layout(ground, window, ring), [_resized(one, less) for _, one in small], less)
    file = f"bars/{window.opening.rpartition('/')[2]}.jpg"
    return WindowTile(window.opening, file, _jpeg(image[..., ::-1]), panels)


def fitted(jpeg: bytes, most: int) -> bytes:
    """Return a picture in at most `most` bytes, made smaller if need be; empty if it would show nothing."""
    whole = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert whole is not None
    scale, found = 1.0, jpeg
    while len(found) > most:
        scale *= min(0.9, float(np.sqrt(most / len(found))))
        if scale * max(whole.shape) < _LEAST:
            return b""
        found = _jpeg(cv2.resize(whole, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA))
    return found


def _jpeg(bgr: Array) -> bytes:
    return bytes(cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])[1])


def _resized(image: Array, size: Array) -> Array:
    w, h = (int(v) for v in size)
    shrunk = image.shape[0] > h
    return np.asarray(
        cv2.resize(np.asarray(image), (w, h), interpolation=cv2.INTER_AREA if shrunk else cv2.INTER_LINEAR)
    )


def _arranged(large: Array, small: list[Array], less: Array) -> Array:
    """Put the large picture on the left, the small ones in two columns on its right."""
    h, w = large.shape[:2]
    columns = 1 if len(small) <= 2 else 2
    sheet = np.full((max(h, 2 * less[1] + _GAP), w + columns * (less[0] + _GAP), 3), _GREY, np.uint8)
    sheet[:h, :w] = large
    for k, one in enumerate(small):
        row, column = divmod(k, columns)
        top, left = row * (less[1] + _GAP), w + _GAP + column * (less[0] + _GAP)
        sheet[top : top + less[1], left : left + less[0]] = one
    return sheet


def _layout(ground: Array, window: WindowEvidence, ring: Float) -> Array:
    """Draw outline, frame and bars on a picture of the window."""
    x0, _, x1, z1 = window.extent
    scale = ground.shape[1] / (x1 - x0)

    def pixels(corners: Float) -> Array:
        return np.asarray(np.round(((corners - (x0, z1)) * (scale, -scale) - 0.5) * 2**_FINE), np.int32)

    image, glazing = np.ascontiguousarray(ground), window.glazing
    filled = image.copy()
    for bar in glazing.bars:
        cv2.fillPoly(filled, [pixels(bar_ring(bar))], COLOURS[bar.provenance], cv2.LINE_AA, _FINE)
    image = cv2.addWeighted(filled, _STRENGTH, image, 1 - _STRENGTH, 0.0)
    for bar in glazing.bars:
        cv2.polylines(image, [pixels(bar_ring(bar))], True, COLOURS[bar.provenance], 1, cv2.LINE_AA, _FINE)
    for outline in (ring, *_glass(ring, glazing)):
        cv2.polylines(image, [pixels(outline)], True, _FRAME, 1, cv2.LINE_AA, _FINE)
    return np.asarray(image)


def _glass(ring: Float, glazing: Glazing) -> list[Float]:
    """Return the inner border of the frame, if its width is known."""
    if glazing.frame_width is None:
        return []
    inner = shapely.Polygon(ring).buffer(-float(glazing.frame_width.value), join_style="mitre")
    parts = [part for part in shapely.get_parts(inner) if not part.is_empty]
    return [np.asarray(shapely.get_coordinates(part.exterior)[:-1], np.float64) for part in parts]


def bar_ring(bar: Bar) -> Float:
    """Return the corners (4, 2) m (x, z) of a bar, in the facade frame."""
    low, high = bar.position - bar.width / 2, bar.position + bar.width / 2
    first, last = bar.extent
    corners = np.array([[low, first], [high, first], [high, last], [low, last]])
    return corners if bar.axis == "vertical" else np.array(corners[:, ::-1])
