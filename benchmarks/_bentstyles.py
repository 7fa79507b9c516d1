"""More styles of fronts: those that bend in plan or lean, and those with much before their walls."""

import numpy as np

from _drawn import Drawing


def crescent(d: Drawing, rng: np.random.Generator) -> None:
    """A terrace along a bend: each bay turns a few degrees, to the street or away from it."""
    count, bay, storeys = int(rng.integers(6, 10)), rng.uniform(2.6, 3.4), int(rng.integers(3, 5))
    length, turn = count * bay, rng.uniform(2.0, 5.0) * rng.choice([-1.0, 1.0])
    d.bends += [(k * bay, turn) for k in range(1, count)]
    high = 3.2 * storeys + 0.7
    d.house(0, length, 0, 8, 0, high)
    d.add(0, length, -0.1, 0, 3.3, 3.55)
    d.add(0, length, -0.3, 0, high - 0.35, high)
    for k in range(count):
        x = (k + 0.5) * bay
        for s in range(storeys):
            if s == 0 and k % 3 == 1:
                d.door(x - 0.55, x + 0.55, 2.4, depth=0.2)
            else:
                d.window(x - 0.55, x + 0.55, 3.2 * s + 1.0, 3.2 * s + 2.7, depth=0.16)


def bowed(d: Drawing, rng: np.random.Generator) -> None:
    """Houses with bowed fronts: five flat strips of wall with windows in three of them, doors beside."""
    houses, strip, turn = int(rng.integers(2, 4)), rng.uniform(1.0, 1.3), rng.uniform(9.0, 15.0)
    flat, storeys = 2.6, int(rng.integers(3, 5))
    wide = flat + 5 * strip
    high = 3.3 * storeys + 0.9
    d.house(0, houses * wide, 0, 7, 0, high)
    d.add(0, houses * wide, -0.25, 0, high - 0.4, high)
    for h in range(houses):
        x = h * wide + flat
        d.bends += [
            (x, -2.0 * turn),
            *((x + k * strip, turn) for k in range(1, 5)),
            (x + 5 * strip, -2.0 * turn),
        ]
        for s in range(storeys):
            z = 3.3 * s + 1.1
            for k in (0, 2, 4):
                left = x + k * strip + 0.15
                d.window(left, left + strip - 0.3, z, z + 1.8, depth=0.12)
            if s == 0:
                d.door(x - 1.8, x - 0.8, 2.6, depth=0.25)
            else:
                d.window(x - 1.8, x - 0.8, z, z + 1.8, depth=0.12)
    d.bends = [b for b in d.bends if b[0] < houses * wide - 0.01]


def corner(d: Drawing, rng: np.random.Generator) -> None:
    """A corner house with a chamfered corner: a door in it, shop windows beside, flats above."""
    side, cut, storeys = rng.uniform(9, 12), rng.uniform(3.0, 4.5), int(rng.integers(3, 5))
    d.bends += [(side, 45.0), (side + cut, 45.0)]
    length, high = 2 * side + cut, 4.1 + 3.1 * storeys
    d.house(0, length, 0, 3.5, 0, high)
    d.add(0, length, -0.2, 0, 3.4, 3.8)
    middle = side + cut / 2
    d.door(middle - 0.8, middle + 0.8, 2.7, depth=0.3)
    for k in range(3):
        for x in (0.5 + k * (side - 0.4) / 3, side + cut + 0.4 + k * (side - 0.4) / 3):
            wide = (side - 0.4) / 3 - 0.5
            d.window(x, x + wide, 0.6, 2.9, depth=0.12)
            for s in range(storeys):
                d.window(x + wide / 2 - 0.6, x + wide / 2 + 0.6, 4.9 + 3.1 * s, 6.5 + 3.1 * s, depth=0.18)
    for s in range(storeys):
        d.window(middle - 0.6, middle + 0.6, 4.9 + 3.1 * s, 6.5 + 3.1 * s, depth=0.18)


def leaning(d: Drawing, rng: np.random.Generator) -> None:
    """Narrow houses that lean towards the street, of different heights, with stepped gables."""
    d.lean, x = rng.uniform(0.01, 0.035), 0.0
    for h in range(int(rng.integers(2, 5))):
        wide, storeys, out = rng.uniform(4.6, 6.4), int(rng.integers(3, 5)), rng.uniform(0.0, 0.15)
        eaves = 3.0 * storeys + rng.uniform(0.2, 0.8)
        d.house(x, x + wide, -out, 8, 0, eaves)
        for k in range(3):
            d.add(
                x + 0.6 * (k + 1), x + wide - 0.6 * (k + 1), -out, 0.4, eaves + 0.8 * k, eaves + 0.8 * (k + 1)
            )
        d.window(x + wide / 2 - 0.4, x + wide / 2 + 0.4, eaves + 0.3, eaves + 1.5, y=-out, depth=0.1)
        count = 2 if wide < 5.2 else 3
        light = (wide - 0.8 - 0.35 * (count - 1)) / count
        for s in range(storeys):
            for k in range(count):
                left = x + 0.4 + k * (light + 0.35)
                if s == 0 and k == h % count:
                    d.door(left, left + min(light, 1.1), 2.4, y=-out, depth=0.15)
                else:
                    d.window(left, left + light, 3.0 * s + 0.8, 3.0 * s + 2.5, y=-out, depth=0.08)
        x += wide


def palazzo(d: Drawing, rng: np.random.Generator) -> None:
    """A rusticated ground floor, windows in surrounds under heavy hoods, a balcony on consoles, a cornice."""
    count, bay, deep = 2 * int(rng.integers(2, 4)) + 1, rng.uniform(3.0, 3.8), rng.uniform(0.03, 0.06)
    length, high = count * bay, 14.6
    d.house(0, length, 0, 10, 0, high)
    for z in np.arange(0.8, 4.2, 0.45):
        d.cut(0, length, 0, deep, z, z + 0.05)
    d.add(0, length, -0.15, 0, 4.4, 4.8)
    d.add(0, length, -0.9, 0, high - 0.5, high)
    for k in range(count):
        x = (k + 0.5) * bay
        if k == count // 2:
            d.door(x - 0.9, x + 0.9, 3.4, depth=0.4)
        else:
            d.window(x - 0.6, x + 0.6, 1.4, 3.2, depth=0.35)
        for z, tall in ((5.6, 2.4), (10.2, 1.8)):
            for left in (x - 0.9, x + 0.7):  # beside the opening and not around it
                d.add(left, left + 0.2, -0.1, 0, z - 0.2, z + tall + 0.2)
            d.add(x - 0.95, x + 0.95, -0.12, 0, z - 0.35, z - 0.2)
            d.add(x - 1.05, x + 1.05, -0.35, 0, z + tall + 0.2, z + tall + 0.5)
            d.window(x - 0.65, x + 0.65, z, z + tall, depth=0.25)
    x = (count // 2 + 0.5) * bay
    d.add(x - 1.6, x + 1.6, -1.0, 0, 4.8, 5.0)
    for k in range(9):
        d.add(x - 1.55 + 0.37 * k, x - 1.43 + 0.37 * k, -0.98, -0.86, 5.0, 5.9)
    d.add(x - 1.6, x + 1.6, -1.0, -0.84, 5.9, 6.0)


def fins(d: Drawing, rng: np.random.Generator) -> None:
    """An office front with upright fins before bands of windows, over a ground floor of wall and doors."""
    count, pitch, out = int(rng.integers(8, 13)), rng.uniform(1.2, 1.8), rng.uniform(0.25, 0.6)
    length, storeys = count * pitch + 0.15, int(rng.integers(3, 5))
    d.house(0, length, 0, 11, 0, 3.8 + 3.4 * storeys)
    for k in range(count + 1):
        d.add(k * pitch, k * pitch + 0.15, -out, 0, 3.6, 3.8 + 3.4 * storeys)
    for s in range(storeys):
        for k in range(count):
            d.window(k * pitch + 0.2, (k + 1) * pitch - 0.05, 4.7 + 3.4 * s, 6.7 + 3.4 * s, depth=0.12)
    for k in range(0, count - 1, 2):
        x = k * pitch + 0.3
        if k == 2:
            d.door(x, x + 1.6, 2.5, depth=0.2)
        else:
            d.window(x, x + 1.8, 1.0, 2.6, depth=0.15)


def concrete(d: Drawing, rng: np.random.Generator) -> None:
    """A grid of concrete: panes deep in square coffers between ribs, over an open ground floor."""
    count, pitch, deep = int(rng.integers(4, 7)), rng.uniform(2.6, 3.4), rng.uniform(0.4, 0.9)
    rib, storeys = rng.uniform(0.3, 0.6), int(rng.integers(3, 5))
    length = count * pitch + rib
    d.house(0, length, 0, 11, 0, 3.6 + 3.2 * storeys)
    for k in range(count):
        x = k * pitch + rib
        for s in range(storeys):
            z = 3.6 + 3.2 * s
            d.cut(x, x + pitch - rib, 0, deep, z + 0.3, z + 3.0)
            d.window(x + 0.1, x + pitch - rib - 0.1, z + 1.1, z + 2.8, y=deep, depth=0.1)
        if k == 1:
            d.door(x + 0.3, x + 1.6, 2.4, depth=0.3)
        else:
            d.window(x + 0.2, x + pitch - rib - 0.2, 0.9, 2.5, depth=0.15)


def awnings(d: Drawing, rng: np.random.Generator) -> None:
    """Shops under awnings and signs that stand out, flats with flower boxes and coolers at the windows."""
    units, wide = int(rng.integers(3, 5)), rng.uniform(3.8, 4.8)
    length = units * wide
    d.house(0, length, 0, 10, 0, 10.4)
    for k in range(units):
        x = k * wide
        d.window(x + 0.4, x + wide - 1.6, 0.5, 2.8, depth=0.15)
        d.door(x + wide - 1.4, x + wide - 0.4, 2.4, depth=0.25)
        for step in range(5):
            d.add(
                x + 0.3,
                x + wide - 0.3,
                -0.25 * (step + 1),
                -0.25 * step,
                2.94 - 0.1 * step,
                3.02 - 0.1 * step,
            )
        d.add(x + 0.3, x + wide - 0.3, -0.12, 0, 3.15, 3.7)
        if k % 2:
            d.add(x + 0.2, x + 0.3, -1.0, 0, 4.2, 4.9)
        for s in range(2):
            for n, left in enumerate((x + 0.6, x + wide - 1.7)):
                z = 4.9 + 2.9 * s
                d.window(left, left + 1.1, z, z + 1.6, depth=0.15)
                if (k + s + n) % 3 == 0:
                    d.add(left, left + 1.1, -0.3, -0.05, z - 0.05, z + 0.2)
                elif (k + s + n) % 3 == 1:
                    d.add(left + 0.2, left + 0.85, -0.35, 0, z, z + 0.42)
