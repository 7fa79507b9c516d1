"""Photos or windows worked on abreast by threads: most of the time goes to code outside the interpreter."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

T = TypeVar("T")
R = TypeVar("R")

_MOST = 4  # each may hold a decoded picture and a few renderings


def each(work: Callable[[T], R], items: Sequence[T]) -> Iterator[R]:
    """Yields the results in the order of the items, which does not depend on the number of threads."""
    count = min(_MOST, os.cpu_count() or 1, len(items))
    if count < 2:
        yield from map(work, items)
        return
    with ThreadPoolExecutor(count) as pool:
        yield from pool.map(work, items)
