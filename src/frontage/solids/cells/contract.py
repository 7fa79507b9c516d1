"""Borders shorter than the validator could tell apart are drawn together into one node."""

from collections.abc import Sequence

from frontage.solids.rims import without_spurs

Node = tuple[int, int]
Rings = tuple[tuple[Node, ...], ...]

SHORTEST = 20.0  # 0.1 mm: twice the validator's snap tolerance


def contracted(cells: Sequence[Rings], fixed: set[Node]) -> list[Rings]:
    """Cells (outer ring, holes) whose edges are all at least `SHORTEST` long, but between `fixed` nodes.

    The inner node of an edge goes to the outer one: fixed nodes stay, nodes of the outline stay before
    others. All cells change together, so they still conform. A ring with fewer than three nodes vanishes;
    a cell without an outer ring stays as ().
    """
    rings = list(cells)
    while True:
        moves = _moves(rings, fixed)
        if not moves:
            return rings
        rings = [tuple(without_spurs(moves.get(n, n) for n in r) for r in c) for c in rings]
        rings = [(c[0], *(h for h in c[1:] if len(h) > 2)) if c and len(c[0]) > 2 else () for c in rings]


def _moves(cells: Sequence[Rings], fixed: set[Node]) -> dict[Node, Node]:
    """Node -> node that it goes to; no node has a part in two of them."""
    edges = {e for c in cells for r in c for e in zip(r, (*r[1:], r[0]), strict=True)}
    outline = {n for a, b in edges if (b, a) not in edges for n in (a, b)}
    short = sorted((_square(a, b), a, b) for a, b in edges if _square(a, b) < SHORTEST**2)
    moves: dict[Node, Node] = {}
    busy: set[Node] = set()
    for _, a, b in short:
        stay, go = sorted((a, b), key=lambda n: (n not in fixed, n not in outline, n))
        if go in fixed or stay in busy or go in busy:
            continue
        moves[go] = stay
        busy |= {stay, go}
    return moves


def _square(a: Node, b: Node) -> int:
    return (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2
