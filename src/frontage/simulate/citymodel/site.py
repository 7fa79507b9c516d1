"""Finds where the street runs past a city model's buildings: along the longest facades, on free ground."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.simulate.citymodel.draft import ModelDraft
from frontage.simulate.citymodel.walls import in_plan

_WIDTHS_M = (16.0, 14.0, 12.0, 10.0, 8.0, 7.0, 6.0)  # of the street; the widest that fits is taken
_ROW_M = 8.0  # depth within which facades belong to the same street
_FACING_COS = np.cos(np.radians(20.0))  # least cosine between a facade's normal and the street's
_TRIED = 24  # number of facades, the longest ones, along which a street is tried
_BLANK_WEIGHT = 0.3  # of a metre of blank wall, relative to a metre with openings
_BAY_M = 4.0  # length of wall that one opening gives full weight
_OVERHANG_M = 0.3  # by which buildings may reach into the street
_ENDS_M = 3.0  # of free street beyond the first and the last facade


@dataclass(frozen=True, eq=False)
class Site:
    """The site of a street.

    width   m
    span    m, s of the beginning of its first house and of the end of its last one
    row     indices of the houses that stand on it
    free    False if buildings stand in the way
    """

    local_from_street: Rigid3
    width: float
    span: tuple[float, float]
    row: tuple[int, ...]
    free: bool


@dataclass(frozen=True)
class _Front:
    """A facade that a street may run along; `weight` is its length (m), with blank walls counted in part."""

    house: int
    frame: Rigid3
    width: float
    weight: float


def find_site(drafts: Sequence[ModelDraft]) -> Site:
    """Return the street with the greatest length of facades on it; `free` is False if none has room."""
    fronts = sorted(_fronts(drafts), key=lambda f: -f.weight)
    best: tuple[float, Site] | None = None
    for front in fronts[:_TRIED]:
        for alone in (False, True):
            weight, site = _street_along(drafts, fronts, front, alone)
            if site.free and (best is None or weight > best[0] + 1e-9):
                best = (weight, site)
    return best[1] if best else _street_along(drafts, fronts, fronts[0], True)[1]


def _fronts(drafts: Sequence[ModelDraft]) -> Iterator[_Front]:
    for k, draft in enumerate(drafts):
        for facade in draft.facades:
            rings = [facade.outline, *(o.ring for o in facade.openings)]  # bays may part the outline
            width = float(np.ptp(np.concatenate(rings)[:, 0]))
            opened = min(_BAY_M * len(facade.openings), width)
            yield _Front(k, draft.frame(facade), width, opened + _BLANK_WEIGHT * (width - opened))


def _street_along(
    drafts: Sequence[ModelDraft], fronts: Sequence[_Front], front: _Front, alone: bool
) -> tuple[float, Site]:
    """Lays a street along one facade, and returns the weight of all facades on it with its site."""
    x = front.frame.R[:, 0]
    up = np.array([0.0, 0.0, 1.0])
    R = np.column_stack([x, np.cross(up, x), up])
    frame = Rigid3("local", "street", R, np.array([*front.frame.t[:2], drafts[front.house].base]))
    row, weight = _row(fronts, front, frame, alone)
    ends = [in_plan(drafts[k].footprint, frame) for k in row]
    s0, s1 = min(e.bounds[0] for e in ends), max(e.bounds[2] for e in ends)
    front_d = min(d for f in fronts if f.house in row and _faces(f, frame) for d in _depths(f, frame))
    frame = Rigid3("local", "street", R, frame.apply(np.array([[s0, min(front_d, 0.0), 0.0]]))[0])
    span = (0.0, s1 - s0)
    built = shapely.union_all([in_plan(d.footprint, frame) for d in drafts])
    shapely.prepare(built)
    for width in _WIDTHS_M:
        strip = shapely.box(span[0] - _ENDS_M, -width + _OVERHANG_M, span[1] + _ENDS_M, -_OVERHANG_M - 0.2)
        if built.intersection(strip).area < 0.01 * strip.area:
            return weight, Site(frame, width, span, row, True)
    return weight, Site(frame, _WIDTHS_M[-1], span, row, False)


def _row(
    fronts: Sequence[_Front], front: _Front, frame: Rigid3, alone: bool
) -> tuple[tuple[int, ...], float]:
    """Returns the houses on the street along `front` (only its own house if `alone`), and their weight."""
    found: set[int] = set()
    weight = 0.0
    for f in fronts:
        depth = _depths(f, frame)
        if (f.house == front.house or not alone) and _faces(f, frame) and abs(depth).max() < _ROW_M:
            found.add(f.house)
            weight += f.weight
    return tuple(sorted(found | {front.house})), weight


def _faces(front: _Front, frame: Rigid3) -> bool:
    return bool(front.frame.R[:, 1] @ frame.R[:, 1] > _FACING_COS)


def _depths(front: _Front, frame: Rigid3) -> Float:
    """Returns d (2,) m of a facade's ends."""
    ends = front.frame.apply(np.array([[0.0, 0.0, 0.0], [front.width, 0.0, 0.0]]))
    return np.asarray(frame.inverse.apply(ends)[:, 1])


def site_plan(draft: ModelDraft, site: Site) -> shapely.Geometry:
    """Return a building's footprint in the street's (s, d)."""
    return in_plan(draft.footprint, site.local_from_street)
