"""Well-known binary (OGC 06-103r4, with the flags of PostGIS), checked before native code sees it.

GEOS reads nested collections by recursion, so a small file that nests them deeply ends the interpreter.
"""

import struct

import shapely

_DEEPEST = 32  # nested collections; a multipolygon in a collection is 3
_FLAGS = 0xE0000000
_Z, _M, _SRID = 0x80000000, 0x40000000, 0x20000000
_POINT, _LINE, _POLYGON, _COLLECTION = 1, 2, 3, 7
_KINDS_PER_DIMENSION = 1000  # 1003 is a polygon with z, 2003 with m, 3003 with both
_HEAD = 5  # bytes of the order and the kind of a geometry, the least that one takes


def polygons_of(wkb: bytes) -> list[shapely.Polygon]:
    """The polygons of a geometry and of the collections in it, without empty ones.

    Raises ValueError saying what is wrong with it.
    """
    _Scanner(wkb).check()
    try:
        waiting = [shapely.from_wkb(wkb)]
    except shapely.errors.GEOSException as problem:
        raise ValueError("a geometry that cannot be read") from problem
    found = []
    while waiting:
        geometry = waiting.pop()
        if isinstance(geometry, shapely.Polygon):
            found += [] if geometry.is_empty else [geometry]
        elif hasattr(geometry, "geoms"):
            waiting += reversed(geometry.geoms)
    return found


class _Scanner:
    """Walks through a geometry without recursion; no count is believed that the bytes do not bear out."""

    def __init__(self, wkb: bytes) -> None:
        self._wkb = wkb
        self._at = 0

    def check(self) -> None:
        """Raise ValueError for a geometry that is cut short, nested too deeply or of an unknown kind."""
        left = [1]  # geometries still to come, level by level
        while left:
            if not left[-1]:
                left.pop()
                continue
            left[-1] -= 1
            if (inside := self._geometry()) is not None:
                left.append(inside)
            if len(left) > _DEEPEST:
                raise ValueError("collections that are nested too deeply")

    def _geometry(self) -> int | None:
        """Pass one geometry; of a collection only the head, whose number of members is returned."""
        mark = self._take(1)[0]
        if mark not in (0, 1):
            raise ValueError("a geometry without a byte order")
        order = "<" if mark else ">"
        stated = self._number(order)
        extended, kind = stated & _FLAGS, stated & ~_FLAGS
        if extended & _SRID:
            self._take(4)
        kind, dimensions = kind % _KINDS_PER_DIMENSION, kind // _KINDS_PER_DIMENSION
        size = 8 * (2 + bool(extended & _Z or dimensions in (1, 3)) + bool(extended & _M or dimensions > 1))
        if kind == _POINT:
            self._take(size)
        elif kind == _LINE:
            self._take(size * self._number(order))
        elif kind == _POLYGON:
            for _ in range(self._count(order, 4)):
                self._take(size * self._number(order))
        elif _POLYGON < kind <= _COLLECTION:
            return self._count(order, _HEAD)
        else:
            raise ValueError("a curved or unknown kind of geometry")
        return None

    def _count(self, order: str, least: int) -> int:
        """A number of things that take at least some bytes each."""
        number = self._number(order)
        if number * least > len(self._wkb) - self._at:
            raise ValueError("a geometry that is cut short")
        return number

    def _number(self, order: str) -> int:
        (number,) = struct.unpack(f"{order}I", self._take(4))
        return int(number)

    def _take(self, size: int) -> bytes:
        """The next bytes."""
        taken = self._wkb[self._at : self._at + size]
        if len(taken) < size:
            raise ValueError("a geometry that is cut short")
        self._at += size
        return taken
