"""The textured model: every texel must lie where its ortho-image pixel lies in the world."""

import json
import struct
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import shapely

from facade_fakes import GSD, WORLD, jpeg, ortho
from frontage.exports import FacadePicture, facade_mesh, limit_texture, triangulate
from frontage.io.meshes.textured import glb_bytes, write_glb, write_obj


def picture(name: str = "B01/F1") -> FacadePicture:
    image = ortho(name)
    return FacadePicture(image.facade, jpeg(image), GSD, image.corner, image.size)


def read_glb(data: bytes) -> tuple[dict[str, Any], bytes]:
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data))
    size, kind = struct.unpack_from("<I4s", data, 12)
    assert kind == b"JSON" and size % 4 == 0
    binary_size, kind = struct.unpack_from("<I4s", data, 20 + size)
    assert kind == b"BIN\0"
    return json.loads(data[20 : 20 + size]), data[28 + size : 28 + size + binary_size]


def accessor(gltf: dict[str, Any], binary: bytes, number: int) -> Any:
    entry = gltf["accessors"][number]
    view = gltf["bufferViews"][entry["bufferView"]]
    dtype = {5126: "<f4", 5125: "<u4"}[entry["componentType"]]
    columns = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[entry["type"]]
    values = np.frombuffer(binary, dtype, entry["count"] * columns, view["byteOffset"])
    return values.reshape(-1, columns)


def world_of_vertices(gltf: dict[str, Any], binary: bytes, i: int) -> tuple[Any, Any]:
    """World (n, 3) and uv (n, 2) of mesh i, by nothing but the glTF rules and `asset.extras`."""
    root, node = gltf["nodes"][0], gltf["nodes"][i + 1]
    primitive = gltf["meshes"][node["mesh"]]["primitives"][0]
    xyz = accessor(gltf, binary, primitive["attributes"]["POSITION"]).astype(np.float64)
    M = np.array(node["matrix"]).reshape(4, 4).T
    x, y, z, w = root["rotation"]
    R = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                  [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                  [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])  # fmt: skip
    gl = (xyz @ M[:3, :3].T + M[:3, 3]) @ R.T
    local = np.column_stack([gl[:, 0], -gl[:, 2], gl[:, 1]])  # y up back to z up
    return local + gltf["asset"]["extras"]["origin"], accessor(
        gltf, binary, primitive["attributes"]["TEXCOORD_0"]
    )


def test_a_texel_lies_where_its_pixel_lies_in_the_world() -> None:
    image = ortho()
    gltf, binary = read_glb(glb_bytes([facade_mesh(picture())], WORLD))
    xyz, uv = world_of_vertices(gltf, binary, 0)
    w, h = image.size
    local, _ = image.local_from_pixel(uv * (w, h), relief=False)
    assert np.abs(WORLD.to_world(local) - xyz).max() < 1e-4  # m, float32 texture coordinates over 11 m
    assert np.abs(xyz - WORLD.to_world(image.facade.frame.t)).max() < 10


def test_faces_cover_the_outline_and_look_at_the_street() -> None:
    image = ortho()
    gltf, binary = read_glb(glb_bytes([facade_mesh(picture())], WORLD))
    xyz, _ = world_of_vertices(gltf, binary, 0)
    faces = accessor(gltf, binary, gltf["meshes"][0]["primitives"][0]["indices"]).reshape(-1, 3)
    a, b, c = (xyz[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    outward = -image.facade.frame.R[:, 1]
    assert (normal @ outward > 0).all()
    area = np.linalg.norm(normal, axis=1).sum() / 2
    assert area == pytest.approx(shapely.Polygon(image.facade.outline).area, abs=1e-3)


def test_the_texture_is_the_ortho_image_and_is_limited() -> None:
    gltf, binary = read_glb(glb_bytes([facade_mesh(picture(), max_texture=128)], WORLD))
    view = gltf["bufferViews"][gltf["images"][0]["bufferView"]]
    data = binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None and max(image.shape[:2]) == 128
    red = image[..., 2].astype(int)
    assert red[:, -1].mean() - red[:, 0].mean() > 200  # not mirrored
    assert image[0, :, 1].mean() > image[-1, :, 1].mean() + 200  # not upside down
    assert limit_texture(jpeg(ortho())) == jpeg(ortho())


def test_same_meshes_same_bytes_and_everything_named() -> None:
    meshes = [facade_mesh(picture("B01/F1")), facade_mesh(picture("B02/F1"))]
    first = glb_bytes(meshes, WORLD)
    assert first == glb_bytes(meshes, WORLD)
    gltf, _ = read_glb(first)
    assert [n["name"] for n in gltf["nodes"]] == ["local", "B01/F1", "B02/F1"]
    assert gltf["asset"]["extras"]["crs"] == "EPSG:25832"
    assert gltf["nodes"][1]["extras"]["gsd"] == GSD


def test_no_facade_gives_a_valid_empty_glb(tmp_path: Path) -> None:
    write_glb(tmp_path / "empty.glb", [], WORLD)
    data = (tmp_path / "empty.glb").read_bytes()
    size = struct.unpack_from("<I", data, 12)[0]
    assert json.loads(data[20 : 20 + size])["nodes"] == [
        {k: v for k, v in json.loads(data[20 : 20 + size])["nodes"][0].items() if k != "children"}
    ]
    assert len(data) == 20 + size


def test_obj_with_its_offset_gives_the_world(tmp_path: Path) -> None:
    image = ortho()
    write_obj(tmp_path / "facades.obj", [facade_mesh(picture()), facade_mesh(picture("B02/F1"))], WORLD)
    text = (tmp_path / "facades.obj").read_text().splitlines()
    offset = json.loads((tmp_path / "facades.offset.json").read_text())
    v = np.array([line.split()[1:] for line in text if line.startswith("v ")], float) + offset["offset"]
    vt = np.array([line.split()[1:] for line in text if line.startswith("vt ")], float)
    w, h = image.size
    local, _ = image.local_from_pixel(np.column_stack([vt[:, 0] * w, (1 - vt[:, 1]) * h]), relief=False)
    assert np.abs(WORLD.to_world(local) - v).max() < 2e-4
    corners = [int(c.split("/")[0]) for line in text if line.startswith("f ") for c in line.split()[1:]]
    assert (min(corners), max(corners)) == (1, len(v))
    assert "map_Kd textures/B02_F1.jpg" in (tmp_path / "facades.mtl").read_text()
    assert (tmp_path / "textures" / "B02_F1.jpg").is_file()


def test_triangulation_repairs_a_ring_that_crosses_itself() -> None:
    xz, faces = triangulate(np.array([[0.0, 0], [2, 2], [2, 0], [0, 2]]))
    a, b, c = (xz[faces[:, k]] for k in range(3))
    area = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    assert (area > 0).all() and area.sum() == pytest.approx(2.0)
