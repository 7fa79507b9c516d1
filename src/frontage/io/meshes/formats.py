"""The registry of formats for textured meshes. A new format is one writer, and one entry here."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from frontage.errors import UnsupportedFormat
from frontage.io.meshes.textured import TexturedMesh
from frontage.model import WorldRef

Writer = Callable[[Path, Sequence[TexturedMesh], WorldRef], None]


@dataclass(frozen=True)
class MeshFormat:
    """A kind of file with textured meshes.

    name    as users know it
    suffix  of its files, lower case
    holds   what a file keeps of the meshes
    writer  "module:function", imported when it is first used
    """

    name: str
    suffix: str
    holds: str
    writer: str

    def write(self, path: Path, meshes: Sequence[TexturedMesh], world: WorldRef) -> None:
        """Write a file of this format. Raises FileError when that fails."""
        module, function = self.writer.split(":")
        writer: Writer = getattr(import_module(module), function)
        writer(path, meshes, world)


FORMATS = (
    MeshFormat(
        "binary glTF 2.0",
        ".glb",
        "meshes, pictures, facts and the offset to the world in one file",
        "frontage.io.meshes.textured:write_glb",
    ),
    MeshFormat(
        "Wavefront OBJ",
        ".obj",
        "meshes; materials, pictures and the offset to the world in files beside it",
        "frontage.io.meshes.textured:write_obj",
    ),
)


def write_meshes(path: str | Path, meshes: Sequence[TexturedMesh], world: WorldRef) -> None:
    """Write textured meshes in the format that the suffix of `path` names.

    Raises UnsupportedFormat for another suffix, and FileError when the file cannot be written.
    """
    p = Path(path)
    found = next((f for f in FORMATS if f.suffix == p.suffix.lower()), None)
    if found is None:
        known = ", ".join(f.suffix for f in FORMATS)
        raise UnsupportedFormat(
            p, f"the suffix {p.suffix!r} is not one of a mesh format", f"use one of {known}"
        )
    found.write(p, meshes, world)
