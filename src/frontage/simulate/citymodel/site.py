"""Where the street runs by the buildings of a city model: before the longest facades, on free ground."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.simulate.citymodel.draft import ModelDraft
from frontage.simulate.citymodel.walls import in_plan

_WIDTHS = (16.0, 14.0, 12.0, 10.0, 8.0, 7.0, 6.0)  # m: the widest street that fits
_ROW = 8.0  # m behind the foremost facade, up to which others stand on the street
_FACING = np.cos(np.radians(20.0))
_TRIED = 24  # facades, the longest ones
_BLANK, _BAY = 0.3, 4.0  # what a metre of blank wall counts; m of wall that an opening makes count whole
_OVERHANG = 0.3  # m that what stands on the street may reach into it
_ENDS = 3.0  # m free beyond the first and the last facade


@dataclass(frozen=True, eq=False)
class Site:
    """A street: its frame, width in m, the s of its first and last house, and which houses stand on it."""

    local_from_street: Rigid3
    width: float
    span: tuple[float, float]
    row: tuple[int, ...]
    free: bool


@dataclass(frozen=True)
class _Front:
    house: int
    frame: Rigid3
    width: float
    worth: float


def find_site(drafts: Sequence[ModelDraft]) -> Site:
    """The street with the most metres of facades on it; `free` is False where all are built over."""
    fronts = sorted(_fronts(drafts), key=lambda f: -f.worth)
    best: tuple[float, Site] | None = None
    for front in fronts[:_TRIED]:
        for alone in (False, True):
            worth, site = _try(drafts, fronts, front, alone)
            if site.free and (best is None or worth > best[0] + 1e-9):
                best = (worth, site)
    return best[1] if best else _try(drafts, fronts, fronts[0], True)[1]


def _fronts(drafts: Sequence[ModelDraft]) -> Iterator[_Front]:
    for k, draft in enumerate(drafts):
        for facade in draft.facades:
            width = float(np.ptp(facade.outline[:, 0]))
            told = min(_BAY * len(facade.openings), width)
            yield _Front(k, draft.frame(facade), width, told + _BLANK * (width - told))


def _try(
    drafts: Sequence[ModelDraft], fronts: Sequence[_Front], front: _Front, alone: bool
) -> tuple[float, Site]:
    """The street along one facade, and what it is worth."""
    x = front.frame.R[:, 0]
    up = np.array([0.0, 0.0, 1.0])
    R = np.column_stack([x, np.cross(up, x), up])
    frame = Rigid3("local", "street", R, np.array([*front.frame.t[:2], drafts[front.house].base]))
    row, worth = _row(fronts, front, frame, alone)
    ends = [in_plan(drafts[k].footprint, frame) for k in row]
    s0, s1 = min(e.bounds[0] for e in ends), max(e.bounds[2] for e in ends)
    front_d = min(d for f in fronts if f.house in row and _faces(f, frame) for d in _depths(f, frame))
    frame = Rigid3("local", "street", R, frame.apply(np.array([[s0, min(front_d, 0.0), 0.0]]))[0])
    span = (0.0, s1 - s0)
    built = shapely.union_all([in_plan(d.footprint, frame) for d in drafts])
    shapely.prepare(built)
    for width in _WIDTHS:
        strip = shapely.box(span[0] - _ENDS, -width + _OVERHANG, span[1] + _ENDS, -_OVERHANG - 0.2)
        if built.intersection(strip).area < 0.01 * strip.area:
            return worth, Site(frame, width, span, row, True)
    return worth, Site(frame, _WIDTHS[-1], span, row, False)


def _row(
    fronts: Sequence[_Front], front: _Front, frame: Rigid3, alone: bool
) -> tuple[tuple[int, ...], float]:
    """The houses on the street along `front`, and the worth of their facades there."""
    found: set[int] = set()
    worth = 0.0
    for f in fronts:
        depth = _depths(f, frame)
        if (f.house == front.house or not alone) and _faces(f, frame) and abs(depth).max() < _ROW:
            found.add(f.house)
            worth += f.worth
    return tuple(sorted(found | {front.house})), worth


def _faces(front: _Front, frame: Rigid3) -> bool:
    return bool(front.frame.R[:, 1] @ frame.R[:, 1] > _FACING)


def _depths(front: _Front, frame: Rigid3) -> Float:
    """d (2,) m of a facade's ends."""
    ends = front.frame.apply(np.array([[0.0, 0.0, 0.0], [front.width, 0.0, 0.0]]))
    return np.asarray(frame.inverse.apply(ends)[:, 1])


def site_plan(draft: ModelDraft, site: Site) -> shapely.Geometry:
    """A building's footprint in the street's (s, d)."""
    return in_plan(draft.footprint, site.local_from_street)
