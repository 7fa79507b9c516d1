"""Attaches protrusions that do not belong to the building's volume to the walls of its coarse solids."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry import Polygon

from frontage.model import Failed, Protrusion, Solid, WorldRef
from frontage.solids.brep import GRID_PER_M
from frontage.solids.elements import FacadeParts
from frontage.solids.installations.installation import Attachment, Installation, make_installation
from frontage.solids.options import BuildOptions
from frontage.solids.relief import Built, FacadeReliefs, Relief
from frontage.solids.walls import find_walls

_THINNEST_M = 0.02  # a protrusion that stands out by less is left out
_UNEVEN_M = 0.005  # largest distance of a wall's corner from its plane, as for the walls of a coarse solid
_ROUNDING = 0.5 * 3**0.5  # of a corner to the grid, in steps: half a step along each axis
_GAP = 1.0  # steps of the grid that stay free between an installation and what it stands on


def attach(
    part: FacadeParts, built: Sequence[Built], world: WorldRef, options: BuildOptions
) -> list[Installation | Failed | str]:
    """Returns every attached protrusion of a facade as an installation in front of the built solids.

    A protrusion that stands out by less than 2 cm becomes a note (str); one that no wall carries, or whose
    solid is not valid, a `Failed` (S310, S318).
    """
    return [_attach_one(p, part.reliefs, built, world, options) for p in part.attached]


def _attach_one(
    protrusion: Protrusion,
    facade: FacadeReliefs,
    built: Sequence[Built],
    world: WorldRef,
    options: BuildOptions,
) -> Installation | Failed | str:
    back = _surface_behind(protrusion, facade.reliefs)
    if back - float(protrusion.front.value) < _THINNEST_M:
        return f"{protrusion.id}: left out because it stands out by less than {_THINNEST_M:g} m"
    place = _best_wall(protrusion, facade, [b.host for b in built], back, options)
    if place is None:
        return Failed("S310", f"{protrusion.id}: no wall of the host is near it", "check the registration")
    return make_installation(protrusion, facade.id, _clear_of(place, [b.solid for b in built]), world)


def _clear_of(place: Attachment, solids: Sequence[Solid]) -> Attachment:
    """Moves the back of an installation just in front of the solids.

    On an oblique wall, rounding to the grid moves the corners of the wall and of the installation off their
    plane, each to its own side. Solids that overlap by a hundredth of a millimetre are not valid (601).
    """
    y = [place.local_from_wall.inverse.apply(s.vertices / GRID_PER_M)[:, 1] for s in solids]
    near = np.concatenate([own[np.abs(own - place.back) <= _UNEVEN_M] for own in y])
    foremost = min(place.back, float(near.min(initial=place.back)))
    return replace(place, back=foremost - (_ROUNDING + _GAP) / GRID_PER_M)


def _best_wall(
    protrusion: Protrusion,
    facade: FacadeReliefs,
    hosts: Sequence[Solid],
    back: float,
    options: BuildOptions,
) -> Attachment | None:
    """Finds the wall that the outline covers most of, else the nearest one within `max_offset`."""
    flat = np.insert(protrusion.ring, 1, 0.0, axis=1)
    place, best = None, -np.inf
    for wall in (w for host in hosts for w in find_walls(host, facade, options)):
        wall_from_facade = wall.local_from_wall.inverse @ facade.local_from_facade
        ring = wall_from_facade.apply(flat)[:, [0, 2]]
        area = shapely.make_valid(Polygon(ring * GRID_PER_M))
        score = sum(float(p.intersection(area).area) for p in wall.polygons)
        # a cornice above the eaves is attached to the wall that ends below it
        score = score or -min(float(p.distance(area)) for p in wall.polygons)
        if score > best and score > -options.max_offset * GRID_PER_M:
            place, best = Attachment(wall.local_from_wall, ring, back), score
    return place


def _surface_behind(protrusion: Protrusion, reliefs: Sequence[Relief]) -> float:
    """Returns the y (m) of the surface a protrusion stands on: of the volume around it, or 0 for the wall."""
    centre = Polygon(protrusion.ring).representative_point()
    for relief in reliefs:
        if relief.semantics == "WallSurface" and relief.depth and Polygon(relief.ring).contains(centre):
            return relief.depth + _surface_behind(protrusion, relief.inside)
    return 0.0
