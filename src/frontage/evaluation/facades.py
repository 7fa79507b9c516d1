"""Scores facade planes: offset, angles, outline, and the covariances reported with them."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import shapely

from frontage.evaluation.match import assign
from frontage.evaluation.metric import (
    Metric,
    ScorePart,
    detections,
    mean,
    median,
    metric,
    normalised,
    p95,
    rms,
)
from frontage.evaluation.result import FoundFacade
from frontage.evaluation.truth import TrueFacade, Truth, best_share
from frontage.geometry.arrays import Array, Float
from frontage.model.masonry import TOLERANCES

VISIBLE = 0.5
"""Share of a facade that must be in sight for the facade to count as one that should be found."""

_FAR_M = 1.0  # largest distance of the planes of a match, at the origin of the found one
_SHARED = 0.5  # share of the found outline that must lie on the true facade


def score_facades(truth: Truth, found: Sequence[FoundFacade], sensors: Sequence[str] = ()) -> ScorePart:
    """Scores all facade planes; every true facade is matched with at most one found.

    Planes that lie on no facade of the truth (gables, side walls) count as `elsewhere` and not as wrong.
    """
    pairs = match_facades(truth, found)
    seen = [best_share(t.visible, sensors) >= VISIBLE for t in truth.facades]
    hit = {k for k, _ in pairs}
    counts = [(k in hit, 0, k not in hit) for k, wanted in enumerate(seen) if wanted]
    figures = {"recall": detections(np.array(counts, np.float64).reshape(-1, 3))["recall"]}
    alone = len(found) - len(pairs)
    figures["elsewhere"] = Metric(float(alone), None, None, len(found))
    errors = np.array([plane_error(truth.facades[k], found[j]) for k, j in pairs]).reshape(-1, 3)
    figures |= _errors(errors)
    covered = [_outline(truth.facades[k], found[j]) for k, j in pairs]
    figures["outline_iou"] = metric(np.array(covered), mean)
    figures |= _consistency(errors, [found[j] for _, j in pairs])
    rows = [_row(truth.facades[k], found[j], e) for (k, j), e in zip(pairs, errors, strict=True)]
    missed = [t.id for k, t in enumerate(truth.facades) if seen[k] and k not in hit]
    return ScorePart(figures, tuple(rows + [{"id": name, "found": None} for name in missed]))


def match_facades(truth: Truth, found: Sequence[FoundFacade]) -> list[tuple[int, int]]:
    """Matches true and found facades one to one by their overlap; returns pairs of their indices."""
    share = np.array([[_share(t, f) for f in found] for t in truth.facades])
    row, column = assign(share.reshape(len(truth.facades), len(found)))
    return list(zip(row.tolist(), column.tolist(), strict=True))


def plane_error(truth: TrueFacade, found: FoundFacade) -> Float:
    """Returns the true plane in the found frame: offset along Y at its origin, m, turns about X and Z, rad.

    These are the components 1, 3 and 5 of the tangent vector of `FoundFacade.covariance`.
    """
    normal = found.frame.R.T @ truth.frame.R[:, 1]
    offset = (truth.frame.t - found.frame.t) @ truth.frame.R[:, 1] / (normal[1] or np.nan)
    turn = np.array([normal[2], -normal[0]])
    sine = float(np.hypot(*turn))
    exact = np.arctan2(sine, normal[1]) / sine if sine > 0 else 1.0
    return np.array([offset, *(turn * exact)])


def _share(truth: TrueFacade, found: FoundFacade) -> float:
    """Share of the found outline that lies on a true facade, projected along its normal.

    It is 0 for another plane and for one that mistakes the inside of the house for the street side.
    """
    error = plane_error(truth, found)
    if found.frame.R[:, 1] @ truth.frame.R[:, 1] < TOLERANCES.parallel_cos or abs(error[0]) > _FAR_M:
        return 0.0
    ring, wall = _on(truth, found), shapely.make_valid(shapely.Polygon(truth.outline))
    share = float(ring.intersection(wall).area / max(ring.area, 1e-12))
    return share * min(1.0, ring.area / wall.area) if share >= _SHARED else 0.0


def _on(truth: TrueFacade, found: FoundFacade) -> Any:
    """Projects the found outline onto the true facade, as a polygon (x, z)."""
    xz = found.outline
    local = found.frame.apply(np.column_stack([xz[:, 0], np.zeros(len(xz)), xz[:, 1]]))
    return shapely.make_valid(shapely.Polygon(truth.frame.inverse.apply(local)[:, [0, 2]]))


def _outline(truth: TrueFacade, found: FoundFacade) -> float:
    """IoU of the true and the found outline."""
    a, b = _on(truth, found), shapely.make_valid(shapely.Polygon(truth.outline))
    return float(a.intersection(b).area / a.union(b).area)


def _errors(errors: Array) -> dict[str, Metric]:
    offset, angle = errors[:, 0], np.degrees(np.hypot(errors[:, 1], errors[:, 2]))
    return {
        "offset_bias": metric(offset, median, "m"),
        "offset_median": metric(np.abs(offset), median, "m"),
        "offset_rms": metric(offset, rms, "m"),
        "angle_median": metric(angle, median, "deg"),
        "angle_p95": metric(angle, p95, "deg"),
    }


def _consistency(errors: Array, found: Sequence[FoundFacade]) -> dict[str, Metric]:
    """Tests the plane errors against the reported covariances (NEES, three degrees of freedom each)."""
    squared = []
    for error, facade in zip(errors, found, strict=True):
        if facade.covariance is not None:
            block = facade.covariance[np.ix_([1, 3, 5], [1, 3, 5])]
            if np.linalg.eigvalsh(block)[0] > 0:
                squared.append(float(error @ np.linalg.solve(block, error)))
    return normalised(np.array(squared), "plane", dof=3)


def _row(truth: TrueFacade, found: FoundFacade, error: Float) -> dict[str, Any]:
    row: dict[str, Any] = {"id": truth.id, "found": found.id}
    row |= {"offset_mm": round(1000 * float(error[0]), 3)}
    row |= {"angle_deg": round(float(np.degrees(np.hypot(error[1], error[2]))), 5)}
    if found.covariance is not None:
        row["sigma_mm"] = round(1000 * float(np.sqrt(found.covariance[1, 1])), 3)
    return row
