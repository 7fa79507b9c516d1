"""Walls with boxes before them, scanned beam by beam from known places."""

from dataclasses import replace

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate
from frontage.model.facade import Facade, Layer
from frontage.model.scan import Scan
from frontage.model.world import WorldRef

SIZE = (8.0, 9.0)
EYES = ((1.0, -10.0, 1.6), (7.0, -9.0, 1.6))
NOISE = 0.002


def box(x0, x1, y0, y1, z0, z1):
    """An upright box, m, as the scanner takes it."""
    return np.array([[x0, y0, z0], [x1, y1, z1]])


def oriel(x0, x1, z0, z1, y, window, depth):
    """A bay with one window x0, z0, x1, z1 whose pane lies `depth` m behind its front at y m."""
    a, b, c, d = window
    thick = depth + 0.05
    sides = [(x0, a, z0, z1), (c, x1, z0, z1), (a, c, z0, b), (a, c, d, z1)]
    walls = [box(p, q, y, y + thick, r, s) for p, q, r, s in sides]
    cheeks = [box(x0, x0 + 0.05, y, 0.0, z0, z1), box(x1 - 0.05, x1, y, 0.0, z0, z1)]
    return [*walls, box(a, c, y + depth, y + thick, b, d), *cheeks, box(x0, x1, y, 0.0, z0, z0 + 0.05)]


def balcony(x0, x1, z, y, bars=False, high=1.0):
    """A slab with its upper face at z m and a parapet or railing around it, front at y m."""
    slab = box(x0, x1, y, 0.0, z - 0.15, z)
    if not bars:
        rails = [box(x0, x1, y, y + 0.1, z, z + high), box(x0, x0 + 0.1, y, 0.0, z, z + high)]
        return [slab, *rails, box(x1 - 0.1, x1, y, 0.0, z, z + high)]
    top = z + high
    rails = [box(x0, x1, y, y + 0.04, top - 0.04, top), box(x0, x0 + 0.04, y, 0.0, top - 0.04, top)]
    rails.append(box(x1 - 0.04, x1, y, 0.0, top - 0.04, top))
    at = np.arange(x0 + 0.01, x1, 0.115)
    return [slab, *rails, *(box(x, x + 0.02, y + 0.01, y + 0.03, z, top) for x in at)]


def scanned(boxes=(), *, spacing=0.03, rays=True, eyes=EYES, wall=None, extra=None, layers=()):
    """Facade and scan of a wall y = 0 (or boxes `wall`) with boxes before it; `extra` (n, 3) more points."""
    rng, size = np.random.default_rng(0), SIZE
    solids = [*(wall or [box(0, size[0], 0.0, 0.3, 0, size[1])]), *boxes]
    x, z = np.meshgrid(np.arange(-1, size[0] + 1, spacing), np.arange(0, size[1] + 0.5, spacing))
    points, index = [], []
    for k, eye in enumerate(eyes):
        aim = np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()])
        aim[:, [0, 2]] += rng.uniform(-spacing / 2, spacing / 2, (len(aim), 2))
        way = aim - eye
        share = first_hit(np.array(eye), way, solids)
        kept = share < 1.15
        length = np.linalg.norm(way[kept], axis=1, keepdims=True)
        noise = rng.normal(0, NOISE, (kept.sum(), 1)) / length
        points.append(eye + way[kept] * (share[kept, None] + noise))
        index.append(np.full(kept.sum(), k, np.int32))
    p, origin = np.concatenate(points), np.concatenate(index)
    if extra is not None:
        p, origin = np.concatenate([p, extra]), np.append(origin, np.zeros(len(extra), np.int32))
    support = np.flatnonzero((p[:, 1] > -1.5) & (p[:, 1] < 1.0) & (p[:, 0] > 0) & (p[:, 0] < size[0]))
    on = np.flatnonzero(np.abs(p[:, 1]) < 3 * NOISE)
    known = {"origins": np.array(eyes), "origin_index": origin} if rays else {}
    pose = Estimate(Rigid3("local", "facade", np.eye(3), np.zeros(3)), np.eye(6) * 1e-8, 100.0)
    told = tuple(Layer(y, NOISE, 10.0, rectangle(0, 0, *size)) for y in layers)
    facade = Facade(
        "B01/F1", "B01", pose, WorldRef(np.zeros(3, np.int64)), rectangle(0, 0, *size), told,
        support, on, NOISE, spacing / 1.5, 0.9, "rays",
    )  # fmt: skip
    return facade, Scan("wall", p, facade.world, **known)


def with_points(facade, scan, kept):
    """The facade and its scan with only the points that are `kept` (n,)."""
    number = np.cumsum(kept) - 1
    support, inliers = (number[rows[kept[rows]]] for rows in (facade.support, facade.inliers))
    return replace(facade, support=support, inliers=inliers), scan.take(np.flatnonzero(kept))


def first_hit(eye: Float, way: Float, solids) -> Float:
    """Share of the way (n, 3) from an eye at which a beam meets the first of the boxes; inf where none."""
    best = np.full(len(way), np.inf)
    with np.errstate(divide="ignore", invalid="ignore"):
        for low, high in solids:
            a, b = (low - eye) / way, (high - eye) / way
            enter, leave = np.minimum(a, b).max(1), np.maximum(a, b).min(1)
            best = np.where((enter <= leave) & (enter > 0), np.minimum(best, enter), best)
    return best
