"""Numbers the openings of a building by floor and bay: "B07/F1/W3-2" is the second one of the third floor."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.catalog.bays import find_bays
from frontage.catalog.storeys import Storeys, find_storeys
from frontage.geometry.arrays import Bool, Float, Int
from frontage.model import Elements, Facade, Opening, OpeningKind

_BASEMENT_HEAD_M = 1.6  # above the ground: basement windows end below it


def number_facade(
    facade: str, openings: Sequence[Opening], ground_z: float | None = None
) -> tuple[Opening, ...]:
    """Returns the openings of one facade with id, floor and bay, sorted by floor and from the left.

    facade    id of the facade, such as "B07/F1"
    ground_z  m, height of the ground at the wall in the facade frame; None = not known

    The number in the id counts all openings of a floor from the left as seen from the street; `bay` is the
    column over all floors. The ground floor is 0; basement windows are on floor -1.
    """
    boxes = _boxes(openings)
    storeys = _storeys(boxes, np.zeros(len(boxes), np.int64), openings, ground_z)
    return _named(facade, openings, boxes, _floors(openings, boxes, storeys))


def number_building(
    facades: Sequence[Facade], elements: Sequence[Elements], ground_z: float | None = None
) -> tuple[Elements, ...]:
    """Numbers the openings of all facades of a building, with floors that agree between the facades.

    `elements` belong to the `facades` one by one. `ground_z` is the height of the ground at the foot of the
    building (m, local); None or NaN = not known. A facade gets storeys of its own (a split level) when the
    common floor lines cut its rows of openings and its own would not.
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
    """Bounding boxes (n, 4) m of the openings: x0, z0, x1, z1."""
    corners = [np.concatenate([o.ring.min(0), o.ring.max(0)]) for o in openings]
    return np.array(corners, np.float64).reshape(-1, 4)


def _upright(boxes: Float, facade: Facade) -> Float:
    """Boxes with local heights instead of z of the facade frame."""
    high = boxes.copy()
    high[:, 1::2] = facade.frame.t[2] + facade.frame.R[2, 2] * boxes[:, 1::2]
    return high


def _storeys(boxes: Float, sheet: Int, openings: Sequence[Opening], ground: float | None) -> Storeys:
    """Finds the storeys from all openings but basement windows; `sheet` (n,) numbers their facades."""
    main = ~_cellar(openings, boxes, sheet)
    low = np.array([o.kind.at_ground for o in openings], bool)
    if ground is None:
        ground = _guessed_ground(boxes[main], low[main])
    elif low.any():
        # A door below the given height of the ground means that the ground slopes.
        ground = max(min(ground, float(boxes[low, 1].min())), ground - 1.5)
    return find_storeys(boxes[main], sheet[main], ground)


def _guessed_ground(boxes: Float, low: Float) -> float:
    """Guesses the height of the ground: the foot of the lowest door, or a parapet below the lowest window."""
    if not len(boxes):
        return 0.0
    k = int(np.argmin(boxes[:, 1]))
    return float(boxes[k, 1] - (0.0 if low[k] or np.ptp(boxes[k, 1::2]) > 2.0 else 0.9))


def _fitting(common: Storeys, boxes: Float, openings: Sequence[Opening], ground: float | None) -> Storeys:
    """Returns the common storeys, or those of the facade where the common lines cut many of its openings."""
    cut = int(common.crossed(boxes).sum())
    if cut <= 0.25 * len(boxes):
        return common
    own = _storeys(boxes, np.zeros(len(boxes), np.int64), openings, ground)
    return own if 2 * int(own.crossed(boxes).sum()) < cut else common


def _floors(openings: Sequence[Opening], boxes: Float, storeys: Storeys) -> Int:
    """Floor (n,) of every opening: that of its middle, or of its foot if it is higher than a storey."""
    foot, head = boxes[:, 1], boxes[:, 3]
    tall = head - foot > 1.2 * storeys.pitch
    floor = storeys.floor_of(np.where(tall, foot + 0.5, (foot + head) / 2))
    cellar = _cellar(openings, boxes, np.zeros(len(boxes), np.int64))
    return np.where(cellar & (floor == 0) & (head < storeys.lines[0] + _BASEMENT_HEAD_M), -1, floor)


def _cellar(openings: Sequence[Opening], boxes: Float, sheet: Int) -> Bool:
    """Which openings (n,) are basement windows: by kind, or small and less than a storey below a window."""
    named = np.array([o.kind is OpeningKind.BASEMENT for o in openings], bool)
    middle, foot = boxes[:, ::2].mean(1), boxes[:, 1]
    rise = boxes[:, 1::2].mean(1) - boxes[:, 1::2].mean(1)[:, None]
    over = (np.abs(middle[:, None] - middle) < np.ptp(boxes[:, ::2], axis=1) / 2) & (sheet[:, None] == sheet)
    over &= (foot > boxes[:, 3, None]) & (rise < _BASEMENT_HEAD_M + 0.8)
    lowest = ~over.any(0)
    cellar: Bool = named | (over.any(1) & lowest & (np.ptp(boxes[:, 1::2], axis=1) < 0.9))
    return cellar


def _named(facade: str, openings: Sequence[Opening], boxes: Float, floors: Int) -> tuple[Opening, ...]:
    """Returns the openings with their ids, sorted by floor and from the left."""
    bays = find_bays(boxes, floors)
    order = np.lexsort((boxes[:, 1], boxes[:, 0] + boxes[:, 2], floors))
    named, count = [], dict[int, int]()
    for k in order:
        o, floor = openings[k], int(floors[k])
        count[floor] = count.get(floor, 0) + 1
        name = f"{facade}/{o.kind.letter}{floor}-{count[floor]}"
        named.append(replace(o, id=name, floor=floor, bay=int(bays[k])))
    return tuple(named)
