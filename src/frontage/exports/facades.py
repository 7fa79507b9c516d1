"""The textured model of paper A: every facade is a textured, georeferenced polygon."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely

from frontage.exports.atlas import MAX_TEXTURE, decoded, encoded, reduced
from frontage.geometry.arrays import Array, Float
from frontage.io.meshes.textured import TexturedMesh
from frontage.model import Facade


@dataclass(frozen=True, eq=False)
class FacadePicture:
    """A facade and its ortho-image as JPEG: gsd m, upper left corner (x, z) m, size (w, h) px."""

    facade: Facade
    jpeg: bytes
    gsd: float
    corner: tuple[float, float]
    size: tuple[int, int]


def facade_mesh(picture: FacadePicture, max_texture: int = MAX_TEXTURE) -> TexturedMesh:
    """Triangulates the outline of a facade in its plane (y = 0), with the ortho-image as texture.

    Vertices stay in the facade frame, so that float32 is exact enough. Texture coordinates run from 0 to 1
    between the outer edges of the ortho-image; a texture with a side above `max_texture` px is reduced.
    """
    facade = picture.facade
    xz, faces = triangulate(facade.outline)
    width, height = picture.size
    u = (xz[:, 0] - picture.corner[0]) / (picture.gsd * width)
    v = (picture.corner[1] - xz[:, 1]) / (picture.gsd * height)
    return TexturedMesh(
        name=facade.id,
        xyz=np.column_stack([xz[:, 0], np.zeros(len(xz)), xz[:, 1]]),
        uv=np.column_stack([u, v]),
        faces=faces,
        local_from_mesh=facade.frame.matrix,
        texture=limit_texture(picture.jpeg, max_texture),
        extras=_extras(picture),
    )


def triangulate(ring: Float) -> tuple[Float, Array]:
    """Triangulates a polygon ring (k, 2) m (x, z): vertices (n, 2) m and counter-clockwise triangles (m, 3).

    These are the constrained Delaunay triangles of the repaired polygon. No vertex is added, so the outline
    stays exact.
    """
    polygon = shapely.make_valid(shapely.Polygon(ring))
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(polygon))
    corners = np.array([shapely.get_coordinates(part)[:3] for part in parts]).reshape(-1, 3, 2)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    clockwise = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] < 0
    corners[clockwise] = corners[clockwise][:, ::-1]
    xz, faces = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
    return xz, faces.reshape(-1, 3)


def limit_texture(jpeg: bytes, limit: int = MAX_TEXTURE) -> bytes:
    """Returns the same JPEG, reduced by averaging if a side is longer than `limit` px."""
    image = decoded(jpeg)
    small = reduced(image, limit)
    return jpeg if small is image else encoded(small)


def _extras(picture: FacadePicture) -> dict[str, Any]:
    """Attributes of the mesh in the glTF file."""
    facade = picture.facade
    return {
        "facade": facade.id,
        "building": facade.building,
        "gsd": picture.gsd,
        "corner": list(picture.corner),
        "size": list(picture.size),
        "sigma_plane": facade.sigma_plane,
        "origin_world": facade.world.to_world(facade.frame.t).tolist(),
    }
