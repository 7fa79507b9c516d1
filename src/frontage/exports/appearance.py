"""The pictures of facades on the polygons of a city model."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import shapely

from frontage.exports.facades import FacadePicture
from frontage.exports.model3d import FACING_COS
from frontage.geometry.arrays import Float
from frontage.model import OPENING_SURFACES, Surface
from frontage.model.citymodel import CityBuilding, Shell, Texture
from frontage.solids.brep import newell_normal

_PAINTED = ("WallSurface", *OPENING_SURFACES)
_COVERED = 0.5  # of a polygon's area, which a picture must show at least


def texture_path(facade: str) -> str:
    """Return the path of the picture of a facade, relative to the city model: "appearance/B07_F1.jpg"."""
    return f"appearance/{facade.replace('/', '_')}.jpg"


def painted(building: CityBuilding, pictures: Sequence[FacadePicture], reach: float) -> CityBuilding:
    """Return the building with pictures on its walls, windows and doors of every level of detail.

    A polygon shows the picture that covers most of it, projected along the normal, if it is parallel to that
    facade, at most `reach` m before or behind its plane, and covered by half. Window frames and installations
    have no pictures, and neither have polygons that share their id with others.
    """
    shells = tuple(
        s if s.installation else replace(s, textures=dict(_textures(s, pictures, reach)))
        for s in building.shells
    )
    return replace(building, shells=shells)


def _textures(shell: Shell, pictures: Sequence[FacadePicture], reach: float) -> Iterator[tuple[str, Texture]]:
    count = Counter(s.source_id for s in shell.surfaces)
    for s in shell.surfaces:
        if s.semantics in _PAINTED and count[s.source_id] == 1:
            shares = [_share(s, picture, reach) for picture in pictures]
            if shares and max(shares) >= _COVERED:
                yield s.source_id, _texture(s, pictures[int(np.argmax(shares))])


def _share(surface: Surface, picture: FacadePicture, reach: float) -> float:
    """Return the share of a polygon's area that a picture shows; 0 if it faces elsewhere or lies far off."""
    frame = picture.facade.frame
    if newell_normal(surface.ring) @ -frame.R[:, 1] <= FACING_COS:
        return 0.0
    if abs(frame.inverse.apply(surface.ring)[:, 1].mean()) > reach:
        return 0.0
    polygon = shapely.make_valid(shapely.Polygon(_places(surface.ring, picture)))
    return float(polygon.intersection(shapely.box(0, 0, 1, 1)).area / polygon.area) if polygon.area else 0.0


def _texture(surface: Surface, picture: FacadePicture) -> Texture:
    rings = tuple(_places(ring, picture) for ring in (surface.ring, *surface.holes))
    return Texture(texture_path(picture.facade.id), rings)


def _places(ring: Float, picture: FacadePicture) -> Float:
    """Return where corners (k, 3) m local lie in a picture (k, 2), 0..1 to the right and up."""
    x, _, z = picture.facade.frame.inverse.apply(ring).T
    (left, top), (width, height) = picture.corner, (picture.gsd * side for side in picture.size)
    return np.column_stack([(x - left) / width, 1.0 - (top - z) / height])
