"""Mosaics of facades from many photos: seams, ghosts, occluders, coverage, colours and places.

Simulated streets with trees, cars that move and walkers, photos of unlike exposure and white balance, with
true facades and true poses. Every line of the table is the median over facades with its 95 % interval:

- step, edge: colour difference (CIE Lab) across seams less that across parallel lines 5 to 10 px beside, of
  means over 4 px and from pixel to pixel; 0 = no seam can be seen
- sharp, alike: sharpness of tiles against the sharpest single photo, correlation with the likest one
- occluder: share of the painted facade that shows a tree, a car, a lamp or a pedestrian
- wall, glass: share painted of what at least one photo sees
- colour: mean difference (CIE Lab) to the facade in even light after one gain per channel
- shift: median displacement against the true ortho-image, px

A line below tells how many of the things before the facades are in their `occluders.json`. Five more parts:
facades of other streets that one, two or three photos see; what is drawn on walkers near the wall on narrow
pavements; the Ingolstadt scene against its true ortho-images, beside paper A's homography of one photo; the
time of a facade of 30 x 15 m over that of decoding its photos; and the memory for a street of 200 photos.

    python benchmarks/bench_mosaic.py [--quick] [--only PART] [--views DIR] [--kept DIR] [--run DIR]

`--quick` takes the first street only; `--views` writes the pictures as PNG; `--kept` keeps the simulated
large facade for the next time (two and a half minutes); `--run` names a finished run of the Ingolstadt scene.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from _common import bootstrap, figure, table
from _fewphotos import few_photos
from _mosaics import CASES, Single, Street, front, record, seen_wall, single_photos
from _mosaicscore import figures
from _mosaictime import many_photos, time_of_a_large_front
from _mosaictruth import ingolstadt
from _pavements import walkers
from _standing import StandingScore
from frontage.geometry.arrays import Array
from frontage.model import NOT_SEEN, Facade, OrthoImage
from frontage.ortho import OrthoOptions, make_ortho

GSD = 0.02
FIGURES = {
    "step": "", "edge": "", "sharp": "", "alike": "", "occluder": "%", "wall": "%", "glass": "%",
    "colour": "", "shift": "px",
}  # fmt: skip
OPTIONS = OrthoOptions(gsd=GSD)
PARTS = ("many", "streets", "few", "walkers", "ingolstadt", "time")
Mosaic = tuple[Array, Array]
"""Pixels (h, w, 3 or 4) uint8, and 1 + the number of the photo of every pixel; 0 = empty, -1 = several."""


def made(street: Street, facade: Facade) -> OrthoImage:
    """The ortho-image that the library makes."""
    ortho = make_ortho(facade, street.scan, street.photos, street.images.__getitem__, options=OPTIONS)
    assert isinstance(ortho, OrthoImage), ortho
    return ortho


def renumbered(ortho: OrthoImage, street: Street) -> Array:
    """The sources (h, w) as 1 + the number of the photo in the street; 0 = empty or from the scan."""
    names = [p.id for p in street.photos]
    lookup = [0, *(names.index(s) + 1 if s in names else 0 for s in ortho.sources)]
    return np.array(lookup)[np.where(ortho.source == NOT_SEEN, 0, ortho.source)]


def average(singles: list[Single]) -> Mosaic:
    """The mean of all photos that show a pixel."""
    weight = np.sum([one.shown for one in singles], axis=0)
    total = np.sum([one.pixels * one.shown[..., None].astype(np.float64) for one in singles], axis=0)
    pixels = np.rint(total / np.maximum(weight, 1)[..., None]).astype(np.uint8)
    return pixels, np.where(weight > 0, -1, 0)


def best_view(singles: list[Single]) -> Mosaic:
    """The photo with the finest pixels on the facade, pixel by pixel."""
    gsd = np.stack([one.gsd for one in singles])
    best = np.argmin(gsd, axis=0)
    pixels = np.take_along_axis(np.stack([one.pixels for one in singles]), best[None, ..., None], 0)[0]
    return pixels, np.where(np.isfinite(gsd.min(0)), best + 1, 0)


def opencv_pieces(singles: list[Single]) -> Mosaic:
    """OpenCV's stitching pieces on the rectified photos: gains, seams by dynamic programming, five bands."""
    used = [k for k, one in enumerate(singles) if one.shown.any()]
    pictures = [np.ascontiguousarray(singles[k].pixels[..., ::-1]) for k in used]
    masks = [np.where(singles[k].shown, 255, 0).astype(np.uint8) for k in used]
    corners = [(0, 0)] * len(used)
    gains = cv2.detail.ExposureCompensator_createDefault(cv2.detail.ExposureCompensator_CHANNELS)
    gains.feed(corners, [cv2.UMat(p) for p in pictures], [cv2.UMat(m) for m in masks])
    pictures = [
        gains.apply(n, (0, 0), p.copy(), m) for n, (p, m) in enumerate(zip(pictures, masks, strict=True))
    ]
    finder = cv2.detail_DpSeamFinder("COLOR_GRAD")
    seams = finder.find([p.astype(np.float32) for p in pictures], corners, [m.copy() for m in masks])
    seams = [s.get() if isinstance(s, cv2.UMat) else s for s in seams]
    h, w = masks[0].shape
    blender = cv2.detail.MultiBandBlender(0, 5)
    blender.prepare((0, 0, w, h))
    source = np.zeros((h, w), np.int64)
    for k, picture, mask in zip(used, pictures, seams, strict=True):
        blender.feed(picture.astype(np.int16), mask, (0, 0))
        source[(mask > 0) & (source == 0)] = k + 1
    blended, _ = blender.blend(None, None)
    return np.clip(blended[..., ::-1], 0, 255).astype(np.uint8), source


def measure(
    case_name: str, street: Street, house: int, views: Path | None, standing: StandingScore
) -> dict[str, dict[str, float]]:
    """The figures of all methods on one facade; `standing` counts what stands before it."""
    facade = front(street, house)
    ortho = made(street, facade)
    standing.add(street, facade, ortho.occluders)
    truth = seen_wall(street, house, ortho)
    singles = single_photos(street, facade, OPTIONS)
    shown: dict[str, Mosaic] = {
        "Frontage": (ortho.pixels, renumbered(ortho, street)),
        "best view": best_view(singles),
        "average": average(singles),
        "OpenCV's pieces": opencv_pieces(singles),
    }
    if views is not None:
        save(
            views, f"{case_name}-{facade.building}", {**shown, "truth": (truth.rgb, truth.wall | truth.glass)}
        )
    return {name: figures(pixels, source, singles, truth) for name, (pixels, source) in shown.items()}


def save(folder: Path, name: str, shown: dict[str, Mosaic]) -> None:
    """Write every mosaic as PNG; empty pixels are magenta."""
    folder.mkdir(parents=True, exist_ok=True)
    for method, (pixels, source) in shown.items():
        image = np.where((source != 0)[..., None], pixels[..., 2::-1], np.array([255, 0, 255], np.uint8))
        cv2.imwrite(str(folder / f"{name}-{method.replace(' ', '_')}.png"), image.astype(np.uint8))


def simulated(streets: Iterator[tuple[str, Street]], views: Path | None) -> None:
    """Prints the figures of all methods on simulated streets."""
    found: dict[str, list[dict[str, float]]] = {}
    standing = StandingScore()
    for name, street in streets:
        for house in range(len(street.scene.houses)):
            for method, one in measure(name, street, house, views, standing).items():
                found.setdefault(method, []).append(one)
                print(f"{name} house {house} {method}: " + ", ".join(f"{k} {v:.3g}" for k, v in one.items()))
    rows = []
    for method, results in found.items():
        row = [method]
        for key, unit in FIGURES.items():
            values = np.array([r[key] for r in results]) * (100 if unit == "%" else 1)
            values = values[np.isfinite(values)]
            row.append(figure(bootstrap(values), unit) if len(values) else "-")
        rows.append(row)
    count = len(next(iter(found.values())))
    table(f"Mosaics of {count} simulated facades at {GSD * 100:g} cm", ["method", *FIGURES], rows)
    print(f"\nTrees, cars, lamps and people before them: {standing}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="the first street only")
    parser.add_argument("--only", choices=PARTS, help="one part instead of all")
    parser.add_argument("--views", type=Path, help="folder for the pictures")
    parser.add_argument("--kept", type=Path, help="folder that keeps the simulated large facade")
    parser.add_argument("--run", type=Path, help="finished run of the Ingolstadt scene")
    given = parser.parse_args()
    cases = CASES[:1] if given.quick else CASES
    parts = [given.only] if given.only else PARTS
    if "many" in parts:  # first, because the peak of the memory is that of the whole process
        many_photos()
    if "streets" in parts:
        simulated(((f"street{n}", record(case)) for n, case in enumerate(cases)), given.views)
    if "few" in parts:
        few_photos(given.quick)
    if "walkers" in parts:
        walkers(given.quick)
    if "ingolstadt" in parts:
        ingolstadt(given.run)
    if "time" in parts:
        time_of_a_large_front(given.kept)
