"""An installation as a closed solid between a wall and the front of the protrusion."""

from dataclasses import dataclass

import numpy as np

from frontage.geometry.arrays import Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.model import Face, Failed, Protrusion, ProtrusionKind, Solid, WorldRef
from frontage.solids.brep import GRID_PER_M, newell_normal
from frontage.solids.installations.shapes import installation_shape
from frontage.validation.validate import validate

_STEEP = 0.5  # a face whose normal has a smaller vertical component is a wall, not a floor, roof or ceiling


@dataclass(frozen=True, eq=False)
class Installation:
    """Something attached to a facade.

    solid    its closed solid
    assumed  in words, what of its shape was assumed
    closed   whether it is a solid in the model; one that reaches into another solid is kept as surfaces
    """

    id: str
    kind: ProtrusionKind
    facade: str
    solid: Solid
    assumed: str = ""
    closed: bool = True


@dataclass(frozen=True, eq=False)
class Attachment:
    """Where a protrusion is attached to a host.

    local_from_wall  facade frame whose plane y = 0 is the wall
    ring             (k, 2) m (x, z): the outline of the protrusion in that frame
    back             y (m) at which the installation ends, just in front of what the protrusion stands on
    """

    local_from_wall: Rigid3
    ring: Float
    back: float


def make_installation(
    protrusion: Protrusion, facade: str, place: Attachment, world: WorldRef
) -> Installation | Failed:
    """Makes a protrusion a closed solid between its wall and its front.

    A balcony becomes a slab with a parapet on its three free sides, an awning a sloping sheet, everything
    else its outline extruded from the wall. Returns S318 if the solid is not valid.
    """
    front = float(protrusion.front.value)
    (xyz, faces), assumed = installation_shape(protrusion.kind, place.ring, front, place.back)
    grid = np.rint(place.local_from_wall.apply(xyz) * GRID_PER_M).astype(np.int64)
    solid = Solid(
        protrusion.id,
        grid,
        world.origin,
        tuple(Face(f, _semantics(grid, f, protrusion.kind)) for f in faces),
        "3",
    )
    if findings := validate(solid):
        text = f"{protrusion.id}: its solid is not valid ({findings[0].code} {findings[0].message})"
        return Failed("S318", text)
    return Installation(protrusion.id, protrusion.kind, facade, solid, assumed)


def _semantics(grid: Int, face: tuple[int, ...], kind: ProtrusionKind) -> str:
    """Returns the CityGML class of a face by the direction it looks in."""
    up = float(newell_normal(grid[list(face)] / GRID_PER_M)[2])
    if abs(up) < _STEEP:
        return "WallSurface"
    return (
        "OuterCeilingSurface"
        if up < 0
        else "OuterFloorSurface"
        if kind is ProtrusionKind.BALCONY
        else "RoofSurface"
    )
