"""Scores openings: detection, borders, depth, shape and window bars.

Every true opening is matched with at most one found opening on its facade (largest sum of IoU). Openings that
hardly any sensor saw and those behind closed shutters count neither as missed nor as wrongly found; they have
metrics of their own.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from frontage.evaluation.bars import bar_errors, layout_figures
from frontage.evaluation.match import assign, overlap
from frontage.evaluation.metric import (
    Metric,
    ScorePart,
    detections,
    mean,
    median,
    metric,
    normalised,
    p95,
)
from frontage.evaluation.result import BORDERS, FoundOpening
from frontage.evaluation.truth import TrueFacade, TrueOpening, Truth, best_share
from frontage.geometry.arrays import Array, Float
from frontage.model import DOORS

VISIBLE, PARTLY = 0.8, 0.2
"""Shares of an opening in sight from which it counts as visible and as partly visible."""

_FAR_M = 1.5  # an opening farther from the plane of a facade does not lie on it
_SLANT_COS = np.cos(np.radians(25.0))  # largest angle between an opening and its facade
_INSIDE = 0.5  # share of an opening that must lie within the outline of its facade
_WHOLLY = 0.95  # share from which it lies wholly within


@dataclass(frozen=True, eq=False)
class OpeningPair:
    """A true opening and the found one that it was matched with (None = missed).

    seen   "visible", "partly", "hidden" or "shuttered"
    ring   (k, 2) m (x, z), the found ring in the true facade frame
    iou    of both rings
    bars   (m,) m, position errors of the bars; exact = whether their layout is right
    """

    truth: TrueOpening
    seen: str
    found: FoundOpening | None = None
    ring: Float | None = None
    iou: float = 0.0
    bars: Array | None = None
    exact: bool | None = None


def score_openings(truth: Truth, found: Sequence[FoundOpening], sensors: Sequence[str] = ()) -> ScorePart:
    """Scores all openings; `sensors` names the sensors that the result may have used (none named = all)."""
    pairs, extra, elsewhere = _matched(truth, found, sensors)
    figures = {"found": Metric(float(len(found)), None, None, len(found)), **_detection(pairs, extra)}
    for seen in ("visible", "partly", "hidden", "shuttered"):
        some = [p for p in pairs if p.seen == seen]
        for level in (0.5, 0.75):
            hit = np.array([p.iou >= level for p in some])
            figures[f"recall_{seen}_{round(100 * level)}"] = metric(hit, mean)
    good = [p for p in pairs if p.found is not None and p.iou >= 0.5]
    figures |= _borders(good) | _depth(good) | _labels(good) | _bars(good)
    rows = tuple(_row(p) for p in pairs) + tuple({"found": o.id, "matched": None} for o in extra)
    notes = (f"{len(elsewhere)} openings lie on no facade of the truth and are not scored",)
    return ScorePart(figures, rows, notes if elsewhere else ())


def _matched(
    truth: Truth, found: Sequence[FoundOpening], sensors: Sequence[str]
) -> tuple[list[OpeningPair], list[FoundOpening], list[FoundOpening]]:
    """Returns pairs for all true openings, found ones without a partner, and those on no true facade."""
    home = [_home(truth.facades, o) for o in found]
    pairs: list[OpeningPair] = []
    extra: list[FoundOpening] = []
    for number, facade in enumerate(truth.facades):
        own = [o for o, h in zip(found, home, strict=True) if h == number]
        rings = [_plan(facade, o.ring) for o in own]
        iou = overlap([o.ring for o in facade.openings], rings)
        row, column = assign(iou)
        partner = dict(zip(row.tolist(), column.tolist(), strict=True))
        for k, opening in enumerate(facade.openings):
            seen = visibility(opening, sensors)
            if (j := partner.get(k)) is None:
                pairs.append(OpeningPair(opening, seen))
                continue
            errors, exact = bar_errors(facade, opening, own[j])
            pairs.append(OpeningPair(opening, seen, own[j], rings[j], float(iou[k, j]), errors, exact))
        extra += [o for j, o in enumerate(own) if j not in set(column.tolist())]
    return pairs, extra, [o for o, h in zip(found, home, strict=True) if h is None]


def visibility(opening: TrueOpening, sensors: Sequence[str] = ()) -> str:
    """Classifies an opening as "visible", "partly", "hidden" or "shuttered", by the sensor that saw most."""
    if opening.shutters == "closed":
        return "shuttered"
    best = best_share(opening.visible, sensors)
    return "visible" if best >= VISIBLE else "partly" if best >= PARTLY else "hidden"


def _home(facades: Sequence[TrueFacade], opening: FoundOpening) -> int | None:
    """Returns the number of the facade that an opening lies on, or None.

    It must be near the plane, parallel to it, and mostly within the outline. Where several outlines hold it,
    because the front steps, it lies on the one with the true opening that it is most like, else on the
    nearest plane.
    """
    found: list[tuple[bool, float, float, int]] = []
    normal = _normal(opening.ring)
    for number, facade in enumerate(facades):
        y = facade.frame.inverse.apply(opening.ring)[:, 1]
        if abs(y.mean()) > _FAR_M or abs(normal @ facade.frame.R[:, 1]) < _SLANT_COS:
            continue
        flat = _plan(facade, opening.ring)
        ring = shapely.make_valid(shapely.Polygon(flat))
        share = float(ring.intersection(_extent(facade)).area / max(ring.area, 1e-12))
        if share > _INSIDE:
            like = float(overlap([o.ring for o in facade.openings], [flat]).max(initial=0.0))
            found.append((share < _WHOLLY, -round(like, 3), float(abs(y.mean())), number))
    return min(found)[-1] if found else None


def _extent(facade: TrueFacade) -> Any:
    """Returns the outline of a facade with all of its openings, as one convex polygon (x, z).

    The outline of a front with several gables is that of one of them.
    """
    corners = np.concatenate([facade.outline, *(o.ring for o in facade.openings)])
    return shapely.convex_hull(shapely.multipoints(corners))


def _plan(facade: TrueFacade, ring: Float) -> Float:
    """Projects a ring (k, 3) m onto a facade: (k, 2) m (x, z)."""
    return np.asarray(facade.frame.inverse.apply(ring)[:, [0, 2]])


def _normal(ring: Float) -> Float:
    """Unit normal of a ring (k, 3) by Newell's method; zero for a degenerate one."""
    spokes = ring - ring.mean(0)
    total = np.cross(spokes, np.roll(spokes, -1, 0)).sum(0)
    length = float(np.linalg.norm(total))
    return np.asarray(total / length if length > 0 else total)


def _counts(pairs: Iterable[OpeningPair], extra: int, level: float, classes: Sequence[str]) -> Array:
    """Rows (n, 3): found and true, found but not true, missed; only `classes` can be missed."""
    rows = []
    for p in pairs:
        hit = p.iou >= level
        if p.seen in classes:
            rows.append((hit, p.found is not None and not hit, not hit))
        elif p.found is not None and not hit and p.iou < 0.25:
            rows.append((False, True, False))
    return np.array([*rows, *[(0, 1, 0)] * extra], np.float64).reshape(-1, 3)


def _detection(pairs: Sequence[OpeningPair], extra: Sequence[FoundOpening]) -> dict[str, Metric]:
    """Precision, recall and F1 of all openings that were at least partly visible, and of the visible ones."""
    out: dict[str, Metric] = {}
    for level in (0.5, 0.75):
        name = f"_{round(100 * level)}"
        out |= detections(_counts(pairs, len(extra), level, ("visible", "partly")), name)
        out |= detections(_counts(pairs, len(extra), level, ("visible",)), f"_visible{name}")
    out["iou"] = metric(np.array([p.iou for p in pairs if p.iou >= 0.5]), mean)
    return out


def _box(ring: Float) -> Float:
    """Left, right, bottom and top of a ring (k, 2)."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    return np.array([x0, x1, z0, z1])


def _offsets(pairs: Sequence[OpeningPair]) -> Array:
    """Signed border errors (n, 4) m, found minus true along x (left, right) and z (bottom, top)."""
    rows = [_box(p.ring) - _box(p.truth.ring) for p in pairs if p.ring is not None]
    return np.array(rows).reshape(-1, 4)


def _borders(pairs: Sequence[OpeningPair]) -> dict[str, Metric]:
    errors = _offsets(pairs)
    out = {
        "border_median": metric(np.abs(errors), lambda v: np.median(v, axis=(1, 2)), "m"),
        "border_p95": metric(np.abs(errors), lambda v: np.quantile(v, 0.95, axis=(1, 2)), "m"),
    }
    for k, name in enumerate(BORDERS):
        out[f"border_{name}_bias"] = metric(errors[:, k], median, "m")
        out[f"border_{name}_median"] = metric(np.abs(errors[:, k]), median, "m")
    out["width_bias"] = metric(errors[:, 1] - errors[:, 0], median, "m")
    out["height_bias"] = metric(errors[:, 3] - errors[:, 2], median, "m")
    ratio = [
        e / s
        for p, row in zip(pairs, errors, strict=True)
        for name, e in zip(BORDERS, row, strict=True)
        if p.found and (s := p.found.sigma.get(name, 0.0)) > 0
    ]
    return out | normalised(np.array(ratio), "border")


def _depth(pairs: Sequence[OpeningPair]) -> dict[str, Metric]:
    known = [(p.found, p.truth) for p in pairs if p.found is not None and p.found.depth is not None]
    errors = np.array([(f.depth or 0.0) - t.depth for f, t in known])
    ratio = [e / s for (f, _), e in zip(known, errors, strict=True) if (s := f.sigma.get("depth", 0.0)) > 0]
    return {
        "depth_bias": metric(errors, median, "m"),
        "depth_median": metric(np.abs(errors), median, "m"),
        "depth_p95": metric(np.abs(errors), p95, "m"),
        **normalised(np.array(ratio), "depth"),
    }


def _labels(pairs: Sequence[OpeningPair]) -> dict[str, Metric]:
    """Shares of openings whose kind and shape are right."""
    kinds = [_same_kind(p.found, p.truth.kind) for p in pairs if p.found is not None]
    shapes = [p.found.shape.lower() == p.truth.shape for p in pairs if p.found is not None and p.found.shape]
    return {"kind_right": metric(np.array(kinds), mean), "shape_right": metric(np.array(shapes), mean)}


def _same_kind(found: FoundOpening, kind: str) -> bool:
    """Whether the kind is right; a coarse result only distinguishes doors from windows."""
    told = found.kind.lower()
    return (told == "door") == (kind in DOORS) if found.coarse else told == kind


def _bars(pairs: Sequence[OpeningPair]) -> dict[str, Metric]:
    """Shares of glazed openings whose layout is right, and errors of positions; unseen ones are not asked."""
    asked = [(p.truth, p.exact) for p in pairs if p.exact is not None or p.seen in ("visible", "partly")]
    errors = np.concatenate([np.empty(0), *(p.bars for p in pairs if p.bars is not None)])
    return layout_figures(asked) | {
        "bars_bias": metric(errors, median, "m"),
        "bars_median": metric(np.abs(errors), median, "m"),
    }


def _row(p: OpeningPair) -> dict[str, Any]:
    """One true opening for inspection: what was found, and its errors in mm."""
    row: dict[str, Any] = {"id": p.truth.id, "kind": p.truth.kind, "seen": p.seen}
    if p.found is None or p.ring is None:
        return row | {"found": None}
    offsets = (_box(p.ring) - _box(p.truth.ring)) * 1000
    row |= {"found": p.found.id, "iou": round(p.iou, 4)}
    row["borders_mm"] = {name: round(float(e), 2) for name, e in zip(BORDERS, offsets, strict=True)}
    if p.found.depth is not None:
        row["depth_mm"] = round(1000 * (p.found.depth - p.truth.depth), 2)
    return row | ({} if p.exact is None else {"bars_exact": p.exact})
