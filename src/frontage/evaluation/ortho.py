"""Scores ortho-images: how far their content is displaced from that of the true image, tile by tile.

Both pictures are on the true raster. The shift of a tile is found to whole pixels by normalised
cross-correlation of the high-passed grey values, and then refined by ECC (Evangelidis & Psarakis 2008). Only
the plain wall counts, because glass shows something different from every viewpoint and the edges of sills and
cornices move with their shadows. Tiles without texture or without a clear match are left out, since a parked
car is not a displaced wall.
"""

from collections.abc import Sequence

import cv2
import numpy as np

from frontage.evaluation.metric import Metric, ScorePart, median, metric, p95
from frontage.evaluation.result import OrthoPair
from frontage.geometry.arrays import Array, Bool, Float

_TILE_M = 1.6  # side of a tile; tiles overlap by half
_SEARCH_M = 0.25  # largest displacement that is searched for
_KNOWN = 0.4  # share of a tile that must be comparable
_PLAIN_M = 0.02  # true depth up to which the wall is plain
_EDGE_M = 0.03  # margin that is left out around everything else
_ALIKE = 0.5  # least correlation of a match
_NEARER = 0.15  # correlation that a displacement of `_SEARCH_M` must gain over none
_TEXTURE = 1.5  # least standard deviation of the high-passed grey values of a tile
_BORDER_M = 0.3  # rim of a facade that is left out, where the true picture ends


def score_orthos(pairs: Sequence[OrthoPair]) -> ScorePart:
    """Scores the tiles of all facades; px are pixels of the found image.

    `coverage` is the share of the facade that has a pixel; `alike` is the share of textured tiles that match.
    """
    shifts = [(p, *displacements(p)) for p in pairs]
    metres = [s * p.gsd for p, s, _ in shifts]
    length = np.concatenate([np.empty(0), *(np.linalg.norm(m, axis=1) for m in metres)])
    pixels = np.concatenate(
        [np.empty(0), *(np.linalg.norm(m, axis=1) / p.gsd_found for m, p in zip(metres, pairs, strict=True))]
    )
    both = np.concatenate([np.empty((0, 2)), *metres])
    alike = np.concatenate([np.empty(0), *(a for _, _, a in shifts)])
    figures = {
        "displacement_median": metric(length, median, "m"),
        "displacement_p95": metric(length, p95, "m"),
        "displacement_px_median": metric(pixels, median, "px"),
        "displacement_px_p95": metric(pixels, p95, "px"),
        "right_bias": metric(both[:, 0], median, "m"),
        "down_bias": metric(both[:, 1], median, "m"),
        "alike": metric(alike >= _ALIKE, lambda v: v.mean(1)),
        "coverage": metric(np.array([_coverage(p) for p in pairs]), lambda v: v.mean(1)),
        "tiles": Metric(float(len(length)), None, None, len(length)),
        **_relief(pairs),
    }
    rows = tuple(_row(p, m, a) for (p, _, a), m in zip(shifts, metres, strict=True))
    return ScorePart(figures, rows)


def displacements(pair: OrthoPair) -> tuple[Float, Float]:
    """Returns shifts (m, 2) px (right, down) of matching tiles, and correlations (t,) of textured ones."""
    usable = _usable(pair)
    true, found = _detail(pair.true), _detail(pair.found)
    side, reach = max(16, round(_TILE_M / pair.gsd)), max(2, round(_SEARCH_M / pair.gsd))
    shifts: list[tuple[float, float]] = []
    scores: list[float] = []
    h, w = usable.shape
    for r in range(reach, h - side - reach + 1, side // 2):
        for c in range(reach, w - side - reach + 1, side // 2):
            part = slice(r, r + side), slice(c, c + side)
            wide = slice(r - reach, r + side + reach), slice(c - reach, c + side + reach)
            known = usable[part]
            if known.mean() < _KNOWN or true[part][known].std() < _TEXTURE:
                continue
            shift, score = _shift(true[part], known, found[wide], reach)
            scores.append(score)
            if score >= _ALIKE:
                shifts.append(shift)
    return np.array(shifts).reshape(-1, 2), np.array(scores)


def _usable(pair: OrthoPair) -> Bool:
    """Which pixels (h, w) can be compared: known in both, plain wall, and not at the rim of the facade."""
    rim, edge = max(1, round(_BORDER_M / pair.gsd)), 2 * max(1, round(_EDGE_M / pair.gsd)) + 1
    other = pair.opening > 0
    if pair.depth_true is not None:
        other |= ~(np.abs(pair.depth_true) < _PLAIN_M)
    wall = cv2.dilate(other.astype(np.uint8), np.ones((edge, edge), np.uint8)) == 0
    inside = np.zeros(pair.valid.shape, np.bool_)
    inside[rim:-rim, rim:-rim] = True
    return np.asarray(inside & wall & pair.valid)


def _detail(rgb: Array) -> Array:
    """Grey values (h, w) float32 minus those of their surroundings, normalised to equal contrast."""
    grey = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2GRAY).astype(np.float32)
    high = grey - cv2.GaussianBlur(grey, (0, 0), 8)
    return np.asarray(10 * high / (np.sqrt(cv2.GaussianBlur(high * high, (0, 0), 16)) + 4))


def _shift(true: Array, known: Bool, found: Array, reach: int) -> tuple[tuple[float, float], float]:
    """Returns the shift (right, down) px of `true` in `found`, which is `reach` px larger on each side."""
    mask = known.astype(np.float32)
    score = cv2.matchTemplate(found, true, cv2.TM_CCORR_NORMED, mask=mask)
    score = np.where(np.isfinite(score), score, -1.0)
    # Courses of bricks repeat: of two matches that are nearly as good, take the nearer one.
    far = np.hypot(*np.mgrid[-reach : reach + 1, -reach : reach + 1]) / reach
    _, _, _, (x, y) = cv2.minMaxLoc(score - _NEARER * far)
    best = score[y, x]
    part = found[y : y + true.shape[0], x : x + true.shape[1]]
    warp = np.eye(2, 3, dtype=np.float32)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 50, 1e-5)
    try:
        _, warp = cv2.findTransformECC(
            true, part, warp, cv2.MOTION_TRANSLATION, stop, known.astype(np.uint8), 5
        )
    except cv2.error:
        return (0.0, 0.0), -1.0  # no match, because it did not converge
    dx, dy = (float(v) for v in warp[:, 2])
    if max(abs(dx), abs(dy)) > 1.5:
        return (0.0, 0.0), -1.0
    return (x - reach + dx, y - reach + dy), float(best)


def _coverage(pair: OrthoPair) -> float:
    """Share of the facade, as far as the true picture shows it, that the found image covers."""
    shown = pair.true.max(2) > 0
    return float(pair.valid[shown].mean()) if shown.any() else 0.0


def _relief(pairs: Sequence[OrthoPair]) -> dict[str, Metric]:
    """Errors of the relief at a sample of the pixels outside openings where both images have one."""
    parts = [np.empty(0)]
    for p in pairs:
        if p.depth_true is not None and p.depth_found is not None:
            error = np.where(p.opening > 0, np.nan, p.depth_found - p.depth_true)[::8, ::8].ravel()
            parts.append(error[np.isfinite(error)])
    errors = np.concatenate(parts)
    return {
        "relief_bias": metric(errors, median, "m"),
        "relief_median": metric(np.abs(errors), median, "m"),
    }


def _row(pair: OrthoPair, metres: Float, alike: Float) -> dict[str, object]:
    length = np.linalg.norm(metres, axis=1)
    return {
        "id": pair.facade,
        "tiles": len(metres),
        "of": len(alike),
        "displacement_mm": round(1000 * float(np.median(length)), 2) if len(length) else None,
        "coverage": round(_coverage(pair), 4),
    }
