"""Numbers from files, checked before they are used."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from frontage.geometry.arrays import Float
from frontage.io.crs import LARGEST_M

_LARGEST_SIDE = 2**20  # px; no picture is as wide


def finite(value: Any, what: str) -> float:
    """The number that a file states. Raises ValueError when it is none, not finite or beyond LARGEST_M."""
    if isinstance(value, bool) or value is None:
        raise ValueError(f"{what} is no number")
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{what} is {str(value)[:30]!r}, which is no number") from None
    if not abs(number) < LARGEST_M:  # NaN is not, either
        raise ValueError(f"{what} is {number:g}, which is not finite or beyond {LARGEST_M:g}")
    return number


def vector(values: Any, count: int, what: str) -> Float:
    """`count` checked numbers, from a list or from text divided by spaces. Raises ValueError."""
    parts: Iterable[Any] = values.split() if isinstance(values, str) else values
    if not isinstance(parts, list) or len(parts) != count:
        raise ValueError(f"{what} has not {count} numbers")
    return np.array([finite(v, what) for v in parts])


def pixels(value: Any, what: str) -> int:
    """A whole number of pixels, 1 or more. Raises ValueError."""
    number = finite(value, what)
    if number != int(number) or not 1 <= number <= _LARGEST_SIDE:
        raise ValueError(f"{what} is {number:g}, which is no size of a picture in pixels")
    return int(number)
