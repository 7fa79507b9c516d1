"""Bundles for users: the textured facade model, buildings for a city model."""

from frontage.exports.drawn import drawn
from frontage.exports.facades import FacadePicture, facade_mesh, limit_texture, triangulate
from frontage.exports.lod3 import city_building, city_buildings
from frontage.exports.model3d import building_mesh
from frontage.exports.picture import picture

__all__ = [
    "FacadePicture",
    "building_mesh",
    "city_building",
    "city_buildings",
    "drawn",
    "facade_mesh",
    "limit_texture",
    "picture",
    "triangulate",
]
