"""What is made for users from the finished nouns: textured models, city models and pictures of them.

`city_buildings` turns the solids of a building into LoD2 and LoD3 shells with the attributes of their
openings (paper B, section 3), `building_mesh` and `facade_mesh` lay the ortho-images on the walls (paper A,
sections 3 and 4), and `render_model` draws the model as seen from the street. The files are written by `io`.
"""

from frontage.exports.appearance import painted, texture_path
from frontage.exports.facades import FacadePicture, facade_mesh, limit_texture, triangulate
from frontage.exports.lod3 import city_building, city_buildings
from frontage.exports.model3d import building_mesh
from frontage.exports.modelpicture import render_model
from frontage.exports.triangles import model_triangles

__all__ = [
    "FacadePicture",
    "building_mesh",
    "city_building",
    "city_buildings",
    "facade_mesh",
    "limit_texture",
    "model_triangles",
    "painted",
    "render_model",
    "texture_path",
    "triangulate",
]
