"""Fronts in many styles. Every style is drawn anew from a random generator: sizes, numbers and depths."""

from collections.abc import Callable

import numpy as np

from _bentstyles import awnings, bowed, concrete, corner, crescent, fins, leaning, palazzo
from _drawn import Drawing

Style = Callable[[Drawing, np.random.Generator], None]


def _spread(count: int, width: float, length: float) -> list[float]:
    """Return where `count` openings of a width begin, evenly along a wall of some length."""
    pitch = length / count
    return [pitch * (k + 0.5) - width / 2.0 for k in range(count)]


def _rows(
    d: Drawing, x: list[float], z: list[float], width: float, height: float, **about: float | str
) -> None:
    """Draw windows in columns that begin at x and rows that begin at z."""
    for low in z:
        for left in x:
            d.window(left, left + width, low, low + height, **about)  # type: ignore[arg-type]


def sparse(d: Drawing, rng: np.random.Generator) -> None:
    """Few windows of different sizes, a string course and a door aside."""
    length, storeys = rng.uniform(14, 22), int(rng.integers(3, 5))
    high = 3.1 * storeys + 0.6
    d.house(0, length, 0, 9, 0, high)
    d.add(-0.05, length + 0.05, -0.12, 0, 3.2, 3.4)
    d.add(-0.2, length + 0.2, -0.35, 0, high - 0.25, high)
    for storey in range(storeys):
        for x in _spread(int(rng.integers(2, 4)), 1.1, length - 3.0):
            w, h = rng.uniform(0.5, 1.3), rng.uniform(0.6, 1.7)
            d.window(x + 2.4, x + 2.4 + w, 3.1 * storey + 1.0, 3.1 * storey + 1.0 + h, depth=0.18)
    d.door(0.7, 1.75, 2.2, depth=0.25)


def colonnade(d: Drawing, rng: np.random.Generator) -> None:
    """Square columns on a podium before a wall of tall windows, under an entablature."""
    count, bay, high = int(rng.integers(4, 7)), rng.uniform(2.8, 3.6), rng.uniform(6.5, 8.5)
    length, deep, podium, side = count * bay + 0.9, rng.uniform(1.2, 2.8), rng.uniform(0.4, 1.1), 0.7
    d.house(0, length, deep, deep + 10, 0, high + 2.2)
    d.add(0, length, 0, deep, high, high + 2.2)
    d.add(0, length, -0.3, deep, 0, podium)
    for k in range(count + 1):
        d.add(0.1 + k * bay, 0.1 + k * bay + side, 0.1, 0.1 + side, podium, high)
    for k in range(count):
        x, width = 0.8 + k * bay + (bay - 0.7) / 2.0, rng.uniform(1.4, 1.8)
        if k == count // 2:
            d.door(x - 0.9, x + 0.9, podium + 3.4, y=deep, depth=0.3, z0=podium)
        else:
            d.window(x - width / 2, x + width / 2, podium + 0.9, high - 1.2, y=deep, depth=0.25)


def arcade(d: Drawing, rng: np.random.Generator) -> None:
    """Storeys over an arcade with doors and shop windows in its back wall."""
    count, bay, storeys = int(rng.integers(4, 6)), rng.uniform(3.2, 3.9), int(rng.integers(2, 4))
    length, deep, pier = count * bay, rng.uniform(1.8, 3.2), rng.uniform(0.5, 0.8)
    d.house(0, length, 0, 10, 0, 4.0 + 3.1 * storeys)
    for k in range(count):
        d.cut(k * bay + pier / 2, (k + 1) * bay - pier / 2, 0, deep, 0, 3.1)
    d.cut(pier / 2, length - pier / 2, 0.6, deep, 0, 3.1)
    for k in range(count):
        if k % 2:
            d.door(k * bay + 1.2, k * bay + 2.3, 2.3, y=deep, depth=0.15)
        else:
            d.window(k * bay + 0.6, k * bay + bay - 0.6, 0.7, 2.6, y=deep, depth=0.12)
    _rows(d, _spread(count, 1.2, length), [4.9 + 3.1 * s for s in range(storeys)], 1.2, 1.6, depth=0.2)


def pilasters(d: Drawing, rng: np.random.Generator) -> None:
    """Pilasters from plinth to cornice, windows with round heads between them, sunk panels below some."""
    count, bay = int(rng.integers(4, 7)), rng.uniform(2.6, 3.4)
    length, out, high = count * bay + 0.6, rng.uniform(0.08, 0.25), 10.2
    d.house(0, length, 0, 10, 0, high + 1.0)
    d.add(0, length, -out - 0.08, 0, 0, 0.9)
    d.add(-0.1, length + 0.1, -out - 0.15, 0, high - 0.5, high)
    for k in range(count + 1):
        d.add(k * bay, k * bay + 0.6, -out, 0, 0.9, high - 0.5)
    panel = rng.uniform(0.04, 0.08)
    for k in range(count):
        x = 0.6 + k * bay + (bay - 0.6 - 1.3) / 2
        d.window(x, x + 1.3, 1.7, 4.1, depth=0.2, head="round")
        d.cut(x, x + 1.3, 0, panel, 4.9, 5.8)
        d.window(x, x + 1.3, 6.0, 8.6, depth=0.2)


def shops(d: Drawing, rng: np.random.Generator) -> None:
    """Shop fronts between pilasters under a fascia, with recessed doors, and windows above."""
    units, wide = int(rng.integers(2, 4)), rng.uniform(5.0, 6.5)
    length, set_back = units * wide, rng.uniform(0.05, 0.3)
    d.house(0, length, 0, 10, 0, 10.2)
    d.add(0, length, -0.25, 0, 3.1, 3.8)
    for k in range(units + 1):
        d.add(max(0, k * wide - 0.25), min(length, k * wide + 0.25), -0.15, 0, 0, 3.1)
    for k in range(units):
        x = k * wide + 0.5
        d.window(x, x + wide - 2.4, 0.5, 2.9, depth=set_back)
        d.door(x + wide - 2.2, x + wide - 1.1, 2.6, depth=set_back + 0.1)
    _rows(d, _spread(units * 2, 1.2, length), [4.8, 7.7], 1.2, 1.6, depth=0.12)


def rear(d: Drawing, rng: np.random.Generator) -> None:
    """A rear front: a stair tower, small bathroom windows, balconies, down pipes."""
    high, storeys = 12.8, 4
    length, tower = rng.uniform(13, 17), rng.uniform(5, 7)
    d.house(0, length, 0, 9, 0, high)
    d.house(tower, tower + 3.0, -1.2, 0, 0, high - 1.0)
    for s in range(storeys):
        z = 3.0 * s + 1.0
        d.window(1.0, 1.0 + rng.uniform(1.0, 1.6), z, z + 1.3, depth=0.12)
        d.window(3.6, 4.1, z + 0.6, z + 1.3, depth=0.12)
        d.window(tower + 1.0, tower + 2.0, z + 0.9 if s else z + 1.6, z + 2.2, y=-1.2, depth=0.1)
        x = tower + 4.4
        if s:
            d.add(x - 0.5, x + 3.0, -1.3, 0, z - 1.15, z - 1.0)
            d.add(x - 0.5, x + 3.0, -1.3, -1.2, z - 1.0, z - 0.05)
            d.window(x, x + 2.2, z - 0.9, z + 1.3, depth=0.15)
        else:
            d.window(x, x + 2.2, z, z + 1.3, depth=0.15)
    d.door(1.2, 2.2, 2.1 - 1.25, depth=0.2)
    for x in (0.25, length - 0.4):
        d.add(x, x + 0.1, -0.12, -0.02, 0, high)


def court(d: Drawing, rng: np.random.Generator) -> None:
    """A narrow court: a front between two wings that have windows towards it."""
    wide, wing = rng.uniform(5, 8), rng.uniform(3.0, 5.0)
    d.house(0, wide + 8, 0, 8, 0, 12.5)
    d.house(0, 4, -wing, 0, 0, 12.5)
    d.house(wide + 4, wide + 8, -wing, 0, 0, 12.5)
    for s in range(4):
        z = 3.0 * s + 1.0
        for x in _spread(2, 1.1, wide):
            d.window(4 + x, 4 + x + 1.1, z, z + 1.5, depth=0.14)
        for x, sign in ((4.0, 1), (wide + 4.0, -1)):
            d.side_window(-wing + 0.8, -wing + 1.6, z, z + 1.4, x, sign, depth=0.14)
        for x in (1.4, wide + 5.4):
            d.window(x, x + 1.2, z, z + 1.5, y=-wing, depth=0.14)


def loggias(d: Drawing, rng: np.random.Generator) -> None:
    """Flats with loggias: a window and a glazed door in a wall set back behind a parapet."""
    units, deep = int(rng.integers(2, 4)), rng.uniform(1.2, 1.8)
    length = units * 7.0
    d.house(0, length, 0, 10, 0, 12.4)
    for s in range(4):
        z = 3.0 * s
        for k in range(units):
            x = 7.0 * k
            d.window(x + 0.7, x + 1.9, z + 0.9, z + 2.3, depth=0.12)
            if s:
                d.cut(x + 2.8, x + 6.4, 0, deep, z + 1.0, z + 2.6)
                d.cut(x + 2.8, x + 6.4, 0.12, deep, z + 0.1, z + 1.0)
                d.window(x + 3.1, x + 4.7, z + 0.9, z + 2.4, y=deep, depth=0.1)
                d.window(x + 5.2, x + 6.1, z + 0.12, z + 2.4, y=deep, depth=0.1)
            else:
                d.window(x + 3.6, x + 5.6, z + 0.9, z + 2.3, depth=0.12)


def bays(d: Drawing, rng: np.random.Generator) -> None:
    """Square bays over two storeys, with windows in their sides, beside doors."""
    units, out = int(rng.integers(2, 4)), rng.uniform(0.6, 1.0)
    length = units * 6.0
    d.house(0, length, 0, 9, 0, 8.8)
    for k in range(units):
        x = 6.0 * k
        d.house(x + 2.6, x + 5.2, -out, 0, 0, 5.9)
        for z in (0.9, 3.7):
            d.window(x + 3.0, x + 4.8, z, z + 1.5, y=-out, depth=0.1)
            for place, sign in ((x + 2.6, -1), (x + 5.2, 1)):
                d.side_window(-out + 0.12, -0.12, z, z + 1.5, place, sign, depth=0.08)
        d.door(x + 0.8, x + 1.8, 2.2, depth=0.2)
        d.window(x + 0.75, x + 1.85, 3.8, 5.2, depth=0.12)
        d.window(x + 3.3, x + 4.5, 6.6, 7.9, depth=0.12)


def curtain(d: Drawing, rng: np.random.Generator) -> None:
    """A curtain wall: panes and spandrels between mullions from the ground to the roof."""
    count, pitch, storeys = int(rng.integers(6, 10)), rng.uniform(1.4, 2.0), 4
    mullion, out = rng.uniform(0.08, 0.14), rng.uniform(0.05, 0.15)
    d.house(0, count * pitch + mullion, 0, 10, 0, 3.4 * storeys + 0.5)
    for k in range(count + 1):
        d.add(k * pitch, k * pitch + mullion, -out, 0, 0, 3.4 * storeys)
    x = [k * pitch + mullion + 0.03 for k in range(count)]
    _rows(d, x, [3.4 * s + 0.9 for s in range(storeys)], pitch - mullion - 0.06, 2.2, depth=0.06)


def ribbons(d: Drawing, rng: np.random.Generator) -> None:
    """Ribbon windows from end to end, parted by posts, over a set-back ground floor of glass."""
    count, pitch, storeys = int(rng.integers(6, 9)), rng.uniform(1.8, 2.4), int(rng.integers(3, 5))
    length, back = count * pitch + 0.6, rng.uniform(0.8, 1.6)
    d.house(0, length, 0, 11, 0, 3.6 + 3.3 * storeys + 0.6)
    d.cut(0, length, 0, back, 0, 3.2)
    for k in range(0, count, 2):
        d.add(0.3 + k * pitch, 0.65 + k * pitch, 0.1, 0.45, 0, 3.2)
    for k in range(count):
        x = 0.3 + k * pitch
        d.window(x + 0.08, x + pitch - 0.08, 0.4, 2.8, y=back, depth=0.1)
        for s in range(storeys):
            d.window(x + 0.1, x + pitch - 0.1, 4.5 + 3.3 * s, 6.1 + 3.3 * s, depth=0.1)


def garages(d: Drawing, rng: np.random.Generator) -> None:
    """A row of garages under flats."""
    count, depth = int(rng.integers(4, 7)), rng.uniform(0.08, 0.25)
    length = count * 3.0
    d.house(0, length, 0, 9, 0, 8.9)
    for k in range(count):
        d.door(3.0 * k + 0.3, 3.0 * k + 2.7, 2.25, depth=depth)
    _rows(d, _spread(count, 1.5, length), [3.9, 6.7], 1.5, 1.3, depth=0.12)


def warehouse(d: Drawing, rng: np.random.Generator) -> None:
    """A warehouse: loading doors one above another, small windows with segmental bands, buttresses."""
    count, bay = int(rng.integers(4, 7)), rng.uniform(3.0, 3.6)
    length = count * bay
    d.house(0, length, 0, 12, 0, 14.2)
    for k in range(count + 1):
        d.add(max(0.0, k * bay - 0.25), min(length, k * bay + 0.25), -0.2, 0, 0, 13.4)
    doors = int(rng.integers(0, count))
    for s in range(4):
        for k in range(count):
            x = k * bay + bay / 2
            if k == doors:
                d.door(x - 0.7, x + 0.7, 3.4 * s + 2.6, depth=0.3, z0=3.4 * s + (0.0 if s == 0 else 0.35))
            else:
                d.window(x - 0.55, x + 0.55, 3.4 * s + 1.2, 3.4 * s + 2.6, depth=0.3, head="round")


def pairs(d: Drawing, rng: np.random.Generator) -> None:
    """Windows in pairs and threes with narrow piers between them."""
    groups, pier = int(rng.integers(3, 5)), rng.uniform(0.12, 0.3)
    length = groups * 4.4
    d.house(0, length, 0, 9, 0, 12.2)
    for s in range(4):
        for g in range(groups):
            number, width = (2, 1.0) if (g + s) % 2 else (3, 0.75)
            x = 4.4 * g + 2.2 - (number * width + (number - 1) * pier) / 2
            for k in range(number):
                left = x + k * (width + pier)
                d.window(left, left + width, 3.0 * s + 0.9, 3.0 * s + 2.3, depth=0.15)


def wings(d: Drawing, rng: np.random.Generator) -> None:
    """A front with wings and a middle part that stand out, a base, and a portal up some steps."""
    out, middle = rng.uniform(0.5, 1.8), rng.uniform(0.3, 1.0)
    d.house(0, 26, 0, 10, 0, 12.0)
    d.house(0, 5, -out, 0, 0, 12.0)
    d.house(21, 26, -out, 0, 0, 12.0)
    d.house(10, 16, -middle, 0, 0, 13.2)
    d.add(11.8, 14.2, -middle - 1.0, -middle, 0, 0.5)
    for z, height in ((1.4, 2.0), (5.0, 2.3), (9.0, 1.5)):
        for x in (1.9, 22.9):
            d.window(x, x + 1.2, z, z + height, y=-out, depth=0.22)
        for x in (5.8, 8.0, 17.0, 19.2):
            d.window(x, x + 1.2, z, z + height, depth=0.22)
        for x in (10.5, 14.5) if z < 2 else (10.7, 12.5, 14.2):
            d.window(x, x + 1.0, z, z + height, y=-middle, depth=0.22)
    d.door(12.2, 13.8, 3.4, y=-middle, depth=0.4, z0=0.5)


def gothic(d: Drawing, rng: np.random.Generator) -> None:
    """Tall pointed windows between stepped buttresses, a low aisle door."""
    count, bay = int(rng.integers(3, 6)), rng.uniform(3.8, 4.8)
    length, wide = count * bay, rng.uniform(1.2, 1.9)
    d.house(0, length, 0, 10, 0, 12.5)
    for k in range(count + 1):
        x0, x1 = max(0.0, k * bay - 0.35), min(length, k * bay + 0.35)
        d.add(x0, x1, -1.1, 0, 0, 5.0)
        d.add(x0, x1, -0.6, 0, 5.0, 10.0)
    for k in range(count):
        x = (k + 0.5) * bay
        if k == 1:
            d.door(x - 0.8, x + 0.8, 2.6, depth=0.35)
            d.window(x - wide / 2, x + wide / 2, 4.4, 10.2, depth=0.35, head="pointed")
        else:
            d.window(x - wide / 2, x + wide / 2, 3.0, 10.2, depth=0.35, head="pointed")


def galleries(d: Drawing, rng: np.random.Generator) -> None:
    """Access balconies along the whole front, with a door and a window for each flat behind them."""
    units = int(rng.integers(3, 5))
    length, out = units * 5.5, rng.uniform(1.1, 1.5)
    d.house(0, length, 0, 9, 0, 11.6)
    for s in range(4):
        z = 2.9 * s
        if s:
            d.add(0, length, -out, 0, z - 0.2, z)
            d.add(0, length, -out, -out + 0.12, z, z + 0.9)
        for k in range(units):
            x = 5.5 * k
            d.door(x + 0.6, x + 1.5, z + 2.05, depth=0.1, z0=z)
            d.window(x + 2.3, x + 4.3, z + 1.0, z + 2.3, depth=0.1)


def setback(d: Drawing, rng: np.random.Generator) -> None:
    """An attic storey set back behind a parapet, an entrance recess, and corner windows."""
    back, recess, length = rng.uniform(1.5, 2.5), rng.uniform(0.9, 1.6), rng.uniform(14, 18)
    d.house(0, length, 0, 10, 0, 9.8)
    d.house(1.0, length - 1.0, back, 10, 9.8, 12.6)
    d.cut(5.0, 8.6, 0, recess, 0, 2.7)
    d.door(5.3, 6.5, 2.3, y=recess, depth=0.12)
    d.window(6.8, 8.3, 0.9, 2.3, y=recess, depth=0.12)
    d.window(1.2, 3.6, 0.9, 2.4, depth=0.14)
    _rows(d, [length - 4.2], [0.9], 2.4, 1.5, depth=0.14)
    _rows(d, _spread(4, 1.8, length), [4.0, 7.0], 1.8, 1.6, depth=0.14)
    _rows(d, [1.0 + x for x in _spread(3, 2.2, length - 2.0)], [10.3], 2.2, 1.9, y=back, depth=0.1)


def school(d: Drawing, rng: np.random.Generator) -> None:
    """Wide class room windows close together, with sunk panels below, and a tall stair window."""
    count, wide, panel = int(rng.integers(3, 6)), rng.uniform(2.4, 3.2), rng.uniform(0.03, 0.07)
    length = count * (wide + 0.5) + 3.6
    d.house(0, length, 0, 10, 0, 11.4)
    for s in range(3):
        z = 3.6 * s + 1.1
        for k in range(count):
            x = 0.4 + k * (wide + 0.5)
            d.cut(x, x + wide, 0, panel, z - 0.9, z - 0.1)
            d.window(x, x + wide, z, z + 2.0, depth=0.2)
    d.window(length - 2.6, length - 1.2, 3.4, 10.2, depth=0.2)
    d.door(length - 2.8, length - 1.0, 2.5, depth=0.3)


def dormers(d: Drawing, rng: np.random.Generator) -> None:
    """Wall dormers over the eaves."""
    count, pitch = int(rng.integers(3, 6)), rng.uniform(3.0, 3.8)
    length = count * pitch
    d.house(0, length, 0, 9, 0, 6.4)
    d.house(0, length, 1.6, 9, 6.4, 8.6)
    for k in range(count):
        x = (k + 0.5) * pitch
        d.house(x - 1.0, x + 1.0, 0, 1.6, 6.4, 8.4)
        d.window(x - 0.55, x + 0.55, 6.7, 8.0, depth=0.14)
        for z in (0.9, 3.9):
            if k == 0 and z < 1:
                d.door(x - 0.6, x + 0.6, 2.3, depth=0.2)
                continue
            d.window(x - 0.55, x + 0.55, z, z + 1.5, depth=0.14)


STYLES: dict[str, Style] = {
    f.__name__: f
    for f in (
        sparse, colonnade, arcade, pilasters, shops, rear, court, loggias, bays, curtain, ribbons, garages,
        warehouse, pairs, wings, gothic, galleries, setback, school, dormers,
        crescent, bowed, corner, leaning, palazzo, fins, concrete, awnings,
    )
}  # fmt: skip
