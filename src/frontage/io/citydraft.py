"""Buildings as a file holds them, and how they become buildings in local metres.

The readers of every format fill drafts; what a draft's polygons need before they can be used (coordinates,
clean rings, a class, an outside) is done here once.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Float
from frontage.io.block import block
from frontage.model import Failed, Surface
from frontage.model.citymodel import CityBuilding, Shell

Value = str | float | int

_UPRIGHT = np.sin(np.radians(15.0))  # of the normal's height: a wall leans by less than 15 degrees
_SAME = 1e-6  # m: corners closer than this are one
_FLAT = 1e-8  # m2: a polygon smaller than this has no plane


@dataclass(eq=False)
class Face:
    """A polygon: rings (k, 3) in file coordinates, the outer one first, closed or not; its class, id and
    attributes where the file has them."""

    rings: Sequence[Float]
    semantics: str | None = None
    id: str = ""
    about: dict[str, Value] = field(default_factory=dict)


@dataclass(eq=False)
class DraftShell:
    """One geometry: level of detail, polygons, whether it is a solid, the part that it belongs to."""

    lod: str
    faces: list[Face]
    closed: bool
    part: str = ""
    installation: bool = False


@dataclass(eq=False)
class Draft:
    """A building of a file.

    problems  what of it could not be read, one short phrase each
    height    m: the footprint of level 0 is raised by this much to a block of level 1
    """

    id: str
    shells: list[DraftShell] = field(default_factory=list)
    address: str | None = None
    attributes: dict[str, Value] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)
    height: float | None = None

    def points(self) -> Float:
        """Every corner (n, 3), file coordinates."""
        rings = [r for shell in self.shells for face in shell.faces for r in face.rings]
        return np.concatenate([np.zeros((0, 3)), *rings])


def finish(draft: Draft, to_local: Callable[[Float], Float]) -> tuple[CityBuilding | None, Failed | None]:
    """The building in local metres, and what of it could not be used; None when nothing of it can.

    `to_local` takes (n, 3) file coordinates to local metres.
    """
    found: Counter[str] = Counter(draft.problems)
    total = sum(len(s.faces) for s in draft.shells)
    shells = tuple(s for d in draft.shells if (s := _shell(d, draft.id, to_local, found)).surfaces)
    if draft.height is not None:
        shells += tuple(block(s, draft.height) for s in shells if s.lod == "0")
    failed = None
    if found:
        what = ", ".join(f"{n} x {text}" if n > 1 else text for text, n in found.items())
        used = sum(len(s.surfaces) for s in shells)
        outcome = f"{used} of {total} polygons used" if shells else "left out"
        code = "I120" if shells else "I121"
        failed = Failed(code, f"{draft.id}: {what}; {outcome}", "repair this building in the model")
    if not shells and failed is None:
        failed = Failed("I121", f"{draft.id}: has no polygons; left out")
    if not shells:
        return None, failed
    return CityBuilding(draft.id, shells, draft.address, draft.attributes), failed


def _shell(
    draft: DraftShell, building: str, to_local: Callable[[Float], Float], found: Counter[str]
) -> Shell:
    """Usable polygons with classes; a solid that is turned inside out is turned back."""
    placed = _placed([f.rings for f in draft.faces], to_local)
    kept: list[tuple[Face, list[Float]]] = []
    for face, rings in zip(draft.faces, placed, strict=True):
        clean = [_clean(r) for r in rings]
        if trouble := _trouble(clean):
            found[trouble] += 1
        else:
            kept.append((face, [clean[0], *(r for r in clean[1:] if len(r) >= 3)]))
    normals = np.array([_area_normal(rings) for _, rings in kept]).reshape(-1, 3)
    if draft.closed and kept:
        middle = np.mean([rings[0].mean(0) for _, rings in kept], axis=0)
        spokes = np.array([rings[0][0] for _, rings in kept]) - middle
        if np.einsum("ij,ij->", spokes, normals) < 0.0:
            kept = [(face, [r[::-1] for r in rings]) for face, rings in kept]
            normals = -normals
    classes = _classes(kept, normals, draft.lod)
    names = _names([face.id for face, _ in kept], draft.part or building)
    surfaces = tuple(
        Surface(rings[0], kind, name, tuple(rings[1:]))
        for (_, rings), kind, name in zip(kept, classes, names, strict=True)
    )
    about = {name: face.about for (face, _), name in zip(kept, names, strict=True) if face.about}
    return Shell(draft.lod, surfaces, about, draft.closed, draft.part, draft.installation)


def _placed(faces: Sequence[Sequence[Float]], to_local: Callable[[Float], Float]) -> list[list[Float]]:
    """Rings of all faces in local metres, transformed in one go; rings that are not finite stay so."""
    sizes = [len(r) for rings in faces for r in rings]
    if not sum(sizes):
        return [[np.zeros((0, 3)) for _ in rings] for rings in faces]
    points = np.concatenate([r for rings in faces for r in rings])
    usable = np.isfinite(points).all(1)
    local: Float = np.full(points.shape, np.nan)
    if usable.any():
        local[usable] = to_local(points[usable])
    split = iter(np.split(local, np.cumsum(sizes)[:-1]))
    return [[next(split) for _ in rings] for rings in faces]


def _clean(ring: Float) -> Float:
    """A ring without corners that repeat the one before, its closing point among them."""
    if len(ring) < 2:
        return ring
    moved = np.abs(ring - np.roll(ring, 1, axis=0)).max(1)
    kept: Float = ring[~(moved <= _SAME)]
    return kept


def _trouble(rings: Sequence[Float]) -> str:
    """Why a polygon cannot be used; "" when it can."""
    if not rings or len(rings[0]) < 3:
        return "a polygon with fewer than 3 corners"
    if not all(np.isfinite(r).all() for r in rings):
        return "a coordinate that is not a number"
    if np.linalg.norm(_area_normal(rings[:1])) < _FLAT:
        return "a polygon without area"
    return ""


def _area_normal(rings: Sequence[Float]) -> Float:
    """Normal times area (3,) m2 by Newell's sum; holes run the other way round and take away."""
    total = np.zeros(3)
    for r in rings:
        p = r - r[0]
        total += 0.5 * np.cross(p[1:-1], p[2:]).sum(0)
    return total


def _classes(kept: Sequence[tuple[Face, list[Float]]], normals: Float, lod: str) -> list[str]:
    """The class that the file says, else by the normal: upright a wall, level at the foot ground, else roof.

    Where sides are not told apart (no solid) a level polygon at the foot is the ground.
    """
    if not kept:
        return []
    lengths = np.maximum(np.linalg.norm(normals, axis=1), 1e-300)
    up = normals[:, 2] / lengths
    heights = np.array([rings[0][:, 2].mean() for _, rings in kept])
    foot = min(float(rings[0][:, 2].min()) for _, rings in kept)
    lowest = heights - foot < 0.05
    guessed = np.where(np.abs(up) < _UPRIGHT, "WallSurface", "RoofSurface")
    level = np.abs(up) >= _UPRIGHT
    guessed = np.where(level & (up < 0), "OuterCeilingSurface", guessed)
    guessed = np.where(level & lowest, "GroundSurface", guessed)
    return [face.semantics or str(g) for (face, _), g in zip(kept, guessed, strict=True)]


def _names(ids: Sequence[str], owner: str) -> list[str]:
    """Every polygon's own name: its id, numbered where several share one, else owner and number."""
    seen: Counter[str] = Counter()
    names = []
    for number, name in enumerate(ids):
        seen[name] += bool(name)
        names.append(f"{owner}/{number}" if not name else name if seen[name] == 1 else f"{name}#{seen[name]}")
    return names
