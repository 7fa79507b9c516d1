"""The nouns of a simulated street: triangles that know their surface, and the plans they were built from.

Frames: *local* has the scene's own origin (integer metres, see `Scene.world`). In the *street* frame, s runs
along the street, d points into the houses of side 0 (the near side) and z points up. A *facade* frame has its
origin on the main plane at the lower left corner; x points right as seen from the street, y into the building
and z up. All lengths are in metres.
"""

from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np

from frontage.geometry.arrays import Array, Float, Int, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import WorldRef
from frontage.model.built import BuiltOpening


class Part(IntEnum):
    """The building part or object that a surface belongs to."""

    GROUND = 0
    WALL = 1
    ROOF = 2
    REVEAL = 3
    FRAME = 4
    BAR = 5
    PANE = 6
    LEAF = 7  # of a door or gate
    SHUTTER = 8
    SILL = 9
    PLINTH = 10
    CORNICE = 11
    BALCONY = 12
    RAILING = 13
    ORIEL = 14
    ROOM = 15  # inside of a house, curtains and furniture included
    TREE = 16
    CAR = 17
    LAMP = 18
    PERSON = 19
    DORMER = 20
    CHIMNEY = 21


@dataclass(frozen=True)
class SurfaceMaterial:
    """How a surface appears to a camera and to a laser.

    kind        texture: "plaster", "brick", "ashlar", "stone", "wood", "metal", "glass", "tiles", "asphalt",
                "paving", "leaves", "fabric", "paint"
    rgb         linear reflectance of the base colour, 0..1
    rgb_joint   linear reflectance of joints, stains or the second tone, 0..1
    laser       diffuse reflectance at the laser's wavelength, 0..1, only loosely tied to the colour
    gloss       share of the reflection that lies in a lobe about the mirror direction, 0..1
    size        m, width and height of one unit of the texture (brick, stone, tile), where it has units
    seed        seed of the texture's random fields
    """

    name: str
    kind: str
    rgb: tuple[float, float, float]
    rgb_joint: tuple[float, float, float]
    laser: float
    gloss: float = 0.0
    size: tuple[float, float] = (0.25, 0.075)
    seed: int = 0


@dataclass(frozen=True)
class SceneSurface:
    """One surface of the scene; every triangle belongs to exactly one.

    id          readable identifier, such as "B02/F1/W3-2/frame"
    house, facade, opening   indices into `Scene.houses`, `House.facades`, `FacadePlan.openings`; -1 = none
    origin, u, v             texture plane, local m: coordinates are ((P - origin) . u, (P - origin) . v)
    roughness   m, standard deviation of the surface's height (0 = smooth)
    correlation m, distance over which that height is correlated
    """

    id: str
    part: Part
    material: int
    house: int = -1
    facade: int = -1
    opening: int = -1
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    u: tuple[float, float, float] = (1.0, 0.0, 0.0)
    v: tuple[float, float, float] = (0.0, 0.0, 1.0)
    roughness: float = 0.0
    correlation: float = 0.3


@dataclass(frozen=True, eq=False)
class SceneMesh:
    """Triangles: vertices (v, 3) m local, corners (t, 3) int64 into them, surface (t,) int32 per triangle.

    Corners are counter-clockwise as seen from outside; panes and leaves are sheets without thickness.
    """

    vertices: Float
    corners: Int
    surface: Array

    def __post_init__(self) -> None:
        freeze(self, vertices=((None, 3), np.float64), corners=((None, 3), np.int64))
        freeze(self, surface=((len(self.corners),), np.int32))

    @property
    def normals(self) -> Float:
        """Outward unit normals (t, 3); zero for a triangle without area."""
        a, b, c = (self.vertices[self.corners[:, k]] for k in range(3))
        n = np.cross(b - a, c - a)
        length = np.linalg.norm(n, axis=1, keepdims=True)
        return np.asarray(n / np.where(length > 0, length, 1.0))


@dataclass(frozen=True, eq=False)
class OpeningPlan(BuiltOpening):
    """An opening as planned, with what drawing it takes.

    glass_depth   m, from the wall's plane to the pane
    frame_width   m
    floor, bay    number of the storey (0 = ground floor, -1 = basement), and place in it from the left
    ajar          x0, z0, x1, z1 m of a casement that is turned inwards, and by how much, rad (positive: it
                  hangs on its left side); None = all are closed
    meeting       m (z), where two sashes meet, of which the lower one stands behind the upper one; or None
    """

    glass_depth: float
    frame_width: float
    floor: int = 0
    bay: int = 0
    meeting: float | None = field(default=None, kw_only=True)
    ajar: tuple[float, float, float, float, float] | None = field(default=None, kw_only=True)


@dataclass(frozen=True, eq=False)
class ProtrusionPlan:
    """A piece in front of (or behind) the main plane: a balcony, an oriel, a cornice, a dormer.

    ring      outline (k, 2) m (x, z)
    y_range   m, y of its near and its far end
    front     outline (k, 2) m of the near end where that is smaller (a slanted oriel), corner by corner
    """

    id: str
    kind: str
    ring: Float
    y_range: tuple[float, float]
    front: Float | None = None

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 2), np.float64), front=((None, 2), np.float64))


@dataclass(frozen=True, eq=False)
class FacadePlan:
    """One facade as built: its frame, the wall's outline (k, 2) m (x, z), openings, protrusions.

    roughness   m, standard deviation of the wall's surface
    """

    id: str
    local_from_facade: Rigid3
    outline: Float
    openings: tuple[OpeningPlan, ...] = ()
    protrusions: tuple[ProtrusionPlan, ...] = ()
    roughness: float = 0.0

    def __post_init__(self) -> None:
        freeze(self, outline=((None, 2), np.float64))


@dataclass(frozen=True, eq=False)
class House:
    """One building as built.

    side        side of the street: 0 = near, 1 = opposite
    footprint   (k, 2) m local; ground_z, eaves_z and ridge_z are heights, m local
    shell       the closed LoD2 shell without openings and fittings: pairs of semantics ("WallSurface",
                "RoofSurface", "GroundSurface") and ring (k, 3) m local
    twin_of     id of the house that it repeats, if any
    """

    id: str
    address: str
    side: int
    footprint: Float
    ground_z: float
    eaves_z: float
    ridge_z: float
    facades: tuple[FacadePlan, ...]
    shell: tuple[tuple[str, Float], ...] = ()
    twin_of: str | None = None

    def __post_init__(self) -> None:
        freeze(self, footprint=((None, 2), np.float64))


@dataclass(frozen=True, eq=False)
class Scene:
    """A simulated street: geometry, materials and plans.

    road    centre line (k, 3) m local that vehicles drive along
    notes   one sentence for everything that was asked for and could not be built
    """

    name: str
    seed: int
    world: WorldRef
    local_from_street: Rigid3
    mesh: SceneMesh
    surfaces: tuple[SceneSurface, ...]
    materials: tuple[SurfaceMaterial, ...]
    houses: tuple[House, ...]
    road: Float
    notes: tuple[str, ...] = field(default=())

    def __post_init__(self) -> None:
        freeze(self, road=((None, 3), np.float64))

    @property
    def parts(self) -> Array:
        """`Part` (s,) uint8 of every surface."""
        return np.array([s.part for s in self.surfaces], np.uint8)
