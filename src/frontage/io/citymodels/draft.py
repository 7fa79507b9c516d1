"""Buildings as a file holds them, and their conversion to buildings in local metres.

The readers of every format fill drafts. What the polygons of a draft need before they can be used
(coordinates, clean rings, a class, an outside) is done here, once for all formats.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Bool, Float, Int
from frontage.io.citymodels.block import block
from frontage.model import Failed, Surface
from frontage.model.citymodel import FRAME, CityBuilding, Shell, Texture

Value = str | float | int

_WALL_LEAN_DEG = 15.0  # a polygon that leans less is a wall
_UPRIGHT = np.sin(np.radians(_WALL_LEAN_DEG))  # the largest z of a wall's unit normal
_SAME_M = 1e-6  # corners closer than this are one
_FOOT_M = 0.05  # the ground lies no more than this above the lowest corner
_CORNERS = 3  # of a ring, at least
_FLAT_M2 = 1e-8  # a polygon smaller than this has no plane


@dataclass(eq=False)
class DraftFace:
    """A polygon of a file.

    rings      (k, 3) in file coordinates, the outer one first, closed or not; empty for a broken polygon
    semantics  its class, such as "WallSurface", where the file states one
    about      its attributes
    names      the ids of its rings
    texture    with a position in the picture for every corner of the file
    """

    rings: Sequence[Float]
    semantics: str | None = None
    id: str = ""
    about: dict[str, Value] = field(default_factory=dict)
    names: Sequence[str] = ()
    texture: Texture | None = None


@dataclass(eq=False)
class DraftShell:
    """One geometry of a building.

    lod           level of detail
    closed        whether it is a solid
    part          id of the part or installation that it belongs to; "" for the building itself
    installation  whether that is an installation
    attributes    of the part
    frame_of      id of the opening whose frame and bars these are
    """

    lod: str
    faces: list[DraftFace]
    closed: bool
    part: str = ""
    installation: bool = False
    attributes: dict[str, Value] = field(default_factory=dict)
    frame_of: str = ""

    def describe(self, installation: bool, attributes: dict[str, Value]) -> None:
        """Take over what the file says of the part; its attributes tell whether it is a window's frame."""
        self.attributes = attributes
        self.frame_of = str(attributes.get("opening", "")) if attributes.get("kind") == FRAME else ""
        self.installation = installation or bool(self.frame_of)


@dataclass(eq=False)
class BuildingDraft:
    """A building of a file.

    problems  what could not be read, one short phrase each
    height    m: the footprint of level 0 is extruded by this much to a block of level 1
    """

    id: str
    shells: list[DraftShell] = field(default_factory=list)
    address: str | None = None
    attributes: dict[str, Value] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)
    height: float | None = None

    def points(self) -> Float:
        """Every corner (n, 3) in file coordinates."""
        rings = [r for shell in self.shells for face in shell.faces for r in face.rings]
        return np.concatenate([np.zeros((0, 3)), *rings])


def finish(
    draft: BuildingDraft, to_local: Callable[[Float], Float]
) -> tuple[CityBuilding | None, Failed | None]:
    """Make a building in local metres, and say what of it could not be used.

    `to_local` converts file coordinates (n, 3) to local metres. The building is None when nothing of it can
    be used; the failure is None when everything can.
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
    """The usable polygons of a geometry with their classes; a solid that is inside out is turned."""
    rings = _Rings.of([r for f in draft.faces for r in f.rings], to_local)
    firsts = np.cumsum([0, *(len(f.rings) for f in draft.faces)])
    kept: list[int] = []
    for k in range(len(draft.faces)):
        if not draft.faces[k].rings:
            continue  # broken in the file; the reader has reported it
        if trouble := rings.trouble(firsts[k], firsts[k + 1]):
            found[trouble] += 1
        else:
            kept.append(k)
    normals = np.array([rings.normals[firsts[k] : firsts[k + 1]].sum(0) for k in kept]).reshape(-1, 3)
    polygons = [[r for r in rings.parts[firsts[k] : firsts[k + 1]] if len(r) >= _CORNERS] for k in kept]
    textures = [_texture(draft.faces[k], rings.kept[firsts[k] : firsts[k + 1]]) for k in kept]
    if draft.closed and kept and _inside_out(polygons, normals):
        textures = [t and Texture(t.image, tuple(r[::-1] for r in t.rings)) for t in textures]
        polygons, normals = [[r[::-1] for r in polygon] for polygon in polygons], -normals
    faces = [draft.faces[k] for k in kept]
    framed = draft.frame_of and not any(face.semantics for face in faces)
    classes = [""] * len(faces) if framed else _classes(faces, polygons, normals)
    names = _names([face.id for face in faces], draft.part or building)
    surfaces = tuple(
        Surface(polygon[0], kind, name, tuple(polygon[1:]))
        for polygon, kind, name in zip(polygons, classes, names, strict=True)
    )
    about = {name: face.about for face, name in zip(faces, names, strict=True) if face.about}
    pictures = {name: t for t, name in zip(textures, names, strict=True) if t is not None}
    return Shell(
        draft.lod, surfaces, about, draft.closed, draft.part, draft.installation, pictures, draft.attributes,
        draft.frame_of,
    )  # fmt: skip


def _texture(face: DraftFace, kept: Sequence[Bool]) -> Texture | None:
    """The texture of a polygon at the corners that were kept; None when it does not fit the corners."""
    t = face.texture
    if t is None or [len(r) for r in t.rings] != [len(k) for k in kept]:
        return None
    places = [r[k] for r, k in zip(t.rings, kept, strict=True)]
    return Texture(t.image, tuple(p for i, p in enumerate(places) if i == 0 or len(p) >= _CORNERS))


@dataclass(eq=False)
class _Rings:
    """Rings in local metres without repeated corners.

    parts    (k, 3) m per ring
    kept     (n,) per ring: which corners of the file these are
    normals  (r, 3) m2: unit normal times area of every ring
    finite   (r,) whether all coordinates of a ring are finite
    """

    parts: list[Float]
    kept: list[Bool]
    normals: Float
    finite: Bool

    @classmethod
    def of(cls, rings: Sequence[Float], to_local: Callable[[Float], Float]) -> "_Rings":
        """Convert all rings of a geometry at once; closing points and repeated corners are dropped."""
        count = len(rings)
        points = np.concatenate([np.zeros((0, 3)), *rings])
        owner = np.repeat(np.arange(count), [len(r) for r in rings])
        usable = np.isfinite(points).all(1)
        local: Float = np.full(points.shape, np.nan)
        if usable.any():
            local[usable] = to_local(points[usable])
        keep = ~(np.abs(local - local[_neighbour(owner, count)]).max(1, initial=0.0) <= _SAME_M)
        kept = np.split(keep, np.cumsum([len(r) for r in rings])[:-1]) if count else []
        local, owner = local[keep], owner[keep]
        sizes = np.bincount(owner, minlength=count)
        begins = np.cumsum(sizes) - sizes
        arms = local - local[begins[owner]] if len(local) else local
        cross = _cross(arms, arms[_neighbour(owner, count)])
        normals = np.stack([np.bincount(owner, c, minlength=count) for c in cross.T], axis=1) / 2
        finite = np.bincount(owner, ~np.isfinite(local).all(1), minlength=count) == 0
        return cls(np.split(local, np.cumsum(sizes)[:-1]) if count else [], kept, normals, finite)

    def trouble(self, first: int, end: int) -> str:
        """Why the polygon of rings `first` to `end` cannot be used; "" when it can."""
        if len(self.parts[first]) < _CORNERS:
            return "a polygon with fewer than 3 corners"
        if not self.finite[first:end].all():
            return "a coordinate that is not a number"
        return "a polygon without area" if np.linalg.norm(self.normals[first]) < _FLAT_M2 else ""


def _neighbour(owner: Int, count: int) -> Int:
    """The corner (n,) that follows each corner in its ring; `owner` (n,) is the ring of each corner."""
    sizes = np.bincount(owner, minlength=count)
    begins = (np.cumsum(sizes) - sizes)[owner]
    place: Int = np.arange(len(owner)) - begins
    return begins + (place + 1) % np.maximum(sizes[owner], 1)


def _cross(a: Float, b: Float) -> Float:
    """The cross product row by row; `np.cross` takes several times as long for small arrays."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)


def _inside_out(polygons: Sequence[Sequence[Float]], normals: Float) -> bool:
    """Whether the volume of a closed shell is negative."""
    anchors = np.array([polygon[0][0] for polygon in polygons])
    return bool(np.einsum("ij,ij->", anchors - anchors.mean(0), normals) < 0.0)


def _classes(faces: Sequence[DraftFace], polygons: Sequence[Sequence[Float]], normals: Float) -> list[str]:
    """The class of every polygon: what the file states, else what its normal and height suggest.

    An upright polygon is a wall, a level one at the foot of the building is the ground, another one that
    faces down is an outer ceiling, and the others are roofs. In a geometry that is not a solid, where a
    normal does not tell the outside, a level polygon at the foot is the ground all the same.
    """
    if all(face.semantics for face in faces):
        return [str(face.semantics) for face in faces]
    up = normals[:, 2] / np.linalg.norm(normals, axis=1)
    heights = np.array([polygon[0][:, 2].mean() for polygon in polygons])
    foot = min(float(polygon[0][:, 2].min()) for polygon in polygons)
    guessed = np.where(np.abs(up) < _UPRIGHT, "WallSurface", "RoofSurface")
    level = np.abs(up) >= _UPRIGHT
    guessed = np.where(level & (up < 0), "OuterCeilingSurface", guessed)
    guessed = np.where(level & (heights - foot < _FOOT_M), "GroundSurface", guessed)
    return [face.semantics or str(g) for face, g in zip(faces, guessed, strict=True)]


def _names(ids: Sequence[str], owner: str) -> list[str]:
    """A unique name for every polygon: its id, numbered where several share one, else owner and number."""
    seen: Counter[str] = Counter()
    names = []
    for number, name in enumerate(ids):
        seen[name] += bool(name)
        names.append(f"{owner}/{number}" if not name else name if seen[name] == 1 else f"{name}#{seen[name]}")
    return names
