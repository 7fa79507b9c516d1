"""Scores the split of a street into buildings by the points of each house and by the cuts between them."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from frontage.evaluation.metric import Metric, ScorePart, detections, mean, median, metric, p95
from frontage.evaluation.result import LabelledPoints
from frontage.evaluation.truth import TrueBuilding, TrueFacade, Truth, best_share
from frontage.geometry.arrays import Array, Bool, Float, Int

_VISIBLE = 0.5  # share of the facade of a house that must be in sight for the house to count
_NEAR_PLANE_M = 0.5  # points this close to the plane of a facade tell where its house ends
_PARTY_WALL_M = 0.3  # at most between the ends of two facades that share a party wall
_REACH_M = 3.0  # on both sides of a party wall; a cut farther away counts as missed


def score_buildings(
    truth: Truth, points: LabelledPoints, buildings: int, sensors: Sequence[str] = ()
) -> ScorePart:
    """Scores the split into buildings.

    `buildings` is the number of buildings found; `sensors` names those that measured the points. F1 counts
    buildings matched one to one with an IoU of their points of at least 0.5; `iou` is the mean over all
    visible houses.
    """
    iou = _point_overlap(points, len(truth.buildings), buildings)
    row, column = linear_sum_assignment(-iou)
    partner = {int(k): int(j) for k, j in zip(row, column, strict=True) if iou[k, j] >= 0.5}
    seen = [_seen(truth, b, sensors) for b in truth.buildings]
    counts = [(k in partner, False, k not in partner) for k, s in enumerate(seen) if s]
    counts += [(False, True, False)] * (buildings - len(partner))
    figures = detections(np.array(counts, np.float64).reshape(-1, 3))
    best = np.array([iou[k].max(initial=0.0) for k, s in enumerate(seen) if s])
    figures["iou"] = metric(best, mean)
    cuts = list(_cuts(truth, points, partner, seen))
    errors = np.array([c["error_mm"] / 1000 for c in cuts if c["error_mm"] is not None])
    made = np.array([c["error_mm"] is not None for c in cuts], np.float64)
    figures["cuts_found"] = metric(made, mean)
    figures["cut_median"] = metric(np.abs(errors), median, "m")
    figures["cut_p95"] = metric(np.abs(errors), p95, "m")
    figures["count"] = Metric(float(buildings), None, None, buildings)
    return ScorePart(figures, tuple(_rows(truth, iou, partner, seen, points.names)) + tuple(cuts))


def _point_overlap(points: LabelledPoints, houses: int, buildings: int) -> Float:
    """IoU (houses, buildings) of the points of every house and every building."""
    both = (points.house >= 0) & (points.found >= 0)
    shape = houses, buildings
    cell = points.house[both] * buildings + points.found[both]
    shared = np.bincount(cell, minlength=houses * buildings).reshape(shape)
    own = np.bincount(points.house[points.house >= 0], minlength=houses)
    found = np.bincount(points.found[points.found >= 0], minlength=buildings)
    return np.asarray(shared / np.maximum(own[:, None] + found[None] - shared, 1))


def _seen(truth: Truth, building: TrueBuilding, sensors: Sequence[str]) -> bool:
    """Whether the sensors saw enough of a facade of a building for the building to count."""
    shares = [best_share(truth.facade(f).visible, sensors) for f in building.facades]
    return max(shares, default=0.0) >= _VISIBLE


def _cuts(
    truth: Truth, points: LabelledPoints, partner: dict[int, int], seen: list[bool]
) -> Iterator[dict[str, Any]]:
    """Yields the error of the cut between every two visible neighbours that share a wall."""
    index = {b.id: k for k, b in enumerate(truth.buildings)}
    for a in truth.facades:
        for b in truth.facades:
            left, right = index[a.building], index[b.building]
            border = _border(a, b)
            if border is None or not (seen[left] and seen[right]):
                continue
            about: dict[str, Any] = {"cut": f"{a.building}|{b.building}", "error_mm": None}
            if left in partner and right in partner:
                about["error_mm"] = _cut_error(points, a, border, (left, right), partner)
            yield about


def _border(a: TrueFacade, b: TrueFacade) -> float | None:
    """Returns x on `a` where it meets facade `b` of the house to its right; None when they do not meet."""
    if a.building == b.building or a.frame.R[:, 1] @ b.frame.R[:, 1] < 0.9:
        return None
    end = float(a.outline[:, 0].max())
    start = b.frame.apply(np.array([[b.outline[:, 0].min(), 0.0, 0.0]]))
    x, y, _ = a.frame.inverse.apply(start)[0]
    return (end + float(x)) / 2 if abs(x - end) < _PARTY_WALL_M and abs(y) < _REACH_M else None


def _cut_error(
    points: LabelledPoints, facade: TrueFacade, border: float, pair: tuple[int, int], partner: dict[int, int]
) -> float | None:
    """Returns the error in mm along the facade of the border that best separates the points of both sides."""
    local = facade.frame.inverse.apply(points.xyz)
    near = np.abs(local[:, 0] - border) < _REACH_M
    near &= (np.abs(local[:, 1]) < _NEAR_PLANE_M) & np.isin(points.house, pair)
    sides = partner[pair[0]], partner[pair[1]]
    near &= np.isin(points.found, sides)
    x, right = local[near, 0], points.found[near] == sides[1]
    if right.all() or not right.any():
        return None
    return round(1000 * (_best_cut(x, right) - border), 2)


def _best_cut(x: Float, right: Bool) -> float:
    """Returns the x that leaves the fewest points on the wrong side."""
    order: Int = np.argsort(x, kind="stable")
    x, side = x[order], right[order]
    wrong: Array = np.concatenate([[0], np.cumsum(side)]) + np.concatenate(
        [np.cumsum(~side[::-1])[::-1], [0]]
    )
    k = int(np.argmin(wrong))
    return float((x[max(k - 1, 0)] + x[min(k, len(x) - 1)]) / 2)


def _rows(
    truth: Truth, iou: Float, partner: dict[int, int], seen: list[bool], names: tuple[str, ...]
) -> Iterator[dict[str, Any]]:
    """One row per true building, then one per found building without a partner."""
    for k, building in enumerate(truth.buildings):
        j = partner.get(k)
        yield {
            "id": building.id,
            "seen": seen[k],
            "found": None if j is None else names[j],
            "iou": round(float(iou[k].max(initial=0.0)), 4),
        }
    for j in sorted(set(range(len(names))) - set(partner.values())):
        yield {"found": names[j], "matched": None}
