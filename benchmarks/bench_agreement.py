"""Ortho-images of one facade from different photos: how far apart they show the same detail.

For every facade of a run folder that has photos: one ortho-image per photo, on the plane and on the relief,
and the shifts between pairs of them by phase correlation of tiles that both photos show and that have some
texture. A tile counts when the two correlate by 0.6 after the shift; "alike" is the share that does. "On
the wall" are tiles whose points lie within 2 cm of the plane: disagreement there is due to the plane or the
poses.

    python benchmarks/bench_agreement.py [RUN_FOLDER PHOTOS CAMERAS [GSD]]

Without arguments it runs the castle photos of the shared data.
"""

import sys
import tempfile
from itertools import combinations
from pathlib import Path

import cv2
import numpy as np

from _common import DATA, bootstrap, figure, table
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.io.scans.npz import load_scan
from frontage.ortho import OrthoOptions, make_ortho
from frontage.pipeline.project import make_project
from frontage.pipeline.run import run
from frontage.pipeline.store.records import load_facade
from frontage.pipeline.store.store import Store

TILE = 128  # px
CORRELATED = 0.6  # of two tiles after the shift: the same thing is seen
TEXTURE = 4.0  # grey values, rms of the high-passed tile
PHOTOS = 8  # per facade


def flattened(pixels):
    """Remove from grey values what varies over a whole tile: shadows, exposure."""
    grey = cv2.cvtColor(np.ascontiguousarray(pixels[..., :3]), cv2.COLOR_RGB2GRAY).astype(np.float32)
    return cv2.GaussianBlur(grey, (0, 0), 1.0) - cv2.GaussianBlur(grey, (0, 0), 8.0)


def shift_of(a, b):
    """Shift (2,) px of tile b against a and the correlation of the two after it."""
    window = cv2.createHanningWindow((TILE, TILE), cv2.CV_32F)
    move, _ = cv2.phaseCorrelate(a * window, b * window)
    M = np.array([[1, 0, move[0]], [0, 1, move[1]]], np.float32)
    back = cv2.warpAffine(b, M, (TILE, TILE), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    m = TILE // 5
    return np.array(move), np.corrcoef(a[m:-m, m:-m].ravel(), back[m:-m, m:-m].ravel())[0, 1]


def shifts(first, second, on_wall):
    """Shifts (n,) px of tiles of two ortho-images, which (n,) are on the wall; how many had texture."""
    both, tried = (first.source == 1) & (second.source == 1), 0
    a, b = flattened(first.pixels), flattened(second.pixels)
    found = []
    for r in range(0, a.shape[0] - TILE + 1, TILE // 2):
        for c in range(0, a.shape[1] - TILE + 1, TILE // 2):
            s = np.s_[r : r + TILE, c : c + TILE]
            if both[s].mean() < 0.999:
                continue
            if min(a[s].std(), b[s].std()) < TEXTURE:
                continue
            tried += 1
            move, correlation = shift_of(a[s], b[s])
            if correlation > CORRELATED:
                found.append((np.linalg.norm(move), on_wall[r // (TILE // 2), c // (TILE // 2)]))
    return np.array(found).reshape(-1, 2), tried


def wall_tiles(facade, scan, ortho):
    """Which tiles have at least five points, nine tenths of them within 2 cm of the plane."""
    xyz = facade.frame.inverse.apply(scan.xyz)
    xyz = xyz[np.abs(xyz[:, 1]) < 1.0]
    at = (xyz[:, [0, 2]] - ortho.corner) * [1, -1] / ortho.gsd
    step = TILE // 2
    out = np.zeros((ortho.size[1] // step + 1, ortho.size[0] // step + 1), bool)
    for r in range(out.shape[0]):
        for c in range(out.shape[1]):
            inside = (at >= [c * step, r * step]).all(1) & (at < [c * step + TILE, r * step + TILE]).all(1)
            y = xyz[inside, 1]
            out[r, c] = len(y) >= 5 and (np.abs(y) < 0.02).mean() >= 0.9
    return out


def main(run, photos, cameras, gsd=0.015):
    store = Store(Path(run))
    rows = []
    for folder in sorted((Path(run) / "facades").iterdir()):
        facade = load_facade(folder)
        scan = load_scan(store.buildings_folder / f"{facade.building}.npz")
        pictures = read_photos(PhotoSource(path=photos, cameras=cameras), facade.world)
        for name, relief in (("plane", False), ("relief", True)):
            options = OrthoOptions(gsd=gsd, relief=relief, margin=0.0)
            best = make_ortho(
                facade, scan, pictures.photos, pictures.image, surroundings=scan, options=options
            )
            made = []
            for photo in [p for p in pictures.photos if p.id in best.sources][:PHOTOS]:
                ortho = make_ortho(facade, scan, [photo], pictures.image, surroundings=scan, options=options)
                if ortho and ortho.sources[0] == photo.id and (ortho.source == 1).mean() > 0.2:
                    made.append(ortho)
            on_wall = wall_tiles(facade, scan, best)
            results = [shifts(a, b, on_wall) for a, b in combinations(made, 2)]
            pairs = [p for p, _ in results if len(p) >= 5]
            if pairs:
                share = sum(len(p) for p, _ in results) / sum(n for _, n in results)
                every = [np.median(p[:, 0]) for p in pairs]
                wall = [np.median(p[p[:, 1] > 0, 0]) for p in pairs if (p[:, 1] > 0).sum() >= 5]
                used = "relief" if np.isfinite(best.depth).any() else "plane"
                rows.append(
                    [
                        facade.id,
                        f"{name} ({used})",
                        len(made),
                        sum(map(len, pairs)),
                        f"{share:.0%}",
                        figure(bootstrap(every), "px"),
                        figure(bootstrap(wall), "px") if wall else "-",
                    ]
                )
                print(rows[-1], flush=True)
    table(
        f"Ortho-images of one facade from two photos at {gsd * 100:g} cm: shift, median over pairs",
        ["facade", "surface", "photos", "tiles", "alike", "all tiles", "tiles on the wall"],
        rows,
    )


def castle():
    """The castle photos, run from the start into a temporary folder."""
    photos, cameras = DATA / "castle_photos" / "images", DATA / "castle_photos" / "colmap"
    if not photos.is_dir():
        print(f"{photos} is not there, so nothing was measured")
        return
    with tempfile.TemporaryDirectory() as folder:
        run(make_project({"photos": {"path": str(photos), "cameras": str(cameras)}}, Path.cwd()), folder)
        main(folder, str(photos), str(cameras), 0.015)


if __name__ == "__main__":
    given = sys.argv[1:]
    if len(given) in (3, 4):
        main(*given[:3], *(float(g) for g in given[3:4]))
    elif given:
        sys.exit("usage: bench_agreement.py [RUN_FOLDER PHOTOS CAMERAS [GSD]]")
    else:
        castle()
