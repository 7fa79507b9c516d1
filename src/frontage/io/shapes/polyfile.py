"""Reading TetGen's .poly: vertices, then facets; the first polygon of a facet is its outer ring."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from frontage.geometry.arrays import Float
from frontage.model import Polygons


def read_poly(path: Path) -> list[tuple[str, Polygons]]:
    """Read the facets of a .poly file as one unnamed object.

    The polygons of a facet after the first are its holes; hole points and region points are not read.

    Raises ValueError naming what is wrong with the text.
    """
    lines = _lines(path)
    count, dimension = (int(v) for v in _next(lines, "the number of vertices")[:2])
    if dimension != 3:
        raise ValueError(f"its vertices have {dimension} dimensions instead of 3")
    rows = [_next(lines, f"vertex {k} of {count}") for k in range(count)]
    vertices = np.array([row[1:4] for row in rows], np.float64).reshape(-1, 3)
    if len(vertices) != count:
        raise ValueError("some vertices lack coordinates")
    base = int(rows[0][0]) if rows else 0
    number = int(_next(lines, "the number of facets")[0])
    facets = []
    for k, words in enumerate(lines):
        if k >= number and len(words) != 2:
            break  # the list of holes begins; a line of two numbers is a facet beyond the stated number
        facets.append(_facet([int(w) for w in words], lines, vertices, base, k))
    if len(facets) < number:
        raise ValueError(f"it ends before facet {len(facets)} of {number}")
    return [("", Polygons.of(facets))]


def _facet(
    head: list[int], lines: Iterator[list[str]], vertices: Float, base: int, number: int
) -> list[Float]:
    """The rings of one facet, whose first line is `head`."""
    rings = []
    for _ in range(head[0]):
        words = _next(lines, f"a polygon of facet {number}")
        while len(words) < int(words[0]) + 1:
            words += _next(lines, f"the rest of a polygon of facet {number}")
        ids = np.array(words[1 : int(words[0]) + 1], np.int64) - base
        if len(ids) and (ids.min() < 0 or ids.max() >= len(vertices)):
            raise ValueError(f"facet {number} names a vertex that does not exist")
        rings.append(vertices[ids])
    for _ in range(head[1] if len(head) > 1 else 0):
        _next(lines, f"a hole of facet {number}")
    return rings


def _lines(path: Path) -> Iterator[list[str]]:
    """The words of every line that has any, without comments."""
    for line in path.read_text("utf-8").splitlines():
        if words := line.split("#")[0].split():
            yield words


def _next(lines: Iterator[list[str]], what: str) -> list[str]:
    try:
        return next(lines)
    except StopIteration:
        raise ValueError(f"it ends before {what}") from None
