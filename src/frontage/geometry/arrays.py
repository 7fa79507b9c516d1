"""Array aliases, and the check that every noun runs on its arrays."""

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

Float = NDArray[np.float64]
Int = NDArray[np.int64]
Bool = NDArray[np.bool_]
Array = NDArray[Any]

_ODD = np.uint64(0x9E3779B97F4A7C15)  # 2^64 over the golden ratio, spreads neighbours (Knuth 1973)
_ABREAST = 512  # rows that are compared as one
_BLOCK = 16384  # rows at a time, so that a block stays in the processor's cache


def readonly(array: Any, shape: tuple[int | None, ...], dtype: DTypeLike, name: str) -> Array:
    """Returns `array` as a read-only, C-ordered array of `shape` and `dtype`.

    `None` in `shape` matches any length. An array that already fits is not copied; the view that is returned
    is read-only.

    Raises ValueError that names the array when the shape does not match, or when it holds complex numbers.
    """
    if np.iscomplexobj(array) and np.dtype(dtype).kind != "c":
        raise ValueError(f"{name}: complex numbers, expected {np.dtype(dtype).name}")
    a = np.ascontiguousarray(array, dtype=dtype).view()
    if a.ndim != len(shape) or any(
        want is not None and want != got for want, got in zip(shape, a.shape, strict=True)
    ):
        raise ValueError(f"{name}: shape {a.shape}, expected {tuple('n' if s is None else s for s in shape)}")
    a.flags.writeable = False
    return a


def freeze(noun: object, **fields: tuple[tuple[int | None, ...], DTypeLike]) -> None:
    """Checks the array fields of a frozen dataclass and makes them read-only; fields that are None stay so.

    ``freeze(self, xyz=((n, 3), np.float64))``. Raises ValueError as `readonly` does.
    """
    for name, (shape, dtype) in fields.items():
        value = getattr(noun, name)
        if value is not None:
            object.__setattr__(noun, name, readonly(value, shape, dtype, name))


def picked_rows(which: Bool, points: Array) -> Array:
    """Returns the rows (k, d) of points (n, d) that `which` (n,) selects, stored axis by axis in memory.

    Passes over one coordinate are faster in this order, because they do not read the others. If all rows are
    selected, `points` itself is returned, not a copy.
    """
    if which.all():
        return points
    return np.take(points.T, np.flatnonzero(which), axis=1).T


def distinct(values: Int) -> Int:
    """Returns the distinct values (n,) in ascending order, many times faster than `numpy.unique`."""
    ordered = np.sort(values)
    return ordered[np.flatnonzero(np.diff(ordered, prepend=ordered[:1] - 1))]


def extent(places: Float) -> tuple[Float, Float]:
    """Returns the least and the greatest coordinates (d,) of places (n, d), infinite where there are none.

    Hundreds of rows are compared as one, because numpy is slow across short rows.
    """
    whole = len(places) // _ABREAST * _ABREAST
    long = places[:whole].reshape(-1, _ABREAST * places.shape[1])
    ends = []
    for extreme, start in ((np.minimum, np.inf), (np.maximum, -np.inf)):
        some = extreme.reduce(long, axis=0, initial=start).reshape(-1, places.shape[1])
        ends.append(extreme.reduce(np.concatenate([some, places[whole:]]), axis=0))
    return ends[0], ends[1]


def sorted_groups(key: Int) -> tuple[Int, Int]:
    """Returns the order (n,) that sorts keys (n,) >= 0, equal ones as they come, and where each group starts.

    Keys and rows are sorted as one number where they fit into one, which is several times faster.
    """
    if not len(key):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    bits = len(key).bit_length()
    if int(key.max()).bit_length() + bits < 64:
        ranked = key << bits
        ranked |= np.arange(len(key))
        ranked.sort()
        order = ranked & ((1 << bits) - 1)
        ranked >>= bits
    else:
        order = np.argsort(key, kind="stable")
        ranked = key[order]
    return order, np.flatnonzero(np.append(True, ranked[1:] != ranked[:-1]))


def rising(values: Float) -> Int:
    """Returns the order (n,) in which values (n,) rise, equal ones as they come.

    It is that of numpy's stable sort, which takes twice as long because it compares.
    """
    order = np.argsort(values)
    ranked = values[order]
    same = ranked[1:] == ranked[:-1]
    tied = np.flatnonzero(np.append(same, False) | np.append(False, same))
    if len(tied):
        bits = len(values).bit_length()
        group = np.cumsum(np.append(True, ~same))[tied]
        both = np.sort((group << bits) | order[tied])
        order[tied] = both & ((1 << bits) - 1)
    return order


def drawn(places: Float, most: int) -> Int:
    """Returns the rows (k,) of about `most` of the places (n, d) m, all of them where there are no more.

    A hash of the coordinates, to 0.1 mm, draws them: the same places in whatever order they come.
    """
    step = -(-len(places) // max(most, 1))
    if step <= 1:
        return np.arange(len(places))
    blocks = (places[k : k + _BLOCK] for k in range(0, len(places), _BLOCK))
    return np.flatnonzero(np.concatenate([_hash(block) % np.uint64(step) == 0 for block in blocks]))


def _hash(places: Float) -> NDArray[np.uint64]:
    """Returns a number (n,) that looks random for every place (n, d) m, from its coordinates to 0.1 mm."""
    mixed = np.zeros(len(places), np.uint64)
    for axis in places.T:
        scaled = axis * 1e4
        mixed ^= np.rint(scaled, out=scaled).astype(np.int64).view(np.uint64)
        mixed *= _ODD
        mixed ^= mixed >> np.uint64(29)
    return mixed
