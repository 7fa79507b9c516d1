"""Binary glTF 2.0 (GLB) of meshes with several materials.

glTF has float32 vertices and y up. So that nothing is lost at UTM size, every mesh keeps small vertex
coordinates in its own frame, its node holds the transformation to the local frame in JSON numbers (float64),
and the root node turns z up to y up. World = local + `origin`, which is stored in `asset.extras` and in the
extras of the root.
"""

import json
import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.io.meshes.features import (
    FEATURE_ID,
    MESH_FEATURES,
    STRUCTURAL_METADATA,
    FeatureTable,
    marked,
    metadata,
)
from frontage.model import WorldRef

# glTF (x, y, z) = local (x, z, -y): a quarter turn about x, as a quaternion (x, y, z, w).
Y_UP_FROM_Z_UP = (-(0.5**0.5), 0.0, 0.0, 0.5**0.5)

_FLOAT, _UINT = 5126, 5125
_ARRAY_BUFFER, _ELEMENT_BUFFER = 34962, 34963
_CLAMP, _LINEAR, _MIPMAP = 33071, 9729, 9987


@dataclass(frozen=True, eq=False)
class GlbMaterial:
    """A JPEG picture that is shown unlit, or a plain colour (red, green, blue; 0..1, linear) that is lit."""

    name: str
    texture: bytes | None = None
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)
    roughness: float = 1.0


@dataclass(frozen=True, eq=False)
class GlbPiece:
    """Triangles of one material.

    xyz      (n, 3) m in the mesh's own frame
    faces    (m, 3) vertex numbers
    uv       (n, 2), 0..1, v downwards, where the material has a picture
    normals  (n, 3) where it has none
    feature  (n,) rows of the file's table of features; as many as it has rows = none of them
    """

    material: GlbMaterial
    xyz: Float
    faces: Array
    uv: Float | None = None
    normals: Float | None = None
    feature: Array | None = None


@dataclass(frozen=True, eq=False)
class GlbMesh:
    """Pieces with a common frame: `local_from_mesh` (4, 4) m; JSON-able `extras` are stored with it."""

    name: str
    pieces: tuple[GlbPiece, ...]
    local_from_mesh: Float
    extras: dict[str, Any] = field(default_factory=dict)


def glb_of(
    meshes: Sequence[GlbMesh],
    world: WorldRef,
    features: FeatureTable | None = None,
    left_out: Sequence[str] = (),
) -> bytes:
    """The bytes of one GLB with all meshes and their pictures; equal meshes give equal bytes.

    Pieces that refer to the same `GlbMaterial` object share it and its picture. `features` says what the
    features are that vertices belong to; `left_out`, what the file does not show, stands in `asset.extras`.
    """
    blob = _Blob()
    place = {"crs": world.crs, "origin": [int(v) for v in world.origin], "world": "local + origin", "up": "z"}
    about = {**place, "left_out": list(left_out)} if left_out else place
    materials = list({id(p.material): p.material for m in meshes for p in m.pieces}.values())
    number = {id(m): k for k, m in enumerate(materials)}
    pictures = [m for m in materials if m.texture is not None]
    root = {
        "name": "local",
        "rotation": list(Y_UP_FROM_Z_UP),
        "children": list(range(1, len(meshes) + 1)),
        "extras": place,
    }
    gltf: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "Frontage", "extras": about},
        **_extensions(pictures, features, blob),
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [root, *(_node(mesh, i) for i, mesh in enumerate(meshes))],
        "meshes": [
            {
                "name": m.name,
                "primitives": [_primitive(p, number[id(p.material)], blob, features) for p in m.pieces],
            }
            for m in meshes
        ],
        "materials": [_material(m, pictures) for m in materials],
        **_pictures(pictures, blob),
        "accessors": blob.accessors,
        "bufferViews": blob.views,
        "buffers": [{"byteLength": len(blob.data)}],
    }
    if not meshes:
        root.pop("children")
        gltf = {k: v for k, v in gltf.items() if k in ("asset", "scene", "scenes", "nodes")}
    if not pictures:  # glTF forbids empty lists and unused extensions
        gltf = {k: v for k, v in gltf.items() if k not in ("textures", "images", "samplers")}
    return _container(json.dumps(gltf, separators=(",", ":")).encode(), bytes(blob.data))


def _extensions(
    pictures: Sequence[GlbMaterial], features: FeatureTable | None, blob: "_Blob"
) -> dict[str, Any]:
    """The extensions of the file: unlit pictures, and features with what is known of them."""
    used = [*(["KHR_materials_unlit"] if pictures else []),
            *([MESH_FEATURES, STRUCTURAL_METADATA] if features else [])]  # fmt: skip
    known = {"extensions": {STRUCTURAL_METADATA: metadata(features, blob.column)}} if features else {}
    return {**({"extensionsUsed": used} if used else {}), **known}


class _Blob:
    """The binary chunk of a GLB, with the views and accessors into it."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, data: bytes, target: int | None = None) -> int:
        """Append bytes at a multiple of 4; returns the number of their view."""
        self.data += b"\0" * (-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.views.append(view | ({"target": target} if target else {}))
        self.data += data
        return len(self.views) - 1

    def column(self, data: bytes, alignment: int) -> int:
        """Append bytes at a multiple of `alignment`; returns the number of their view."""
        self.data += b"\0" * (-len(self.data) % alignment)
        return self.add(data)

    def accessor(self, array: Array, kind: str, target: int, bounds: bool = False) -> int:
        """Append an array as float32 or uint32; returns the number of its accessor."""
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


def _pictures(pictures: Sequence[GlbMaterial], blob: _Blob) -> dict[str, Any]:
    images = [
        {"name": m.name.replace("/", "_"), "mimeType": "image/jpeg", "bufferView": blob.add(m.texture or b"")}
        for m in pictures
    ]
    return {
        "textures": [{"source": i, "sampler": 0} for i in range(len(pictures))],
        "images": images,
        "samplers": [{"magFilter": _LINEAR, "minFilter": _MIPMAP, "wrapS": _CLAMP, "wrapT": _CLAMP}],
    }


def _node(mesh: GlbMesh, i: int) -> dict[str, Any]:
    matrix = [float(v) for v in np.asarray(mesh.local_from_mesh).T.ravel()]  # glTF: column-major
    return {"name": mesh.name, "mesh": i, "matrix": matrix, "extras": mesh.extras}


def _primitive(piece: GlbPiece, material: int, blob: _Blob, features: FeatureTable | None) -> dict[str, Any]:
    attributes = {"POSITION": blob.accessor(piece.xyz, "VEC3", _ARRAY_BUFFER, bounds=True)}
    if piece.normals is not None:
        attributes["NORMAL"] = blob.accessor(piece.normals, "VEC3", _ARRAY_BUFFER)
    if piece.uv is not None:
        attributes["TEXCOORD_0"] = blob.accessor(piece.uv, "VEC2", _ARRAY_BUFFER)
    indices = blob.accessor(np.asarray(piece.faces, np.uint32).reshape(-1), "SCALAR", _ELEMENT_BUFFER)
    made: dict[str, Any] = {"attributes": attributes, "indices": indices, "material": material}
    if features is None or piece.feature is None:
        return made
    present = np.unique(piece.feature[piece.feature < features.count])
    if not len(present):
        return made
    attributes[FEATURE_ID] = blob.accessor(piece.feature.astype(np.float32), "SCALAR", _ARRAY_BUFFER)
    return {**made, "extensions": {MESH_FEATURES: marked(features, len(present))}}


def _material(material: GlbMaterial, pictures: Sequence[GlbMaterial]) -> dict[str, Any]:
    pbr: dict[str, Any] = {"metallicFactor": 0.0, "roughnessFactor": material.roughness}
    found: dict[str, Any] = {"name": material.name, "doubleSided": True, "pbrMetallicRoughness": pbr}
    if material.texture is None:
        pbr["baseColorFactor"] = [*material.colour, 1.0]
        return found
    pbr["baseColorTexture"] = {"index": next(k for k, m in enumerate(pictures) if m is material)}
    # A photograph already contains the light of the scene.
    return {**found, "extensions": {"KHR_materials_unlit": {}}}


def _container(text: bytes, binary: bytes) -> bytes:
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    if binary:
        chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
