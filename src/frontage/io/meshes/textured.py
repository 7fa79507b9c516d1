"""Writing textured meshes: binary glTF 2.0 (GLB, see `glb`) and Wavefront OBJ."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.io.files import whole_file
from frontage.io.meshes.glb import GlbMaterial, GlbMesh, GlbPiece, glb_of
from frontage.model import WorldRef


@dataclass(frozen=True, eq=False)
class TexturedMesh:
    """Triangles with one JPEG texture.

    name             unique, readable ("B07/F1")
    xyz              (n, 3) float64 m in the mesh's own frame
    uv               (n, 2) float64, 0..1, v downwards from the texture's upper edge
    faces            (m, 3) int, counter-clockwise seen from outside
    local_from_mesh  (4, 4) float64
    texture          JPEG bytes
    extras           JSON-able facts that are stored with the mesh
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


def glb_bytes(meshes: Sequence[TexturedMesh], world: WorldRef, left_out: Sequence[str] = ()) -> bytes:
    """The bytes of one GLB with all meshes and their textures; equal meshes give equal bytes."""
    return glb_of([_whole(m) for m in meshes], world, left_out=left_out)


def _whole(mesh: TexturedMesh) -> GlbMesh:
    piece = GlbPiece(GlbMaterial(mesh.name, mesh.texture), mesh.xyz, mesh.faces, mesh.uv)
    return GlbMesh(mesh.name, (piece,), mesh.local_from_mesh, mesh.extras)


def write_glb(
    path: Path, meshes: Sequence[TexturedMesh], world: WorldRef, left_out: Sequence[str] = ()
) -> None:
    """Write the GLB of `glb_bytes`. Raises FileError when that fails."""
    _write(path, glb_bytes(meshes, world, left_out))


def write_obj(
    path: Path, meshes: Sequence[TexturedMesh], world: WorldRef, left_out: Sequence[str] = ()
) -> None:
    """Write an OBJ file, and beside it its .mtl, `textures/*.jpg` and `<stem>.offset.json`.

    Vertices are in local metres with z up, to 0.1 mm; world = vertex + offset. Texture coordinates have v
    upwards, as OBJ requires. The last file also says what the model does not show (`left_out`).

    Raises FileError when a file cannot be written.
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
        **({"left_out": list(left_out)} if left_out else {}),
    }
    _write(path.with_suffix(".offset.json"), (json.dumps(offset, indent=2) + "\n").encode())
    _write(path, _obj_text(meshes, path.with_suffix(".mtl").name).encode())


def _write(path: Path, data: bytes) -> None:
    with whole_file(path) as temporary:
        temporary.write_bytes(data)


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
