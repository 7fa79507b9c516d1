"""Floor, bay and id of every opening of a building: "B07/F1/W3-2" = third floor, second from the left."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.catalog.bays import find_bays
from frontage.catalog.storeys import Storeys, find_storeys
from frontage.geometry.arrays import Bool, Float, Int
from frontage.model import Elements, Facade, Opening, OpeningKind

_HEAD = 1.6  # m above the ground: where basement windows end


def numbered(facade: str, openings: Sequence[Opening], ground_z: float | None = None) -> tuple[Opening, ...]:
    """The openings of one facade with id, floor and bay, floor by floor and from the left.

    facade    "B07/F1"; ground_z m, height of the ground at the wall in the facade's frame, None = not known.
    The number in the id counts all openings of the floor from the left as seen from the street; `bay` is the
    column over all floors. The ground floor is 0, basement windows are on floor -1.
    """
    boxes = _boxes(openings)
    storeys = _storeys(boxes, np.zeros(len(boxes), np.int64), openings, ground_z)
    return _named(facade, openings, boxes, _floors(openings, boxes, storeys))


def number_building(
    facades: Sequence[Facade], elements: Sequence[Elements], ground_z: float | None = None
) -> tuple[Elements, ...]:
    """The elements of a building's facades with their openings numbered; floors agree between the facades.

    ground_z is the height of the ground at its foot (m, local), None or NaN = not known. A facade whose rows
    the common floor lines cut, while its own would not, has storeys of its own (a split level).
    """
    ground = None if ground_z is None or not np.isfinite(ground_z) else float(ground_z)
    own = [_boxes(e.openings) for e in elements]
    up = [_upright(b, f) for b, f in zip(own, facades, strict=True)]
    sheet = np.repeat(np.arange(len(up)), [len(b) for b in up])
    everything = [o for e in elements for o in e.openings]
    common = _storeys(np.concatenate([np.empty((0, 4)), *up]), sheet, everything, ground)
    found = []
    for facade, e, boxes, high in zip(facades, elements, own, up, strict=True):
        floors = _floors(e.openings, high, _fitting(common, high, e.openings, ground))
        found.append(replace(e, openings=_named(facade.id, e.openings, boxes, floors)))
    return tuple(found)


def _boxes(openings: Sequence[Opening]) -> Float:
    """(n, 4) m: x0, z0, x1, z1."""
    corners = [np.concatenate([o.ring.min(0), o.ring.max(0)]) for o in openings]
    return np.array(corners, np.float64).reshape(-1, 4)


def _upright(boxes: Float, facade: Facade) -> Float:
    """Boxes with local heights instead of the facade's z."""
    high = boxes.copy()
    high[:, 1::2] = facade.frame.t[2] + facade.frame.R[2, 2] * boxes[:, 1::2]
    return high


def _storeys(boxes: Float, sheet: Int, openings: Sequence[Opening], ground: float | None) -> Storeys:
    main = ~_cellar(openings, boxes, sheet)
    low = np.array([o.kind.at_ground for o in openings], bool)
    if ground is None:
        ground = _guessed_ground(boxes[main], low[main])
    elif low.any():
        # A door a step below the height that the ground was given: the ground slopes.
        ground = max(min(ground, float(boxes[low, 1].min())), ground - 1.5)
    return find_storeys(boxes[main], sheet[main], ground)


def _guessed_ground(boxes: Float, low: Float) -> float:
    """The ground (m) under openings: the foot of the lowest door, or a parapet below the lowest window."""
    if not len(boxes):
        return 0.0
    k = int(np.argmin(boxes[:, 1]))
    return float(boxes[k, 1] - (0.0 if low[k] or np.ptp(boxes[k, 1::2]) > 2.0 else 0.9))


def _fitting(common: Storeys, boxes: Float, openings: Sequence[Opening], ground: float | None) -> Storeys:
    """The common storeys, or the facade's own where the common lines cut many of its openings."""
    cut = int(common.crossed(boxes).sum())
    if cut <= 0.25 * len(boxes):
        return common
    own = _storeys(boxes, np.zeros(len(boxes), np.int64), openings, ground)
    return own if 2 * int(own.crossed(boxes).sum()) < cut else common


def _floors(openings: Sequence[Opening], boxes: Float, storeys: Storeys) -> Int:
    """Floor (n,) of every opening: where its middle lies, of one higher than a storey where it begins."""
    foot, head = boxes[:, 1], boxes[:, 3]
    tall = head - foot > 1.2 * storeys.pitch
    floor = storeys.floor_of(np.where(tall, foot + 0.5, (foot + head) / 2))
    cellar = _cellar(openings, boxes, np.zeros(len(boxes), np.int64))
    return np.where(cellar & (floor == 0) & (head < storeys.lines[0] + _HEAD), -1, floor)


def _cellar(openings: Sequence[Opening], boxes: Float, sheet: Int) -> Bool:
    """Which openings are basement windows (n,): by kind, or small and less than a storey below a window."""
    named = np.array([o.kind is OpeningKind.BASEMENT for o in openings], bool)
    middle, foot = boxes[:, ::2].mean(1), boxes[:, 1]
    rise = boxes[:, 1::2].mean(1) - boxes[:, 1::2].mean(1)[:, None]
    over = (np.abs(middle[:, None] - middle) < np.ptp(boxes[:, ::2], axis=1) / 2) & (sheet[:, None] == sheet)
    over &= (foot > boxes[:, 3, None]) & (rise < _HEAD + 0.8)
    lowest = ~over.any(0)
    cellar: Bool = named | (over.any(1) & lowest & (np.ptp(boxes[:, 1::2], axis=1) < 0.9))
    return cellar


def _named(facade: str, openings: Sequence[Opening], boxes: Float, floors: Int) -> tuple[Opening, ...]:
    """With ids, sorted by floor and from the left."""
    bays = find_bays(boxes, floors)
    order = np.lexsort((boxes[:, 1], boxes[:, 0] + boxes[:, 2], floors))
    named, count = [], dict[int, int]()
    for k in order:
        o, floor = openings[k], int(floors[k])
        count[floor] = count.get(floor, 0) + 1
        name = f"{facade}/{o.kind.letter}{floor}-{count[floor]}"
        named.append(replace(o, id=name, floor=floor, bay=int(bays[k])))
    return tuple(named)
