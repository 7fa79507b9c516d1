"""Textured meshes to files: binary glTF 2.0 (GLB) and Wavefront OBJ.

glTF knows float32 vertices and y up. So that nothing is lost at UTM size, every mesh keeps small vertex
coordinates in its own frame, its node carries the motion to the local frame in JSON numbers (float64), and
the root node turns z up to y up. World = local + `origin`, stored in `asset.extras` and in the root's extras.
"""

import json
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.io.files import whole_file
from frontage.model import WorldRef

# glTF (x, y, z) = local (x, z, -y): a quarter turn about x, as a quaternion (x, y, z, w).
Y_UP_FROM_Z_UP = (-(0.5**0.5), 0.0, 0.0, 0.5**0.5)

_FLOAT, _UINT = 5126, 5125
_ARRAY_BUFFER, _ELEMENT_BUFFER = 34962, 34963
_CLAMP, _LINEAR, _MIPMAP = 33071, 9729, 9987


@dataclass(frozen=True, eq=False)
class TexturedMesh:
    """Triangles with one JPEG texture.

    name             unique, readable ("B07/F1")
    xyz              (n, 3) float64 m in the mesh's own frame
    uv               (n, 2) float64, 0..1, v downwards from the texture's upper edge
    faces            (m, 3) int, counter-clockwise seen from outside
    local_from_mesh  (4, 4) float64
    texture          JPEG bytes
    extras           JSON-able facts kept with the mesh
    """

    name: str
    xyz: Float
    uv: Float
    faces: Array
    local_from_mesh: Float
    texture: bytes
    extras: dict[str, Any]

    @property
    def file_stem(self) -> str:
        """The name as a file name."""
        return self.name.replace("/", "_")


def glb_bytes(meshes: Sequence[TexturedMesh], world: WorldRef, generator: str = "Frontage") -> bytes:
    """One GLB of all meshes, textures inside. Deterministic: the same meshes give the same bytes."""
    blob = _Blob()
    place = {"crs": world.crs, "origin": [int(v) for v in world.origin], "world": "local + origin", "up": "z"}
    n = len(meshes)
    root = {
        "name": "local",
        "rotation": list(Y_UP_FROM_Z_UP),
        "children": list(range(1, n + 1)),
        "extras": place,
    }
    gltf: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": generator, "extras": place},
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [root, *(_node(mesh, i) for i, mesh in enumerate(meshes))],
        "meshes": [_mesh(mesh, i, blob) for i, mesh in enumerate(meshes)],
        "materials": [_material(mesh.name, i) for i, mesh in enumerate(meshes)],
        "textures": [{"source": i, "sampler": 0} for i in range(n)],
        "images": [
            {"name": m.file_stem, "mimeType": "image/jpeg", "bufferView": blob.add(m.texture)} for m in meshes
        ],
        "samplers": [{"magFilter": _LINEAR, "minFilter": _MIPMAP, "wrapS": _CLAMP, "wrapT": _CLAMP}],
        "accessors": blob.accessors,
        "bufferViews": blob.views,
        "buffers": [{"byteLength": len(blob.data)}],
    }
    if not n:  # glTF forbids empty lists
        root.pop("children")
        gltf = {k: v for k, v in gltf.items() if k in ("asset", "scene", "scenes", "nodes")}
    return _container(json.dumps(gltf, separators=(",", ":")).encode(), bytes(blob.data))


def write_glb(path: Path, meshes: Sequence[TexturedMesh], world: WorldRef) -> None:
    """Write `glb_bytes` to `path`, whole or not at all."""
    _write(path, glb_bytes(meshes, world))


def write_obj(path: Path, meshes: Sequence[TexturedMesh], world: WorldRef) -> None:
    """Write `path` (.obj), its .mtl, `textures/*.jpg` and `<stem>.offset.json`.

    World = vertex + offset. Vertices are local, z up, in metres with 0.1 mm digits; texture coordinates
    have v upwards, as OBJ wants.
    """
    for mesh in meshes:
        _write(path.parent / "textures" / f"{mesh.file_stem}.jpg", mesh.texture)
    mtl = "".join(f"newmtl {m.file_stem}\nKd 1 1 1\nmap_Kd textures/{m.file_stem}.jpg\n" for m in meshes)
    _write(path.with_suffix(".mtl"), mtl.encode())
    offset = {
        "crs": world.crs,
        "offset": [int(v) for v in world.origin],
        "world": "vertex + offset",
        "up": "z",
    }
    _write(path.with_suffix(".offset.json"), (json.dumps(offset, indent=2) + "\n").encode())
    _write(path, _obj_text(meshes, path.with_suffix(".mtl").name).encode())


def _write(path: Path, data: bytes) -> None:
    with whole_file(path) as temporary:
        temporary.write_bytes(data)


class _Blob:
    """The GLB's binary chunk, with the views and accessors into it."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, data: bytes, target: int | None = None) -> int:
        """Append bytes at a multiple of 4; the number of their view."""
        self.data += b"\0" * (-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.views.append(view | ({"target": target} if target else {}))
        self.data += data
        return len(self.views) - 1

    def accessor(self, array: Array, kind: str, target: int, bounds: bool = False) -> int:
        """Append an array as float32 or uint32; the number of its accessor."""
        whole = array.dtype.kind in "iu"
        a = np.ascontiguousarray(array, "<u4" if whole else "<f4")
        entry: dict[str, Any] = {
            "bufferView": self.add(a.tobytes(), target),
            "componentType": _UINT if whole else _FLOAT,
        }
        entry |= {"count": len(a), "type": kind}
        if bounds:
            entry |= {"min": a.min(0).tolist(), "max": a.max(0).tolist()}
        self.accessors.append(entry)
        return len(self.accessors) - 1


def _node(mesh: TexturedMesh, i: int) -> dict[str, Any]:
    matrix = [float(v) for v in np.asarray(mesh.local_from_mesh).T.ravel()]  # glTF: column-major
    return {"name": mesh.name, "mesh": i, "matrix": matrix, "extras": mesh.extras}


def _mesh(mesh: TexturedMesh, i: int, blob: _Blob) -> dict[str, Any]:
    attributes = {
        "POSITION": blob.accessor(mesh.xyz, "VEC3", _ARRAY_BUFFER, bounds=True),
        "TEXCOORD_0": blob.accessor(mesh.uv, "VEC2", _ARRAY_BUFFER),
    }
    indices = blob.accessor(np.asarray(mesh.faces, np.uint32).reshape(-1), "SCALAR", _ELEMENT_BUFFER)
    return {"name": mesh.name, "primitives": [{"attributes": attributes, "indices": indices, "material": i}]}


def _material(name: str, i: int) -> dict[str, Any]:
    pbr = {"baseColorTexture": {"index": i}, "metallicFactor": 0.0, "roughnessFactor": 1.0}
    # A photograph carries its own light.
    return {
        "name": name,
        "doubleSided": True,
        "pbrMetallicRoughness": pbr,
        "extensions": {"KHR_materials_unlit": {}},
    }


def _container(text: bytes, binary: bytes) -> bytes:
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    if binary:
        chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _obj_text(meshes: Sequence[TexturedMesh], mtl: str) -> str:
    lines = [f"mtllib {mtl}"]
    first = 1
    for mesh in meshes:
        M = np.asarray(mesh.local_from_mesh)
        xyz = mesh.xyz @ M[:3, :3].T + M[:3, 3]
        lines += [f"o {mesh.file_stem}", f"usemtl {mesh.file_stem}"]
        lines += [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in xyz]
        lines += [f"vt {u:.7f} {1 - v:.7f}" for u, v in mesh.uv]
        lines += ["f " + " ".join(f"{k + first}/{k + first}" for k in face) for face in mesh.faces]
        first += len(xyz)
    return "\n".join(lines) + "\n"
