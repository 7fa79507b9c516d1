"""3D Tiles: where they lie on the earth, what encloses them, and what they know of openings."""

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyproj import Transformer

from exports.test_facades import accessor, read_glb
from facade_fakes import GSD, WORLD, jpeg, ortho
from frontage.exports import FacadePicture
from frontage.exports.survey import in_world
from frontage.exports.tiles import BuildingTile, building_tile
from frontage.geometry.arrays import Array, Float
from frontage.io.meshes.features import FEATURE_ID
from frontage.io.meshes.tileset import write_tileset
from frontage.model import Elements, WorldRef
from opening_fakes import opening
from solids.test_assemble import house, protrusion, wall, window

TOLERANCE_M = 1e-4
ELEMENTS = Elements(
    "B01/F1",
    (opening(), window("B01/F1/W1-2", (2.2, 0, 3.8, 1.5), 0.2), window("B01/F1/W1-3", (-1, -2, 0, -1), None)),
    (protrusion("oriel", (2, -1, 4, 2), -0.8), protrusion("balcony", (-3.5, -1.5, -1.5, -0.4), -1.0)),
)


@pytest.fixture(scope="module")
def made() -> BuildingTile:
    image = ortho()
    shown = FacadePicture(wall(), jpeg(image), GSD, image.corner, image.size)
    return building_tile(house(wall(), ELEMENTS, bars=True), [shown], [(wall(), ELEMENTS)], 2.0, WORLD)


def written(folder: Path, made: BuildingTile, world: WorldRef) -> dict[str, Any]:
    write_tileset(folder / "tileset.json", [made.tile], world)
    return json.loads((folder / "tileset.json").read_text())


def vertices(glb: bytes) -> tuple[Float, Array]:
    """All vertices of a file in its own metres with z up, and their features (-1 = no table)."""
    gltf, binary = read_glb(glb)
    matrix = np.array(gltf["nodes"][1]["matrix"]).reshape(4, 4).T
    points, numbers = [], []
    for primitive in gltf["meshes"][0]["primitives"]:
        xyz = accessor(gltf, binary, primitive["attributes"]["POSITION"])
        points.append(xyz @ matrix[:3, :3].T + matrix[:3, 3])
        own = primitive["attributes"].get(FEATURE_ID)
        numbers.append(np.full(len(xyz), -1) if own is None else accessor(gltf, binary, own).ravel())
    return np.concatenate(points), np.concatenate(numbers).astype(int)


def test_tiles_lie_where_the_building_stands(tmp_path: Path, made: BuildingTile) -> None:
    found = written(tmp_path, made, WORLD)
    (tile,) = found["root"]["children"]
    matrix = np.array(tile["transform"]).reshape(4, 4).T
    back = Transformer.from_crs("EPSG:4978", WORLD.crs, always_xy=True)
    for data in made.files.values():
        xyz, _ = vertices(data)
        expected = WORLD.to_world(xyz + made.tile.centre)
        east, north, height = back.transform(*(xyz @ matrix[:3, :3].T + matrix[:3, 3]).T)
        np.testing.assert_allclose(np.column_stack([east, north]), expected[:, :2], atol=TOLERANCE_M)
        np.testing.assert_allclose(height, expected[:, 2], atol=TOLERANCE_M)
    assert np.linalg.det(matrix[:3, :3]) == pytest.approx(1.0, abs=2e-3)  # UTM's scale
    assert "geoid height 0 m" in found["asset"]["extras"]["heights"]
    assert found["asset"]["version"] == "1.1"


def test_volumes_enclose_the_tiles_and_errors_fall(tmp_path: Path, made: BuildingTile) -> None:
    found = written(tmp_path, made, WORLD)
    west, south, east, north, low, high = found["root"]["boundingVolume"]["region"]
    (tile,) = found["root"]["children"]
    box = np.array(tile["boundingVolume"]["box"]).reshape(4, 3)
    half = np.abs(box[1:]).sum(0)
    degrees = Transformer.from_crs(WORLD.crs, "EPSG:4979", always_xy=True)
    for data in made.files.values():
        xyz, _ = vertices(data)
        assert (np.abs(xyz - box[0]) <= half + 1e-5).all()
        lon, lat, _ = np.radians(degrees.transform(*WORLD.to_world(xyz + made.tile.centre).T))
        assert west - 1e-9 <= lon.min() and lon.max() <= east + 1e-9
        assert south - 1e-9 <= lat.min() and lat.max() <= north + 1e-9
        z = WORLD.to_world(xyz + made.tile.centre)[:, 2]
        assert low - 1e-3 <= z.min() and z.max() <= high + 1e-3
    (finer,) = tile["children"]
    errors = [found["geometricError"], found["root"]["geometricError"], tile["geometricError"],
              finer["geometricError"]]  # fmt: skip
    assert errors == sorted(errors, reverse=True) and errors[-1] == 0.0
    assert (found["root"]["refine"], tile["refine"]) == ("ADD", "REPLACE"), "one building waits for no other"
    assert [tile["content"]["uri"], finer["content"]["uri"]] == list(made.files)
    assert len(made.files["B01_lod2.glb"]) < len(made.files["B01_lod3.glb"])


def table(gltf: dict[str, Any], binary: bytes) -> dict[str, list[Any]]:
    """The columns of the file's table of features, read as the extension says."""
    about = gltf["extensions"]["EXT_structural_metadata"]
    (held,) = about["propertyTables"]
    described = about["schema"]["classes"][held["class"]]["properties"]

    def view(number: int, kind: str) -> Array:
        v = gltf["bufferViews"][number]
        assert v["byteOffset"] % 8 == 0
        return np.frombuffer(binary[v["byteOffset"] :][: v["byteLength"]], kind)

    found = dict[str, list[Any]]()
    for name, column in held["properties"].items():
        kind = described[name]
        if kind["type"] == "STRING":
            ends, data = view(column["stringOffsets"], "<u4"), view(column["values"], "u1").tobytes()
            found[name] = [data[a:b].decode() for a, b in pairwise(ends)]
        elif kind.get("array"):
            ends, data = view(column["arrayOffsets"], "<u4"), view(column["values"], "<f8").reshape(-1, 3)
            found[name] = [data[a:b] for a, b in pairwise(ends)]
        else:
            values = view(column["values"], {"FLOAT64": "<f8", "INT32": "<i4"}[kind["componentType"]])
            found[name] = [None if v == kind["noData"] else v for v in values.tolist()]
        assert len(found[name]) == held["count"]
    return found


def test_features_are_the_openings(made: BuildingTile) -> None:
    gltf, binary = read_glb(made.files["B01_lod3.glb"])
    assert {"EXT_mesh_features", "EXT_structural_metadata"} <= set(gltf["extensionsUsed"])
    known = table(gltf, binary)
    xyz, numbers = vertices(made.files["B01_lod3.glb"])
    assert set(numbers) == {-1, 0, 1, 2, 3} or set(numbers) == {0, 1, 2, 3}  # 3: no opening
    for k, o in enumerate(ELEMENTS.openings):
        assert (known["id"][k], known["kind"][k], known["floor"][k]) == (o.id, o.kind, o.floor)
        outline = in_world(wall(), o.ring, ELEMENTS.wall_y(o))
        np.testing.assert_allclose(known["outline"][k], outline, atol=TOLERANCE_M, rtol=0)
        depth = None if o.depth is None else pytest.approx(o.depth.value, abs=TOLERANCE_M)
        assert known["depth"][k] == depth and known["sill"][k] == pytest.approx(outline[:, 2].min())
        local = wall().frame.inverse.apply(xyz[numbers == k] + made.tile.centre)
        low, high = o.ring.min(0), o.ring.max(0)
        assert (local[:, [0, 2]] >= low - 2e-3).all() and (local[:, [0, 2]] <= high + 2e-3).all()
        assert np.ptp(local[:, 0]) == pytest.approx(high[0] - low[0], abs=2e-3)
    for primitive in gltf["meshes"][0]["primitives"]:
        if (about := primitive.get("extensions")) is not None:
            (ids,) = about["EXT_mesh_features"]["featureIds"]
            own = accessor(gltf, binary, primitive["attributes"][FEATURE_ID]).ravel()
            assert ids["featureCount"] == len(set(own[own < 3])) and ids["nullFeatureId"] == 3
    assert (
        "extensionsUsed" not in read_glb(made.files["B01_lod2.glb"])[0]
        or "EXT_mesh_features" not in (read_glb(made.files["B01_lod2.glb"])[0]["extensionsUsed"])
    )


def test_without_a_crs_tiles_stay_in_local_metres(tmp_path: Path, made: BuildingTile) -> None:
    found = written(tmp_path, made, WorldRef(WORLD.origin, None))
    (tile,) = found["root"]["children"]
    assert tile["transform"][12:15] == made.tile.centre.tolist() and "box" in found["root"]["boundingVolume"]
    assert "not placed on the earth" in found["asset"]["extras"]["heights"]
