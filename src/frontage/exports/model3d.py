"""The LoD3 model as textured meshes, with ortho-images on the walls and plain colours elsewhere."""

from collections.abc import Mapping, Sequence
from typing import Any

import cv2
import numpy as np
import shapely

from frontage.exports.atlas import BEYOND, MAX_TEXTURE, make_atlas
from frontage.exports.facades import FacadePicture
from frontage.exports.triangles import (
    KINDS,
    ModelTriangles,
    cut_triangles,
    model_triangles,
    unique_vertices,
)
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
    "Frame": (0.72, 0.71, 0.68),
    "Pane": OPENING_SURFACES["Window"].colour,
}
"""Linear RGB, 0..1, of surfaces that no picture shows."""

FACING_COS = 0.96  # of the largest angle between a surface and the facade whose picture it takes
_GLASS_ROUGHNESS = 0.15  # of the glTF material


def building_mesh(assembled: Assembled, pictures: Sequence[FacadePicture], reach: float) -> GlbMesh:
    """Makes the fine model of a building one mesh, see `mesh_of`."""
    extras = {"building": assembled.building, "host": assembled.coarse.source, "lod": "3"}
    return mesh_of(model_triangles(assembled), pictures, reach, assembled.building, extras)


def mesh_of(
    shapes: ModelTriangles,
    pictures: Sequence[FacadePicture],
    reach: float,
    name: str,
    extras: dict[str, Any],
    *,
    features: Sequence[str] = (),
    max_texture: int = MAX_TEXTURE,
) -> GlbMesh:
    """Makes one mesh with one piece per page of pictures and per plain colour.

    Walls, windows and doors that lie within `reach` m of the plane of a facade and are parallel to it show
    its ortho-image, projected along the normal, as far as it reaches. Walls without a picture take the mean
    colour of all pictures. Window frames with their bars take the colour that the pictures show there. The
    panes behind them are plain glass: on them, the ortho-image would show every bar a second time, shifted
    when seen aslant.
    Vertices belong to the opening with their triangle's id in `features`.
    """
    for picture in pictures:
        shapes = _cut_at_border(shapes, picture, reach)
    number = {opening: k for k, opening in enumerate(features)}
    feature = np.array([number.get(opening, len(number)) for opening in shapes.opening.tolist()], np.int64)
    centre = np.rint(shapes.corners.reshape(-1, 3).mean(0)) if len(shapes) else np.zeros(3)
    matrix = np.eye(4)
    matrix[:3, 3] = centre
    pieces, left = _painted(shapes, pictures, reach, centre, feature, f"{name} pictures", max_texture)
    seen = {"WallSurface": _mean_colour(pictures), "Frame": _frame_colour(shapes, pictures)}
    pieces += _plain(shapes, left, centre, {k: v for k, v in seen.items() if v is not None}, feature)
    return GlbMesh(name, tuple(pieces), matrix, extras)


def _painted(
    shapes: ModelTriangles,
    pictures: Sequence[FacadePicture],
    reach: float,
    centre: Float,
    feature: Int,
    name: str,
    max_texture: int,
) -> tuple[list[GlbPiece], Bool]:
    """One piece per page of pictures, relative to `centre` (3,) m; also which triangles (t,) have none."""
    left = np.ones(len(shapes), np.bool_)
    atlas = make_atlas([picture.jpeg for picture in pictures], max_texture)
    rows: list[list[Float]] = [[] for _ in atlas.pages]
    for picture, place in zip(pictures, atlas.places, strict=True):
        uv = _texture_coordinates(shapes.corners, picture)
        shown = left & _shown(shapes, picture, uv, reach)
        left &= ~shown
        parts = (shapes.corners[shown] - centre, place.on_page(uv[shown]), _per_corner(feature[shown]))
        rows[place.page].append(np.concatenate(parts, axis=2))
    pieces = []
    for number, (page, own) in enumerate(zip(atlas.pages, map(np.concatenate, rows), strict=True)):
        if len(own):
            vertices, faces = unique_vertices(own[..., :3], own[..., 3:])
            material = GlbMaterial(f"{name} {number + 1}", page)
            numbers = vertices[:, 5].astype(np.int64)
            pieces.append(GlbPiece(material, vertices[:, :3], faces, uv=vertices[:, 3:5], feature=numbers))
    return pieces, left


def _per_corner(values: Int) -> Float:
    """Values (t,) of triangles for each of their corners (t, 3, 1)."""
    return np.repeat(values.astype(np.float64)[:, None, None], 3, axis=1)


def _texture_coordinates(corners: Float, picture: FacadePicture) -> Float:
    """Texture coordinates (t, 3, 2) of corners (t, 3, 3) in a picture, 0..1, v downwards."""
    x, _, z = np.moveaxis(picture.facade.frame.inverse.apply(corners.reshape(-1, 3)), 1, 0)
    width, height = picture.size
    u = (x - picture.corner[0]) / (picture.gsd * width)
    v = (picture.corner[1] - z) / (picture.gsd * height)
    return np.column_stack([u, v]).reshape(-1, 3, 2)


def _cut_at_border(shapes: ModelTriangles, picture: FacadePicture, reach: float) -> ModelTriangles:
    """Cuts triangles that lie partly within a picture along its border."""
    uv = _texture_coordinates(shapes.corners, picture)
    beyond = ((uv < -BEYOND) | (uv > 1 + BEYOND)).any((1, 2))
    touched = (uv.max(1) > 0).all(1) & (uv.min(1) < 1).all(1)
    rows = np.flatnonzero(_before(shapes, picture, reach) & beyond & touched)
    return cut_triangles(shapes, rows, uv[rows], shapely.box(0.0, 0.0, 1.0, 1.0)) if len(rows) else shapes


def _shown(shapes: ModelTriangles, picture: FacadePicture, uv: Float, reach: float) -> Bool:
    """Which triangles (t,) a picture shows: parallel to its plane, near it, and within it."""
    within = ((uv > -1.01 * BEYOND) & (uv < 1 + 1.01 * BEYOND)).all((1, 2))
    return np.asarray(_before(shapes, picture, reach) & within)


def _before(shapes: ModelTriangles, picture: FacadePicture, reach: float) -> Bool:
    """Which triangles (t,) are parallel to the plane of a picture, near it, and of a kind that it shows."""
    frame = picture.facade.frame
    facing = shapes.normals @ -frame.R[:, 1] > FACING_COS
    y = frame.inverse.apply(shapes.corners.mean(1))[:, 1] if len(shapes) else np.zeros(0)
    kinds = [KINDS.index(k) for k in ("WallSurface", *OPENING_SURFACES)]
    return np.asarray(facing & (np.abs(y) < reach) & np.isin(shapes.kind, kinds))


def _plain(
    shapes: ModelTriangles, left: Bool, centre: Float, seen: Mapping[str, Colour], feature: Int
) -> list[GlbPiece]:
    """One piece per kind of the triangles that are `left`, relative to `centre` (3,) m local.

    `seen` are the colours of kinds that pictures show, `feature` (t,) the numbers of the features.
    """
    found = []
    for number, name in enumerate(KINDS):
        own: Int = np.flatnonzero(left & (shapes.kind == number))
        if len(own):
            roughness = _GLASS_ROUGHNESS if name in ("Window", "Pane") else 1.0
            material = GlbMaterial(name, None, seen.get(name, COLOURS[name]), roughness)
            normals = np.repeat(shapes.normals[own][:, None], 3, axis=1)
            more = np.concatenate([normals, _per_corner(feature[own])], axis=2)
            rows, faces = unique_vertices(shapes.corners[own] - centre, more)
            numbers = rows[:, 6].astype(np.int64)
            found.append(GlbPiece(material, rows[:, :3], faces, normals=rows[:, 3:6], feature=numbers))
    return found


def _mean_colour(pictures: Sequence[FacadePicture]) -> Colour | None:
    """Returns the mean of the median colours of all pictures, as linear RGB; None without pictures."""
    means: list[Array] = []
    for picture in pictures:
        image: Any = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_REDUCED_COLOR_8)
        means.append(np.median(image.reshape(-1, 3), axis=0)[::-1] / 255.0)
    return _linear(np.mean(means, axis=0)) if means else None


def _frame_colour(shapes: ModelTriangles, pictures: Sequence[FacadePicture]) -> Colour | None:
    """Returns the median colour of frames and bars in the pictures, as linear RGB; None without any."""
    corners = shapes.corners[shapes.kind == KINDS.index("Frame")]
    normals = shapes.normals[shapes.kind == KINDS.index("Frame")]
    samples: list[Array] = []
    for picture in pictures:
        front = normals @ -picture.facade.frame.R[:, 1] > FACING_COS
        if not front.any():
            continue
        u, v = _texture_coordinates(corners[front], picture).mean(1).T
        inside = (u >= 0) & (u < 1) & (v >= 0) & (v < 1)
        image: Any = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_COLOR)
        h, w = image.shape[:2]
        rows, columns = (v[inside] * h).astype(np.int64), (u[inside] * w).astype(np.int64)
        samples.append(image[rows, columns][:, ::-1] / 255.0)
    found = np.concatenate([np.zeros((0, 3)), *samples])
    return _linear(np.median(found, axis=0)) if len(found) else None


def _linear(colour: Array) -> Colour:
    """Converts sRGB (3,), 0..1, to linear RGB."""
    r, g, b = (colour**2.2).tolist()
    return r, g, b
