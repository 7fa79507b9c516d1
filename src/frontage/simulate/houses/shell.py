"""The bare body of a house: the outlines of its four sides, and the closed shell they form with the roof."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.simulate.houses.draft import HouseDraft

MANSARD_M = (0.9, 2.4)  # run and rise of the steep lower slope


@dataclass(frozen=True, eq=False)
class ShellFace:
    """A face of the shell: semantics, ring (k, 3) m counter-clockwise from outside, side 0..3 of a wall."""

    semantics: str
    ring: Float
    side: int = -1


def house_from_side(draft: HouseDraft, side: int) -> Rigid3:
    """Return the pose of a side's facade frame: 0 front, 1 right, 2 back, 3 left, as seen from the street."""
    w, d = draft.width, draft.depth
    x = np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, 0, 0], [0, -1.0, 0]])[side]
    y = np.array([[0, 1.0, 0], [-1.0, 0, 0], [0, -1.0, 0], [1.0, 0, 0]])[side]
    t = np.array([[0, 0, 0], [w, 0, 0], [w, d, 0], [0, d, 0]], float)[side]
    return Rigid3("house", "facade", np.column_stack([x, y, [0.0, 0.0, 1.0]]), t)


def side_outline(draft: HouseDraft, side: int, base: float = 0.0) -> Float:
    """Return the outline (k, 2) m of a side in its own frame, from height `base` up, gable included."""
    length = draft.depth if side % 2 else draft.width
    top = _upper_edge(draft, length, side)
    return np.array([[0.0, base], [length, base], *top])


def front_outline(draft: HouseDraft, side: int) -> Float:
    """Return the outline (k, 2) m of a side above the pavement, which may slope."""
    ring = side_outline(draft, side).copy()
    left, right = draft.ground
    ring[:2, 1] = ((left, right), (right, right), (right, left), (left, left))[side]
    return ring


def shell_faces(draft: HouseDraft, base: float = 0.0) -> tuple[ShellFace, ...]:
    """Return the closed shell in the house's frame; its walls reach down to height `base`, m."""
    w, d = draft.width, draft.depth
    faces = []
    for side in range(4):
        ring = side_outline(draft, side, base)
        xyz = np.column_stack([ring[:, 0], np.zeros(len(ring)), ring[:, 1]])
        faces.append(ShellFace("WallSurface", house_from_side(draft, side).apply(xyz), side))
    faces += [ShellFace("RoofSurface", ring) for ring in _roof(draft)]
    ground = np.array([[0, 0, base], [0, d, base], [w, d, base], [w, 0, base]], float)
    return (*faces, ShellFace("GroundSurface", ground))


def _upper_edge(draft: HouseDraft, length: float, side: int) -> list[tuple[float, float]]:
    """Returns the upper edge (x, z) m of a side, from right to left."""
    eaves, ridge = draft.eaves, draft.ridge
    gable_end = side % 2 == 1  # if the ridge runs along the street
    if draft.roof == "mansard" and gable_end:
        run, rise = MANSARD_M
        inner = [(length - run, eaves + rise), (length / 2, ridge), (run, eaves + rise)]
        return [(length, eaves), *inner, (0.0, eaves)]
    if (draft.roof == "gable" and gable_end) or (draft.roof == "street_gable" and not gable_end):
        return [(length, eaves), (length / 2, ridge), (0.0, eaves)]
    return [(length, eaves), (0.0, eaves)]


def _roof(draft: HouseDraft) -> list[Float]:
    w, d, eaves = draft.width, draft.depth, draft.eaves
    if draft.roof == "flat":
        return [np.array([[0, 0, eaves], [w, 0, eaves], [w, d, eaves], [0, d, eaves]], float)]
    if draft.roof == "hip":
        return _hip(draft)
    rings = []
    if draft.roof == "street_gable":
        chain = _upper_edge(draft, w, 0)
        for (xa, za), (xb, zb) in pairwise(chain):
            rings.append(np.array([[xa, 0, za], [xa, d, za], [xb, d, zb], [xb, 0, zb]]))
        return rings
    chain = _upper_edge(draft, d, 1)
    for (ya, za), (yb, zb) in pairwise(chain):
        rings.append(np.array([[0, ya, za], [0, yb, zb], [w, yb, zb], [w, ya, za]]))
    return rings


def _hip(draft: HouseDraft) -> list[Float]:
    w, d, e, r = draft.width, draft.depth, draft.eaves, draft.ridge
    a, b, c, f = (np.array(p, float) for p in ([0, 0, e], [w, 0, e], [w, d, e], [0, d, e]))
    if w >= d:
        run = 0.45 * d
        p, q = np.array([run, d / 2, r]), np.array([w - run, d / 2, r])
        return [np.array(k) for k in ([a, b, q, p], [b, c, q], [c, f, p, q], [f, a, p])]
    run = 0.45 * w
    p, q = np.array([w / 2, run, r]), np.array([w / 2, d - run, r])
    return [np.array(k) for k in ([a, b, p], [b, c, q, p], [c, f, q], [f, a, p, q])]
