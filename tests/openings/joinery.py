"""Walls with holes and what fills them, as boxes for `boxes.scanned`: reveals, niches, frames, posts."""

from openings.boxes import SIZE, box


def holed(x0, x1, z0, z1, y0, y1, holes):
    """A slab, front at y0 m, with holes (x0, z0, x1, z1) m side by side."""
    parts, x = [], x0
    for a, b, c, d in sorted(holes):
        parts += [box(x, a, y0, y1, z0, z1), box(a, c, y0, y1, z0, b), box(a, c, y0, y1, d, z1)]
        x = c
    parts.append(box(x, x1, y0, y1, z0, z1))
    return [p for p in parts if (p[1] > p[0]).all()]


def wall(holes):
    """The wall of `boxes` with holes, 30 cm thick."""
    return holed(0, SIZE[0], 0, SIZE[1], 0.0, 0.3, holes)


def glazed(hole, y, panes):
    """Joinery with its front at y m that fills a hole but for its panes; these return nothing."""
    x0, z0, x1, z1 = hole
    return holed(x0, x1, z0, z1, y, y + 0.06, panes)


def framed(hole, y, frame=0.07):
    """One pane in a frame."""
    x0, z0, x1, z1 = hole
    return glazed(hole, y, [(x0 + frame, z0 + frame, x1 - frame, z1 - frame)])


def niche(hole, deep, holes=()):
    """A wall with a niche `deep` m deep, whose back has holes."""
    x0, z0, x1, z1 = hole
    cheeks = [box(x0 - 0.05, x0, 0.0, deep, z0, z1), box(x1, x1 + 0.05, 0.0, deep, z0, z1)]
    ceiling = box(x0, x1, 0.0, deep, z1, z1 + 0.05)
    return [*wall([hole]), *cheeks, ceiling, *holed(x0, x1, z0, z1, deep, deep + 0.3, holes)]
