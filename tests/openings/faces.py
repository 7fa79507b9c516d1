"""Walls of upright parallelograms, at any angle, scanned beam by beam: canted bays, panes, blinds."""

from itertools import pairwise

import numpy as np

from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.model.estimate import Estimate
from frontage.model.facade import Facade
from frontage.model.scan import Scan
from frontage.model.world import WorldRef

NOISE = 0.002


def face(a, b, z0, z1, holes=()):
    """The upright face between the plan points a and b (x, y) m, without holes (s0, z0, s1, z1), s from a."""
    a, b = np.array(a, float), np.array(b, float)
    length = float(np.hypot(*(b - a)))
    s = np.unique([0.0, length, *(h[k] for h in holes for k in (0, 2))])
    z = np.unique([z0, z1, *(h[k] for h in holes for k in (1, 3))])
    out = []
    for s0, s1 in pairwise(s):
        for low, high in pairwise(z):
            x, y = (s0 + s1) / 2, (low + high) / 2
            if not any(h[0] < x < h[2] and h[1] < y < h[3] for h in holes):
                p, q = a + (b - a) * s0 / length, a + (b - a) * s1 / length
                out.append(((*p, low), (*(q - p), 0.0), (0.0, 0.0, high - low)))
    return out


def scanned_faces(faces, size, *, spacing=0.03, eyes=((1.0, -10.0, 1.6), (7.0, -9.0, 1.6))):
    """Facade y = 0 of size (width, height) m and the scan of faces."""
    rng = np.random.default_rng(0)
    x, z = np.meshgrid(np.arange(-1, size[0] + 1, spacing), np.arange(0, size[1] + 0.5, spacing))
    points, index = [], []
    for k, eye in enumerate(np.array(eyes)):
        target = np.column_stack([x.ravel(), np.zeros(x.size), z.ravel()])
        target[:, [0, 2]] += rng.uniform(-spacing / 2, spacing / 2, (len(target), 2))
        way = target - eye
        share = _first(eye, way, faces)
        kept = np.isfinite(share)
        noise = rng.normal(0, NOISE, (kept.sum(), 1)) / np.linalg.norm(way[kept], axis=1, keepdims=True)
        points.append(eye + way[kept] * (share[kept, None] + noise))
        index.append(np.full(kept.sum(), k, np.int32))
    p = np.concatenate(points)
    support = np.flatnonzero((p[:, 1] > -1.5) & (p[:, 1] < 1.0) & (p[:, 0] > 0) & (p[:, 0] < size[0]))
    pose = Estimate(Rigid3("local", "facade", np.eye(3), np.zeros(3)), np.eye(6) * 1e-8, 100.0)
    facade = Facade(
        "B01/F1", "B01", pose, WorldRef(np.zeros(3, np.int64)), rectangle(0, 0, *size), (),
        support, np.flatnonzero(np.abs(p[:, 1]) < 3 * NOISE), NOISE, spacing / 1.5, 0.9, "rays",
    )  # fmt: skip
    scan = Scan("faces", p, facade.world, origins=np.array(eyes), origin_index=np.concatenate(index))
    return facade, scan


def _first(eye, way, faces):
    """Share of the way (n, 3) from an eye at which a beam meets the first of the faces; inf where none."""
    best = np.full(len(way), np.inf)
    for corner, along, up in (tuple(np.array(v) for v in f) for f in faces):
        normal = np.cross(along, up)
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (corner - eye) @ normal / (way @ normal)
        q = eye + way * share[:, None] - corner
        u, v = q @ along / (along @ along), q @ up / (up @ up)
        hit = (share > 0) & (u >= 0) & (u <= 1) & (v >= 0) & (v <= 1)
        best = np.where(hit, np.minimum(best, share), best)
    return best
