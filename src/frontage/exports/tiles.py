"""A building as a tile of 3D Tiles: a coarse and a fine mesh, and what is known of its openings."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from frontage.exports.facades import FacadePicture
from frontage.exports.model3d import mesh_of
from frontage.exports.survey import Front, SurveyedBuilding, in_world
from frontage.exports.tables.columns import OPENINGS
from frontage.exports.tables.layers import opening_row
from frontage.exports.triangles import host_triangles, model_triangles
from frontage.geometry.arrays import Float
from frontage.io.meshes.features import FeatureTable, Property
from frontage.io.meshes.glb import GlbMesh, glb_of
from frontage.io.meshes.tileset import Level, Tile
from frontage.model import Elements, Facade, WorldRef
from frontage.solids import Assembled

_COARSE_TEXTURE_PX = 512
_COARSE_ERROR_M = 1.0  # of the coarse solid: as much as balconies and oriels stand out


@dataclass(frozen=True, eq=False)
class BuildingTile:
    """A tile and its files by their names."""

    tile: Tile
    files: dict[str, bytes]


def building_tile(
    assembled: Assembled,
    pictures: Sequence[FacadePicture],
    fronts: Sequence[Front],
    reach: float,
    world: WorldRef,
) -> BuildingTile:
    """Make the tile of a building: LoD2 with small pictures, which LoD3 replaces near by.

    In LoD3 the faces and frames of openings are features; their table has the columns of the table of
    openings, and `outline`, the outline in the CRS. `reach` is that of `mesh_of`.
    """
    name = assembled.building
    table = _openings(name, [(facade, e) for facade, e in fronts if e is not None])
    ids = table.properties[0].values if table else ()
    coarse = mesh_of(host_triangles(assembled), pictures, reach, name, {"building": name, "lod": "2"},
                     max_texture=_COARSE_TEXTURE_PX)  # fmt: skip
    fine = mesh_of(model_triangles(assembled), pictures, reach, name, {"building": name, "lod": "3"},
                   features=[str(v) for v in ids])  # fmt: skip
    meshes = [coarse, fine] if any(assembled.fine) else [coarse]
    centre = fine.local_from_mesh[:3, 3]
    corners = np.concatenate([p.xyz + m.local_from_mesh[:3, 3] - centre for m in meshes for p in m.pieces])
    files, levels = {}, []
    for lod, mesh in zip(("2", "3"), meshes, strict=False):
        uri, last = f"{name}_lod{lod}.glb", mesh is meshes[-1]
        files[uri] = glb_of([_about(mesh, centre)], world, table if lod == "3" else None)
        levels.append(Level(uri, 0.0 if last else _COARSE_ERROR_M))
    return BuildingTile(Tile(name, centre, corners.min(0), corners.max(0), tuple(levels)), files)


def _about(mesh: GlbMesh, centre: Float) -> GlbMesh:
    """The mesh with `centre` as origin of its file; the tile says where that lies."""
    matrix = mesh.local_from_mesh.copy()
    matrix[:3, 3] -= centre
    return replace(mesh, local_from_mesh=matrix)


def _openings(building: str, fronts: Sequence[tuple[Facade, Elements]]) -> FeatureTable | None:
    """Return the table of a building's openings, None if it has none."""
    plain = SurveyedBuilding(building, None, None, None, "", tuple(fronts))
    rows = [opening_row(plain, facade, elements, o) for facade, elements, o in plain.openings]
    outlines = [in_world(facade, o.ring, elements.wall_y(o)) for facade, elements, o in plain.openings]
    if not rows:
        return None
    properties = tuple(
        Property(c.name, c.kind, c.description, [row[k] for row in rows]) for k, c in enumerate(OPENINGS)
    )
    outline = Property("outline", "points", "corners of the outline in the CRS (m)", outlines)
    return FeatureTable("opening", len(rows), (*properties, outline))
