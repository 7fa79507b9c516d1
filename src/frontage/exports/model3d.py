"""The LoD3 model as textured meshes: ortho-images on the walls that they show, plain colours elsewhere."""

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np

from frontage.exports.drawn import KINDS, Drawn, drawn, unique_vertices
from frontage.exports.facades import FacadePicture, limit_texture
from frontage.geometry.arrays import Array, Bool, Float, Int
from frontage.io.meshes.glb import GlbMaterial, GlbMesh, GlbPiece
from frontage.solids import Assembled

Colour = tuple[float, float, float]

COLOURS: dict[str, Colour] = {
    "WallSurface": (0.62, 0.57, 0.50),
    "RoofSurface": (0.36, 0.20, 0.15),
    "GroundSurface": (0.30, 0.30, 0.30),
    "OuterCeilingSurface": (0.50, 0.47, 0.43),
    "OuterFloorSurface": (0.50, 0.48, 0.46),
    "Window": (0.10, 0.16, 0.22),
    "Door": (0.20, 0.12, 0.07),
    "Installation": (0.55, 0.53, 0.51),
}
"""Linear colours where no picture shows a surface."""

_FACING = 0.96  # cosine between a surface and the facade whose picture it takes
_GLOSS = 0.15  # roughness of glass


def building_mesh(assembled: Assembled, pictures: Sequence[FacadePicture], reach: float) -> GlbMesh:
    """A building as one mesh, a piece per picture and per plain colour.

    Walls, windows and doors within `reach` m of a facade's plane and parallel to it take the ortho-image,
    projected along the facade's normal; walls without a picture take the mean colour of all pictures.
    """
    shapes = drawn(assembled)
    centre = np.rint(shapes.corners.reshape(-1, 3).mean(0)) if len(shapes) else np.zeros(3)
    matrix = np.eye(4)
    matrix[:3, 3] = centre
    pieces: list[GlbPiece] = []
    left = np.ones(len(shapes), np.bool_)
    for picture in pictures:
        uv = _places(shapes.corners, picture)
        shown = left & _shown(shapes, picture, uv, reach)
        left &= ~shown
        if shown.any():
            rows, faces = unique_vertices(shapes.corners[shown] - centre, uv[shown])
            material = GlbMaterial(picture.facade.id, limit_texture(picture.jpeg))
            pieces.append(GlbPiece(material, rows[:, :3], faces, uv=rows[:, 3:]))
    pieces += _plain(shapes, left, centre, _mean_colour(pictures))
    extras = {"building": assembled.building, "host": assembled.coarse.source, "lod": "3"}
    return GlbMesh(assembled.building, tuple(pieces), matrix, extras)


def _places(corners: Float, picture: FacadePicture) -> Float:
    """Places (t, 3, 2) of corners in a picture, 0..1, v downwards."""
    x, _, z = np.moveaxis(picture.facade.frame.inverse.apply(corners.reshape(-1, 3)), 1, 0)
    width, height = picture.size
    u = (x - picture.corner[0]) / (picture.gsd * width)
    v = (picture.corner[1] - z) / (picture.gsd * height)
    return np.column_stack([u, v]).reshape(-1, 3, 2)


def _shown(shapes: Drawn, picture: FacadePicture, uv: Float, reach: float) -> Bool:
    """Which triangles a picture shows: parallel to its plane, near it, most of them within it."""
    frame = picture.facade.frame
    facing = shapes.normals @ -frame.R[:, 1] > _FACING
    y = frame.inverse.apply(shapes.corners.mean(1))[:, 1]
    within = ((uv > -0.02) & (uv < 1.02)).all(2).sum(1) >= 2
    kinds = [KINDS.index(k) for k in ("WallSurface", "Window", "Door")]
    return np.asarray(facing & (np.abs(y) < reach) & within & np.isin(shapes.kind, kinds))


def _plain(shapes: Drawn, left: Bool, centre: Float, wall: Colour | None) -> list[GlbPiece]:
    found = []
    for number, name in enumerate(KINDS):
        own: Int = np.flatnonzero(left & (shapes.kind == number))
        if len(own):
            colour = wall if name == "WallSurface" and wall is not None else COLOURS[name]
            material = GlbMaterial(name, None, colour, _GLOSS if name == "Window" else 1.0)
            normals = np.repeat(shapes.normals[own][:, None], 3, axis=1)
            rows, faces = unique_vertices(shapes.corners[own] - centre, normals)
            found.append(GlbPiece(material, rows[:, :3], faces, normals=rows[:, 3:]))
    return found


def _mean_colour(pictures: Sequence[FacadePicture]) -> Colour | None:
    """The mean of all pictures as a linear colour."""
    means: list[Array] = []
    for picture in pictures:
        image: Any = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_REDUCED_COLOR_8)
        means.append(np.median(image.reshape(-1, 3), axis=0)[::-1] / 255.0)
    if not means:
        return None
    r, g, b = (np.mean(means, axis=0) ** 2.2).tolist()
    return r, g, b
