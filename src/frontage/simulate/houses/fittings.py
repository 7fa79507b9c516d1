"""Draws what is fixed to a facade: sills, surrounds, shutters, bands, balconies, oriels."""

import numpy as np
import shapely

from frontage.geometry.ring import at_depth, rectangle
from frontage.simulate.houses.elevation import Balcony, Band, Elevation, Oriel
from frontage.simulate.houses.palette import Palette
from frontage.simulate.houses.placements import oriel_wall, shutter_leaves
from frontage.simulate.meshing import Pen, inset
from frontage.simulate.scene import OpeningPlan, Part

_BALUSTER_M, _PITCH_M = 0.016, 0.115  # thickness and spacing of railing bars


def draw_fittings(pen: Pen, elevation: Elevation, palette: Palette) -> None:
    """Draw everything on an elevation but the openings themselves."""
    for k, (plan, dressing) in enumerate(zip(elevation.openings, elevation.dressings, strict=True)):
        own = pen.with_prefix(plan.id, opening=k)
        if dressing.sill and plan.kind != "door":
            _sill(own, plan, dressing.sill, palette)
        if dressing.surround:
            _surround(own, plan, dressing.surround, palette)
        if plan.shutters == "open":
            _open_shutters(own, plan, palette)
    for band in elevation.bands:
        _band(pen, band, palette)
    for k, balcony in enumerate(elevation.balconies):
        _balcony(pen.with_prefix(f"{elevation.id}/balcony{k + 1}"), balcony, palette)
    for k, oriel in enumerate(elevation.oriels):
        _oriel(pen.with_prefix(f"{elevation.id}/oriel{k + 1}"), oriel, elevation, palette)


def polygon_block(pen: Pen, surface: int, polygon: shapely.Polygon, y0: float, y1: float) -> None:
    """Draw a block with a polygon's outline, holes included, without its back."""
    ring = np.asarray(shapely.geometry.polygon.orient(polygon).exterior.coords)[:-1]
    holes = [np.asarray(h.coords)[:-1] for h in shapely.geometry.polygon.orient(polygon, -1.0).interiors]
    pen.block(surface, ring, y0, y1, holes=holes, back=False)


def _sill(pen: Pen, plan: OpeningPlan, size: tuple[float, float], palette: Palette) -> None:
    height, projection = size
    (x0, z0), (x1, _) = plan.ring.min(0), plan.ring.max(0)
    surface = pen.surface("sill", Part.SILL, palette.trim)
    low = (x0 - 0.05, plan.wall_y - projection, z0 - height)
    pen.box(surface, low, (x1 + 0.05, plan.wall_y, z0))


def _surround(pen: Pen, plan: OpeningPlan, size: tuple[float, float], palette: Palette) -> None:
    width, projection = size
    surface = pen.surface("surround", Part.CORNICE, palette.trim)
    outer = inset(plan.ring, -width)
    pen.block(surface, outer, plan.wall_y - projection, plan.wall_y, holes=[plan.ring], back=False)


def _open_shutters(pen: Pen, plan: OpeningPlan, palette: Palette) -> None:
    """Draws two leaves that are folded back beside the opening."""
    surface = pen.surface("shutter", Part.SHUTTER, palette.shutter)
    for x0, z0, x1, z1 in shutter_leaves(plan.ring):
        pen.box(surface, (x0, -0.065, z0), (x1, -0.025, z1))


def _band(pen: Pen, band: Band, palette: Palette) -> None:
    own = {"plinth": palette.plinth, "base": palette.ground_floor}
    material = own.get(band.name, palette.trim)
    surface = pen.surface(band.name, band.part, material, roughness=0.0015)
    polygon_block(pen, surface, band.polygon, band.y0, band.y1)


def _balcony(pen: Pen, balcony: Balcony, palette: Palette) -> None:
    x0, x1, z, y0 = balcony.x0, balcony.x1, balcony.z, -balcony.projection
    slab = pen.surface("slab", Part.BALCONY, palette.trim)
    pen.box(slab, (x0, y0, z - balcony.thickness), (x1, 0.0, z))
    top = z + balcony.height
    if balcony.style == "solid":
        rail = pen.surface("parapet", Part.RAILING, palette.wall)
        pen.box(rail, (x0, y0, z), (x1, y0 + 0.1, top))
        pen.box(rail, (x0, y0 + 0.1, z), (x0 + 0.1, 0.0, top))
        pen.box(rail, (x1 - 0.1, y0 + 0.1, z), (x1, 0.0, top))
        return
    rail = pen.surface("railing", Part.RAILING, palette.metal)
    for low, high in ((top - 0.04, top), (z + 0.08, z + 0.11)):
        pen.box(rail, (x0, y0, low), (x1, y0 + 0.04, high))
        pen.box(rail, (x0, y0 + 0.04, low), (x0 + 0.04, 0.0, high))
        pen.box(rail, (x1 - 0.04, y0 + 0.04, low), (x1, 0.0, high))
    along = np.linspace(x0 + 0.02, x1 - 0.02, max(2, int((x1 - x0) / _PITCH_M) + 1))
    across = np.linspace(y0 + 0.02, -0.02, max(2, int(-y0 / _PITCH_M) + 1))[1:]
    feet = [(x, y0 + 0.02) for x in along] + [(x, y) for y in across for x in (x0 + 0.02, x1 - 0.02)]
    half = _BALUSTER_M / 2
    for x, y in feet:
        pen.box(rail, (x - half, y - half, z), (x + half, y + half, top - 0.04))


def _oriel(pen: Pen, oriel: Oriel, elevation: Elevation, palette: Palette) -> None:
    """Draws an oriel: front with the holes of its openings, cheeks, underside and top, open to the house."""
    y = -oriel.projection
    surface = pen.surface("wall", Part.ORIEL, palette.wall)
    front = oriel_wall(oriel)
    holes = [o.ring for o in elevation.openings if o.wall_y == y]
    pen.plate(surface, front, y, holes)
    at_wall = at_depth(oriel.ring, 0.0)
    ahead = at_depth(front, y)
    for a, b in ((0, 3), (1, 2)):
        cheek = np.array([at_wall[a], ahead[a], ahead[b], at_wall[b]])
        pen.polygon(surface, cheek if a == 0 else cheek[::-1])
    pen.polygon(surface, np.array([at_wall[0], at_wall[1], ahead[1], ahead[0]]))
    roof = pen.surface("roof", Part.ORIEL, palette.roof)
    pen.polygon(roof, np.array([ahead[3], ahead[2], at_wall[2], at_wall[3]]))


def draw_steps(pen: Pen, plan: OpeningPlan, ground: float, palette: Palette) -> None:
    """Draw steps up to a door whose threshold lies above the pavement (`ground`, m)."""
    (x0, z0), (x1, _) = plan.ring.min(0), plan.ring.max(0)
    climb = z0 - ground
    if climb < 0.1:
        return
    surface = pen.surface("steps", Part.PLINTH, palette.plinth)
    count = max(1, round(climb / 0.17))
    for k in range(count):
        ring = rectangle(x0 - 0.2, -0.5, x1 + 0.2, 0.0)
        low, high = ground - 1.0, z0 - 0.02 - climb * k / count
        pen.box(surface, (ring[:, 0].min(), -0.3 * (k + 1), low), (ring[:, 0].max(), -0.3 * k, high))
