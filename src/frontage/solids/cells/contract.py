"""Contracts edges of cells that are too short for the validator to tell their ends apart."""

from collections.abc import Sequence

from frontage.solids.brep import ring_edges, without_spurs

Node = tuple[int, int]
"""A vertex of the partition: (x, z) in whole 0.1 mm of the wall."""

Rings = tuple[tuple[Node, ...], ...]
"""The outer ring of a cell and its holes."""

SHORTEST = 20.0  # 0.1 mm: twice the validator's snap tolerance


def contract_short_edges(cells: Sequence[Rings], fixed: set[Node]) -> list[Rings]:
    """Contracts edges shorter than `SHORTEST`, except those between `fixed` nodes.

    Of the two ends, a fixed node stays before a node of the outline, and that before an inner one. All cells
    change together, so that they still conform. A ring with fewer than three nodes vanishes; a cell without
    an outer ring is returned as ().
    """
    rings = list(cells)
    while True:
        moves = _next_moves(rings, fixed)
        if not moves:
            return rings
        rings = [tuple(without_spurs(moves.get(n, n) for n in r) for r in c) for c in rings]
        rings = [(c[0], *(h for h in c[1:] if len(h) > 2)) if c and len(c[0]) > 2 else () for c in rings]


def _next_moves(cells: Sequence[Rings], fixed: set[Node]) -> dict[Node, Node]:
    """Returns node -> node that it moves to, shortest edges first; no node takes part in two moves."""
    edges = {e for c in cells for r in c for e in ring_edges(r)}
    outline = {n for a, b in edges if (b, a) not in edges for n in (a, b)}
    short = sorted((_squared_length(a, b), a, b) for a, b in edges if _squared_length(a, b) < SHORTEST**2)
    moves: dict[Node, Node] = {}
    busy: set[Node] = set()
    for _, a, b in short:
        stay, go = sorted((a, b), key=lambda n: (n not in fixed, n not in outline, n))
        if go in fixed or stay in busy or go in busy:
            continue
        moves[go] = stay
        busy |= {stay, go}
    return moves


def _squared_length(a: Node, b: Node) -> int:
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2
