"""The files of the LoD3 model: what a building contributes to them, and how they are written."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from frontage.exports.tiles import BuildingTile
from frontage.io.citymodels.citygml.write import write_citygml
from frontage.io.citymodels.cityjson.write import write_cityjson
from frontage.io.meshes.glb import GlbMesh, glb_of
from frontage.io.meshes.tileset import write_tileset
from frontage.model import Failed
from frontage.model.citymodel import CityBuilding
from frontage.pipeline.store.files import write_json
from frontage.pipeline.store.store import Store


@dataclass(frozen=True, eq=False)
class Made:
    """What goes into the files for one building; `failed`: what does not, and why.

    textures  pictures that its walls show, by path relative to the city model
    """

    id: str
    buildings: tuple[CityBuilding, ...] = ()
    textures: Mapping[str, bytes] = field(default_factory=dict)
    mesh: GlbMesh | None = None
    tile: BuildingTile | None = None
    picture: bytes = b""
    about: Mapping[str, Any] | None = None
    failed: tuple[Failed, ...] = ()
    measured: tuple[str, ...] = field(default=())


def write_model(store: Store, made: Sequence[Made], left_out: Sequence[str]) -> None:
    """Write the city models with their pictures, meshes, tiles and the report. Raises FileError.

    left_out  sentences on what they do not show, which every file holds
    """
    folder, world, title = store.model_folder, store.world(), "Frontage LoD3"
    buildings = [b for m in made for b in m.buildings]
    write_cityjson(folder / "lod3.city.json", buildings, world, title, left_out)
    write_citygml(folder / "lod3.gml", buildings, world, title, "2.0", left_out)
    write_citygml(folder / "lod3_citygml3.gml", buildings, world, title, "3.0", left_out)
    write_json(folder / "report.json", {m.id: m.about for m in made})
    store.wrote(*(folder / n for n in ("lod3.city.json", "lod3.gml", "lod3_citygml3.gml", "report.json")))
    meshes = [m.mesh for m in made if m.mesh is not None]
    store.put(folder / "lod3.glb", glb_of(meshes, world, left_out=left_out))
    shown = {t.image for b in buildings for shell in b.shells for t in shell.textures.values()}
    _write_tiles(store, [m.tile for m in made if m.tile is not None], left_out)
    for m in made:
        for path in sorted(shown & m.textures.keys()):
            store.put(folder / path, m.textures[path])
        store.put(folder / "pictures" / f"{m.id}.png", m.picture)


def _write_tiles(store: Store, made: Sequence[BuildingTile], left_out: Sequence[str]) -> None:
    folder = store.products_folder / "tiles"
    for name, data in (file for one in made for file in one.files.items()):
        store.put(folder / name, data)
    write_tileset(folder / "tileset.json", [one.tile for one in made], store.world(), left_out)
    store.wrote(folder / "tileset.json")
