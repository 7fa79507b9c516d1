"""Tilesets and their files obey the schemas of 3D Tiles 1.1, EXT_mesh_features, EXT_structural_metadata."""

import copy
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from exports.test_facades import read_glb
from exports.test_tiles import ELEMENTS, written
from facade_fakes import GSD, WORLD, jpeg, ortho
from frontage.exports import FacadePicture
from frontage.exports.tiles import BuildingTile, building_tile
from frontage.model import WorldRef
from solids.test_assemble import house, wall
from tiles_schemas import MESH_FEATURES, STRUCTURAL_METADATA, TILESET, own, published

Json = dict[str, Any]
Check = Callable[[Any], Draft202012Validator]


@pytest.fixture(scope="module")
def made() -> BuildingTile:
    image = ortho()
    shown = FacadePicture(wall(), jpeg(image), GSD, image.corner, image.size)
    return building_tile(house(wall(), ELEMENTS, bars=True), [shown], [(wall(), ELEMENTS)], 2.0, WORLD)


def features(made: BuildingTile) -> list[Json]:
    """The extension EXT_mesh_features of every primitive that has one."""
    gltf, _ = read_glb(made.files["B01_lod3.glb"])
    primitives = [p for mesh in gltf["meshes"] for p in mesh["primitives"]]
    return [p["extensions"]["EXT_mesh_features"] for p in primitives if "extensions" in p]


def metadata(made: BuildingTile) -> Json:
    gltf, _ = read_glb(made.files["B01_lod3.glb"])
    found: Json = gltf["extensions"]["EXT_structural_metadata"]
    return found


def changed(document: Json, change: Callable[[Json], object]) -> Json:
    other = copy.deepcopy(document)
    change(other)
    return other


# The published schemas leave values of enumerations and class names open, so some faults only ours finds.
OPEN_IN_TILESETS, OPEN_IN_METADATA = {2}, {1, 4, 5}
BAD_TILESETS: tuple[Callable[[Json], object], ...] = (
    lambda t: t.pop("geometricError"),
    lambda t: t["root"].update(geometricError=-1.0),
    lambda t: t["root"].update(refine="replace"),
    lambda t: t["root"]["boundingVolume"].update(region=[0.0] * 5),
    lambda t: t["root"]["children"][0].update(transform=[1.0] * 12),
    lambda t: t["root"]["children"][0]["content"].pop("uri"),
    lambda t: t["asset"].pop("version"),
)
BAD_FEATURES: tuple[Callable[[Json], object], ...] = (
    lambda f: f["featureIds"][0].pop("featureCount"),
    lambda f: f["featureIds"][0].update(featureCount=0),
    lambda f: f["featureIds"][0].update(label="two words"),
    lambda f: f.update(featureIds=[]),
)
BAD_METADATA: tuple[Callable[[Json], object], ...] = (
    lambda m: m["propertyTables"][0].pop("count"),
    lambda m: m["propertyTables"][0].update({"class": "an opening"}),
    lambda m: m["propertyTables"][0]["properties"]["id"].pop("values"),
    lambda m: m["schema"].pop("id"),
    lambda m: m["schema"]["classes"]["opening"]["properties"]["width"].update(componentType="DOUBLE"),
    lambda m: m["schema"]["classes"]["opening"]["properties"]["id"].update(type="TEXT"),
)


@pytest.mark.parametrize(
    ("check", "missed"),
    [(lambda _: own(TILESET), set()), (published, OPEN_IN_TILESETS)],
    ids=["own", "published"],
)
@pytest.mark.parametrize("crs", [WORLD.crs, None])
def test_tilesets(
    tmp_path: Path, made: BuildingTile, check: Check, missed: set[int], crs: str | None
) -> None:
    validator, tileset = check("tileset.schema.json"), written(tmp_path, made, WorldRef(WORLD.origin, crs))
    assert [e.message for e in validator.iter_errors(tileset)] == []
    if crs is not None:
        found = {k for k, bad in enumerate(BAD_TILESETS) if validator.is_valid(changed(tileset, bad))}
        assert found == missed


@pytest.mark.parametrize("check", [lambda _: own(MESH_FEATURES), published], ids=["own", "published"])
def test_features_of_primitives(made: BuildingTile, check: Check) -> None:
    validator = check("mesh.primitive.EXT_mesh_features.schema.json")
    found = features(made)
    assert len(found) == 3
    for extension in found:
        assert [e.message for e in validator.iter_errors(extension)] == []
        assert not [k for k, bad in enumerate(BAD_FEATURES) if validator.is_valid(changed(extension, bad))]


@pytest.mark.parametrize(
    ("check", "missed"),
    [(lambda _: own(STRUCTURAL_METADATA), set()), (published, OPEN_IN_METADATA)],
    ids=["own", "published"],
)
def test_properties_of_features(made: BuildingTile, check: Check, missed: set[int]) -> None:
    validator, found = check("glTF.EXT_structural_metadata.schema.json"), metadata(made)
    assert [e.message for e in validator.iter_errors(found)] == []
    assert {k for k, bad in enumerate(BAD_METADATA) if validator.is_valid(changed(found, bad))} == missed
    (table,), classes = found["propertyTables"], found["schema"]["classes"]
    assert table["properties"].keys() == classes[table["class"]]["properties"].keys()


@pytest.mark.parametrize("name", ["B01_lod2.glb", "B01_lod3.glb"])
def test_files_are_gltf_by_the_published_schema(made: BuildingTile, name: str) -> None:
    validator, (gltf, _) = published("glTF.schema.json"), read_glb(made.files[name])
    assert [e.message for e in validator.iter_errors(gltf)] == []
    gltf["accessors"][0]["componentType"] = "FLOAT"
    assert not validator.is_valid(gltf)
