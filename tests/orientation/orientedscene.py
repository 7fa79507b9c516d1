"""A simulated scene whose photos are oriented, shared by the tests of the stage and of the command.

The scene and the runs are made once for all workers, whoever asks first.
"""

import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from frontage.pipeline import run as chain
from frontage.pipeline.project import Project, load_project
from frontage.pipeline.run import Summary
from frontage.pipeline.stage import Stage
from frontage.simulate.spec import parse_spec
from frontage.studies.simulate import simulate
from once import once

SPEC = """
name = "oriented"
seed = 3
opposite = false
setting = "terrace"
street_width = 15.0
slope = 1.0
trees = 0
cars = 1
people = 0
lamps = 0
[[house]]
width = 8.5
floors = 2
wall = "plaster"
lean = 0
[[house]]
width = 7.0
floors = 3
wall = "brick"
lean = 0
[[scanners]]
stations = 2
spacing = 0.06
field = 150
lowest = -20
highest = 50
subrays = 1
[[cameras]]
width = 1120
height = 840
samples = 1
layout = "places"
sigma_position = 1.5
sigma_heading = 4.0
sigma_level = 1.0
[[cameras.places]]
along = 4.0
across = -12.0
heading = 6.0
pitch = 12.0
[[cameras.places]]
along = 7.5
across = -12.5
heading = 0.0
pitch = 12.0
[[cameras.places]]
along = 11.0
across = -12.2
heading = -6.0
pitch = 11.0
[output]
gsd = 0.05
"""
SIGMA_POSITION, SIGMA_ANGLE = 1.5, 4.0  # of the approximate poses: m, degrees
_ORIENTING = ("scans", "register", "keypoints", "matches", "orient")
_IMAGING = (*_ORIENTING, "buildings", "facades", "ortho")


def scene_of(factory: pytest.TempPathFactory) -> Path:
    """Returns the folder of the simulated scene."""
    return once(factory, "oriented_scene", lambda folder: simulate(parse_spec(SPEC), folder))


def finished_run(factory: pytest.TempPathFactory) -> tuple[Path, Summary]:
    """Returns the folder of a run up to `ortho` with approximate poses, and its summary; copy before use."""
    scene = scene_of(factory)

    def make(folder: Path) -> None:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(chain, "STAGES", imaging())
            summary = chain.run(project_of(scene), folder / "out")
        (folder / "summary.pickle").write_bytes(pickle.dumps(summary))

    folder = once(factory, "oriented_run", make)
    return folder / "out", pickle.loads((folder / "summary.pickle").read_bytes())


def imaging() -> tuple[Stage, ...]:
    """Returns the stages that use oriented photos first, and those before them."""
    return tuple(s for s in chain.STAGES if s.name in _IMAGING)


def project_of(scene: Path, **photos: Any) -> Project:
    """Returns the project of a scene with approximate poses, with changes to its table of photos."""
    table = {
        "cameras": str(scene / "cameras_approximate"),
        "pose": "approximate",
        "sigma_position": SIGMA_POSITION,
        "sigma_angle": SIGMA_ANGLE,
        **photos,
    }
    table = {key: value for key, value in table.items() if value is not None}
    return load_project(scene / "project.toml", {"photos": table, "orientation": {"key_points": 2500}})


def pair_run(factory: pytest.TempPathFactory) -> Path:
    """Returns the folder of a run of two photos without any pose, up to `orient`; copy before changes."""
    scene = scene_of(factory)
    nothing = {"pose": "none", "sigma_position": None, "sigma_angle": None}

    def make(folder: Path) -> None:
        folder.mkdir()
        with pytest.MonkeyPatch.context() as patch:
            photos = some_photos(scene, folder, (2, 3))
            only_orienting(patch)(project_of(scene, **photos, **nothing), folder / "pair")

    return once(factory, "oriented_pair", make) / "pair"


def only_orienting(monkeypatch: pytest.MonkeyPatch) -> Callable[[Project, Path], None]:
    """Returns a function that runs the chain up to `orient`."""
    stages = tuple(s for s in chain.STAGES if s.name in _ORIENTING)

    def orient(project: Project, out: Path) -> None:
        with monkeypatch.context() as patch, pytest.raises(Exception, match="no ortho-image could be made"):
            patch.setattr(chain, "STAGES", stages)
            chain.run(project, out)

    return orient


def with_strangers(scene: Path, folder: Path) -> dict[str, str]:
    """Makes photos and cameras of the scene with a copy of its second photo and a picture of noise.

    Returns the table of photos that names them.
    """
    shutil.copytree(scene / "photos", folder / "photos")
    shutil.copytree(scene / "cameras_approximate", folder / "cameras")
    shutil.copy(folder / "photos" / "IMG_0002.jpg", folder / "photos" / "copy.jpg")
    cv2.imwrite(str(folder / "photos" / "stranger.jpg"), noise(840, 1120))
    listing = folder / "cameras" / "images.txt"
    lines = listing.read_text().splitlines()
    for number, (name, like) in enumerate((("copy.jpg", "IMG_0002"), ("stranger.jpg", "IMG_0003"))):
        (at,) = (k for k, line in enumerate(lines) if like in line and line.endswith(".jpg"))
        words = lines[at].split()
        lines += [" ".join([str(900 + number), *words[1:-1], name]), ""]
    listing.write_text("\n".join(lines) + "\n")
    return {"path": str(folder / "photos" / "*.jpg"), "cameras": str(folder / "cameras")}


def noise(height: int, width: int, seed: int = 1) -> np.ndarray:
    """Returns a picture (h, w, 3) uint8 with detail of all sizes that shows nothing."""
    rng = np.random.default_rng(seed)
    total = np.zeros((height, width), np.float32)
    for step in (3, 8, 25, 80):
        grain = rng.normal(size=(height // step + 3, width // step + 3)).astype(np.float32)
        total += cv2.resize(grain, (width, height), interpolation=cv2.INTER_CUBIC)
    return np.repeat(np.clip(120 + 35 * total, 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def some_photos(scene: Path, folder: Path, numbers: tuple[int, ...]) -> dict[str, Any]:
    """Makes cameras of some photos of the scene alone; returns the table of photos that names them."""
    names = [f"IMG_{number:04d}.jpg" for number in numbers]
    cameras = folder / "cameras"
    shutil.copytree(scene / "cameras_approximate", cameras)
    lines = (cameras / "images.txt").read_text().splitlines()
    kept: list[str] = []
    for k, line in enumerate(lines):
        if line.endswith(tuple(names)):
            kept += [line, lines[k + 1] if k + 1 < len(lines) else ""]
    (cameras / "images.txt").write_text("\n".join(kept) + "\n")
    return {"path": [str(scene / "photos" / name) for name in names], "cameras": str(cameras)}
