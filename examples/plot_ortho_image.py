"""An ortho-image from photographs, compared with the true one.

Simulates one house with a distorting lens, makes its ortho-image from two photos with true poses and measures
how far its details are from where they truly are. With a file name the picture is written:
``python plot_ortho_image.py out.png``.
"""

import json
import sys
import tempfile
from pathlib import Path

import cv2
import numpy as np

import frontage
from frontage.model import OrthoImage
from frontage.simulate.spec import parse_spec
from frontage.studies.simulate import simulate

SPEC = """
seed = 5
opposite = false
setting = "terrace"
trees = 0
cars = 0
lamps = 0
people = 0
hedges = false
[[house]]
width = 10.0
floors = 2
wall = "brick"
lean = 0.0
setback = 0.0
[[scanners]]
stations = 1
spacing = 0.04
subrays = 1
field = 180.0
lowest = -35.0
highest = 55.0
ranging = "pulsed"
[[cameras]]
width = 1000
height = 750
samples = 1
most = 2
[output]
gsd = 0.02
"""
GSD = 0.02  # m per pixel
TILE = 32  # px
PLAIN = 0.02  # m: only the plain wall is compared, because sills and frames move with their shadows


def read_truth(scene: Path) -> tuple[np.ndarray, np.ndarray, dict]:
    """The true ortho-image of the street facade (h, w), where it shows plain wall, and its entry."""
    truth = json.loads((scene / "truth" / "truth.json").read_text())
    facade = next(f for f in truth["facades"] if f["id"] == "B01/F1")
    picture = cv2.imread(str(scene / facade["ortho"]["file"]), cv2.IMREAD_GRAYSCALE)
    depth = np.load(scene / facade["ortho"]["arrays"])["depth"]
    return picture, (np.abs(depth) < PLAIN).astype(np.uint8), facade


def true_to_found(facade: dict, ortho: OrthoImage) -> np.ndarray:
    """The affine map (2, 3) from pixels of the true picture to pixels of the found one, through the world."""
    raster, frame = facade["ortho"], facade["frame"]
    pixels = np.float32([[0, 0], [raster["width"], 0], [0, raster["height"]]])
    x = raster["corner"][0] + pixels[:, :1] * raster["gsd"]
    z = raster["corner"][1] - pixels[:, 1:] * raster["gsd"]
    world = np.array(frame["origin"]) + x * np.array(frame["x"]) + z * np.array(frame["z"])
    found, _ = ortho.world_to_pixel(world)
    half = 0.5  # OpenCV counts from the centre of the first pixel
    return cv2.getAffineTransform(pixels - half, np.float32(found - half))


def displacements(true: np.ndarray, found: np.ndarray, usable: np.ndarray) -> np.ndarray:
    """Shift (n, 2) px, right and down, of every usable tile that correlates, by phase correlation."""
    window = cv2.createHanningWindow((TILE, TILE), cv2.CV_32F)
    shifts = []
    for row in range(0, true.shape[0] - TILE + 1, TILE // 2):
        for column in range(0, true.shape[1] - TILE + 1, TILE // 2):
            tile = slice(row, row + TILE), slice(column, column + TILE)
            if usable[tile].all():
                shift, response = cv2.phaseCorrelate(np.float32(true[tile]), np.float32(found[tile]), window)
                if response > 0.3:
                    shifts.append(shift)
    return np.array(shifts)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder) / "scene"
        simulate(parse_spec(SPEC), scene)
        scan = frontage.read_scans(*sorted((scene / "scans").glob("*.e57")))
        photos = frontage.read_photos(scene / "photos", scan, cameras=scene / "cameras", **offset_of(scene))
        building = frontage.find_buildings(scan).buildings[0]
        facade = frontage.find_facades(scan, building)[0]
        ortho = frontage.make_ortho(facade, scan, photos, gsd=GSD)
        if not ortho:
            raise SystemExit(ortho.message)
        picture, plain, truth = read_truth(scene)
    warp = true_to_found(truth, ortho)
    picture, plain = (cv2.warpAffine(one, warp, ortho.size) for one in (picture, plain))
    found = cv2.cvtColor(ortho.pixels[..., :3], cv2.COLOR_RGB2GRAY)
    shifts = displacements(picture, found, (plain == 1) & (ortho.pixels[..., 3] == 255))
    length = np.linalg.norm(shifts, axis=1)
    width, height = ortho.size
    print(f"ortho-image {width} x {height} px at {GSD * 100:g} cm from {len(ortho.sources)} photos")
    print(f"{len(shifts)} tiles of plain wall: median displacement {np.median(length):.2f} px,")
    print(f"mean {shifts[:, 0].mean():+.2f} px to the right, {shifts[:, 1].mean():+.2f} px downwards")
    if len(sys.argv) > 1:
        cv2.imwrite(sys.argv[1], cv2.cvtColor(ortho.pixels, cv2.COLOR_RGBA2BGRA))


def offset_of(scene: Path) -> dict:
    """The offset that brings the cameras of the scene into the world."""
    numbers = (scene / "cameras" / "offset.txt").read_text().replace(",", " ").split()
    return {"offset": tuple(float(v) for v in numbers)}


if __name__ == "__main__":
    main()
