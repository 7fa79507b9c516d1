"""Scores protrusions: balconies and oriels, and the larger bands, cornices and pilasters.

Tiers of a moulding that touch count as one. Kinds that the truth does not contain (eaves, sills, steps in
front of doors) do not count as wrongly found, and what projects by less than 10 cm does not count as missed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import shapely

from frontage.evaluation.match import assign, overlap
from frontage.evaluation.metric import Metric, ScorePart, detections, mean, median, metric, normalised, p95
from frontage.evaluation.result import BORDERS, FoundProtrusion
from frontage.evaluation.truth import TrueFacade, TrueProtrusion, Truth
from frontage.geometry.arrays import Array, Float
from frontage.geometry.ring import rectangle

_LEAST_PROJECTION_M = 0.1
_ROOMS = ("balcony", "oriel")
_MOULDINGS = ("cornice", "string", "pilaster")
_SAME = {"string": ("band", "cornice"), "cornice": ("cornice", "band"), "pilaster": ("pilaster",)}
_NOT_IN_TRUTH = ("cornice", "band", "sill", "steps", "plinth")  # found kinds that a truth may leave out
_FAR_M = 2.5  # a front farther from the plane of a facade does not belong to it
_TOUCH_M = 0.02  # largest gap between tiers of one moulding
_LEAST_IOU = 0.5  # of a protrusion that counts as found


@dataclass(frozen=True, eq=False)
class ProtrusionPair:
    """A true protrusion, the found one (None = missed), its ring and front in the true frame, their IoU."""

    truth: TrueProtrusion
    found: FoundProtrusion | None = None
    ring: Float | None = None
    front: float = 0.0
    iou: float = 0.0

    @property
    def hit(self) -> bool:
        """Whether it counts as found."""
        return self.iou >= _LEAST_IOU


def score_protrusions(truth: Truth, found: Sequence[FoundProtrusion]) -> ScorePart:
    """Scores detection (at IoU 0.5), borders, fronts and kinds; `found` holds all protrusions of a result."""
    pairs: list[ProtrusionPair] = []
    extra: list[FoundProtrusion] = []
    for facade in truth.facades:
        own = [p for p in found if _is_on(facade, p)]
        some, left = _matched(facade, own)
        pairs += some
        extra += left
    rooms = [p for p in pairs if p.truth.kind in _ROOMS]
    counts = [(p.hit, 0, not p.hit) for p in rooms] + [(0, 1, 0)] * len(extra)
    figures = {"found": Metric(float(len(found)), None, None, len(found))}
    figures |= detections(np.array(counts, np.float64).reshape(-1, 3), "_50")
    for kind in (*_ROOMS, *_MOULDINGS):
        hits = np.array([p.hit for p in pairs if p.truth.kind == kind])
        figures[f"recall_{kind}_50"] = metric(hits, mean)
    good = [p for p in pairs if p.hit]
    figures |= _borders([p for p in good if p.truth.kind in _ROOMS]) | _fronts(good)
    figures["kind_right"] = metric(np.array([_same_kind(p) for p in good]), mean)
    rows = tuple(_row(p) for p in pairs) + tuple({"found": p.id, "kind": p.kind, "id": None} for p in extra)
    return ScorePart(figures, rows)


def _is_on(facade: TrueFacade, found: FoundProtrusion) -> bool:
    """Whether a front is parallel to a facade, near its plane, and at least half within its outline."""
    ring = facade.frame.inverse.apply(found.ring)
    if np.ptp(ring[:, 1]) > _LEAST_PROJECTION_M or abs(ring[:, 1].mean()) > _FAR_M:
        return False
    own = shapely.make_valid(shapely.Polygon(ring[:, [0, 2]]))
    wall = shapely.make_valid(shapely.Polygon(facade.outline))
    return bool(own.intersection(wall).area > 0.5 * own.area)


def _matched(
    facade: TrueFacade, found: Sequence[FoundProtrusion]
) -> tuple[list[ProtrusionPair], list[FoundProtrusion]]:
    """Returns pairs for all larger true protrusions, and found ones that match no true one of any size."""
    real = _of_size(facade.protrusions)
    placed = [facade.frame.inverse.apply(p.ring) for p in found]
    rings = [q[:, [0, 2]] for q in placed]
    iou = overlap([t.ring for t in real], rings)
    row, column = assign(iou)
    partner = dict(zip(row.tolist(), column.tolist(), strict=True))
    pairs = [
        ProtrusionPair(t, found[j], rings[j], float(placed[j][:, 1].mean()), float(iou[k, j]))
        if (j := partner.get(k)) is not None
        else ProtrusionPair(t)
        for k, t in enumerate(real)
    ]
    good = {partner[k] for k, p in enumerate(pairs) if p.hit}
    told = shapely.union_all([shapely.Polygon(p.ring) for p in facade.protrusions if p.kind not in _ROOMS])
    left = [
        p
        for j, p in enumerate(found)
        if j not in good and p.kind not in _NOT_IN_TRUTH and not _mostly(shapely.Polygon(rings[j]), told)
    ]
    return pairs, left


def _mostly(ring: shapely.Polygon, told: shapely.Geometry) -> bool:
    """Whether more than half of a polygon lies in an area."""
    return bool(ring.intersection(told).area > 0.5 * ring.area)


def _of_size(protrusions: Sequence[TrueProtrusion]) -> list[TrueProtrusion]:
    """Returns those that project by 10 cm or more, with touching tiers of one kind merged into one."""
    out: list[TrueProtrusion] = []
    for p in sorted(protrusions, key=lambda p: (p.kind, float(p.ring[:, 1].min()))):
        if p.kind not in (*_ROOMS, *_MOULDINGS) or p.y[0] > -_LEAST_PROJECTION_M:
            continue
        near = out[-1] if out and out[-1].kind == p.kind and p.kind in _MOULDINGS else None
        if near is not None and shapely.Polygon(near.ring).distance(shapely.Polygon(p.ring)) < _TOUCH_M:
            both = np.concatenate([near.ring, p.ring])
            ring = rectangle(*both.min(0), *both.max(0))
            out[-1] = replace(near, ring=ring, y=(min(near.y[0], p.y[0]), near.y[1]))
        else:
            out.append(p)
    return out


def _offsets(p: ProtrusionPair) -> Float:
    """Signed errors (4,) m of left, right, bottom and top, found minus true."""
    a, b = (np.concatenate([r.min(0), r.max(0)]) for r in (p.ring, p.truth.ring) if r is not None)
    return np.asarray((a - b)[[0, 2, 1, 3]])


def _borders(pairs: Sequence[ProtrusionPair]) -> dict[str, Metric]:
    errors: Array = np.array([_offsets(p) for p in pairs]).reshape(-1, 4)
    out = {
        "border_median": metric(np.abs(errors), lambda v: np.median(v, axis=(1, 2)), "m"),
        "border_p95": metric(np.abs(errors), lambda v: np.quantile(v, 0.95, axis=(1, 2)), "m"),
    }
    out |= {f"border_{name}_bias": metric(errors[:, k], median, "m") for k, name in enumerate(BORDERS)}
    sigma = np.array([(p.found.sigma_border or 0.0) if p.found else 0.0 for p in pairs])
    known = sigma > 0
    return out | normalised((errors[known] / sigma[known, None]).ravel(), "border")


def _fronts(pairs: Sequence[ProtrusionPair]) -> dict[str, Metric]:
    errors = np.array([p.front - p.truth.y[0] for p in pairs])
    sigma = np.array([(p.found.sigma_front or 0.0) if p.found else 0.0 for p in pairs])
    return {
        "front_bias": metric(errors, median, "m"),
        "front_median": metric(np.abs(errors), median, "m"),
        "front_p95": metric(np.abs(errors), p95, "m"),
        **normalised(errors[sigma > 0] / sigma[sigma > 0], "front"),
    }


def _same_kind(p: ProtrusionPair) -> bool:
    return p.found is not None and p.found.kind in _SAME.get(p.truth.kind, (p.truth.kind,))


def _row(p: ProtrusionPair) -> dict[str, Any]:
    """One true protrusion for inspection: what was found, and its errors in mm."""
    row: dict[str, Any] = {"id": p.truth.id, "kind": p.truth.kind}
    if p.found is None:
        return row | {"found": None}
    offsets = dict(zip(BORDERS, np.round(1000 * _offsets(p), 2).tolist(), strict=True))
    front = round(1000 * (p.front - p.truth.y[0]), 2)
    return row | {
        "found": p.found.id,
        "as": p.found.kind,
        "iou": round(p.iou, 4),
        "borders_mm": offsets,
        "front_mm": front,
    }
