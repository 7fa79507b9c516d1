"""The LoD3 model as textured meshes, with ortho-images on the walls and plain colours elsewhere."""

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from frontage.exports.facades import FacadePicture, limit_texture
from frontage.exports.triangles import KINDS, ModelTriangles, model_triangles, unique_vertices
from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.io.meshes.glb import GlbMaterial, GlbMesh, GlbPiece
from frontage.model import OPENING_SURFACES
from frontage.solids import Assembled

Colour = tuple[float, float, float]

COLOURS: dict[str, Colour] = {
    "WallSurface": (0.62, 0.57, 0.50),
    "RoofSurface": (0.36, 0.20, 0.15),
    "GroundSurface": (0.30, 0.30, 0.30),
    "OuterCeilingSurface": (0.50, 0.47, 0.43),
    "OuterFloorSurface": (0.50, 0.48, 0.46),
    **{name: surface.colour for name, surface in OPENING_SURFACES.items()},
    "Installation": (0.55, 0.53, 0.51),
}
"""Linear RGB, 0..1, of surfaces that no picture shows."""

_FACING_COS = 0.96  # of the largest angle between a surface and the facade whose picture it takes
_GLASS_ROUGHNESS = 0.15  # of the glTF material


def building_mesh(assembled: Assembled, pictures: Sequence[FacadePicture], reach: float) -> GlbMesh:
    """Makes a building one mesh with one piece per picture and per plain colour.

    Walls, windows and doors that lie within `reach` m of the plane of a facade and are parallel to it show
    its ortho-image, projected along the normal. Walls without a picture take the mean colour of all pictures.
    """
    shapes = model_triangles(assembled)
    centre = np.rint(shapes.corners.reshape(-1, 3).mean(0)) if len(shapes) else np.zeros(3)
    matrix = np.eye(4)
    matrix[:3, 3] = centre
    pieces: list[GlbPiece] = []
    left = np.ones(len(shapes), np.bool_)
    for picture in pictures:
        uv = _texture_coordinates(shapes.corners, picture)
        shown = left & _shown(shapes, picture, uv, reach)
        left &= ~shown
        if shown.any():
            rows, faces = unique_vertices(shapes.corners[shown] - centre, uv[shown])
            material = GlbMaterial(picture.facade.id, limit_texture(picture.jpeg))
            pieces.append(GlbPiece(material, rows[:, :3], faces, uv=rows[:, 3:]))
    pieces += _plain(shapes, left, centre, _mean_colour(pictures))
    extras = {"building": assembled.building, "host": assembled.coarse.source, "lod": "3"}
    return GlbMesh(assembled.building, tuple(pieces), matrix, extras)


def _texture_coordinates(corners: Float, picture: FacadePicture) -> Float:
    """Texture coordinates (t, 3, 2) of corners (t, 3, 3) in a picture, 0..1, v downwards."""
    x, _, z = np.moveaxis(picture.facade.frame.inverse.apply(corners.reshape(-1, 3)), 1, 0)
    width, height = picture.size
    u = (x - picture.corner[0]) / (picture.gsd * width)
    v = (picture.corner[1] - z) / (picture.gsd * height)
    return np.column_stack([u, v]).reshape(-1, 3, 2)


def _shown(shapes: ModelTriangles, picture: FacadePicture, uv: Float, reach: float) -> Bool:
    """Which triangles (t,) a picture shows: parallel to its plane, near it, two corners within it."""
    frame = picture.facade.frame
    facing = shapes.normals @ -frame.R[:, 1] > _FACING_COS
    y = frame.inverse.apply(shapes.corners.mean(1))[:, 1]
    within = ((uv > -0.02) & (uv < 1.02)).all(2).sum(1) >= 2
    kinds = [KINDS.index(k) for k in ("WallSurface", *OPENING_SURFACES)]
    return np.asarray(facing & (np.abs(y) < reach) & within & np.isin(shapes.kind, kinds))


def _plain(shapes: ModelTriangles, left: Bool, centre: Float, wall: Colour | None) -> list[GlbPiece]:
    """One piece per colour of the triangles that are `left`, relative to `centre` (3,) m local."""
    found = []
    for number, name in enumerate(KINDS):
        own: Int = np.flatnonzero(left & (shapes.kind == number))
        if len(own):
            colour = wall if name == "WallSurface" and wall is not None else COLOURS[name]
            material = GlbMaterial(name, None, colour, _GLASS_ROUGHNESS if name == "Window" else 1.0)
            normals = np.repeat(shapes.normals[own][:, None], 3, axis=1)
            rows, faces = unique_vertices(shapes.corners[own] - centre, normals)
            found.append(GlbPiece(material, rows[:, :3], faces, normals=rows[:, 3:]))
    return found


def _mean_colour(pictures: Sequence[FacadePicture]) -> Colour | None:
    """Returns the mean of the median colours of all pictures, as linear RGB; None without pictures."""
    means: list[Array] = []
    for picture in pictures:
        image: Any = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_REDUCED_COLOR_8)
        means.append(np.median(image.reshape(-1, 3), axis=0)[::-1] / 255.0)
    if not means:
        return None
    r, g, b = (np.mean(means, axis=0) ** 2.2).tolist()
    return r, g, b
