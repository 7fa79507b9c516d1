"""Mosaics of the Ingolstadt scene against its true ortho-images: likeness, and coverage of wall and glass."""

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from _common import DATA, bootstrap, figure, table
from frontage.geometry.arrays import Array, Bool, Float
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.model import Facade, OrthoImage, Scan
from frontage.ortho import OrthoOptions, make_ortho
from frontage.pipeline.store.store import Store

SCENE = DATA / "ingolstadt_scene"
PHOTOS = {"path": "input/photos_small/*.jpg", "cameras": "input/registered/colmap_small"}
OFFSET = (678057.0, 5403871.0, 415.0)
BLOCK_M = 2.0  # blocks of the facade are drawn for intervals: neighbouring pixels are not independent
FOOT_M = (0.1, 0.8)  # before a wall: where the scan tells the height of the pavement
PAVED_M = 0.15  # above the lowest point before a wall: kerbs are lower
COLUMN_M = 1.0  # along the wall, in which that height is one
SAME = 0.5  # correlation with the true ortho-image from which a photo is taken to show the wall there
ALIKE_PX = 6.0  # sigma of the window of that correlation
GAMMA = 2.2
METHODS = {
    "Frontage": OrthoOptions(gsd=0.01),
    "light as shot": OrthoOptions(gsd=0.01, radiometry="as shot"),
    "paper A: one photo, homography, bilinear": OrthoOptions(
        gsd=0.01, radiometry="as shot", projection="homography", interpolation="bilinear", max_photos=1
    ),
}


@dataclass(frozen=True, eq=False)
class TrueFacade:
    """The truth of one facade: its table, and where (h, w, 3) m in the world its true ortho-image lies."""

    table: dict[str, Any]

    @cached_property
    def xyz(self) -> Float:
        """World coordinates (h, w, 3) m of the pixels of the true ortho-image."""
        t, o = self.table, self.table["ortho"]
        u = o["u0"] + (np.arange(o["width"]) + 0.5) * o["px"]
        v = o["v1"] - (np.arange(o["height"]) + 0.5) * o["px"]
        across = u[None, :, None] * np.array(t["e_u"]) + v[:, None, None] * np.array(t["e_v"])
        return np.array(t["origin"]) + across

    def band(self, name: str) -> Array:
        """A picture of the truth: "file" (BGR), "ids" or "wallmask"."""
        found = cv2.imread(str(SCENE / "truth" / self.table["ortho"][name]), cv2.IMREAD_UNCHANGED)
        assert found is not None
        return np.asarray(found)


def ingolstadt(run: Path | None) -> None:
    """Prints the figures of all methods on the facades that have a true ortho-image.

    `run` is a finished run of the scene; without it the facades are found first.
    """
    if not SCENE.exists():
        print(f"\n{SCENE} is absent: the Ingolstadt scene is left out")
        return
    with tempfile.TemporaryDirectory() as name:
        store = Store(run or _run(Path(name)))
        truths = json.loads((SCENE / "truth/truth.json").read_text())["facades"]
        rows = []
        for truth in (TrueFacade(t) for t in truths if "ortho" in t):
            facade = _matching(store, truth)
            if facade is not None:
                rows += _rows(store, facade, truth)
        header = ["facade", "method", "PSNR", "SSIM", "wall seen", "painted unseen", "glass seen"]
        table("Ingolstadt, six photos of 2.9 MP, scan of 4 cm, 1 cm per pixel", header, rows)


def _run(folder: Path) -> Path:
    """Finds the facades of the scene with the command line; returns the run folder."""
    source = SCENE / "input"
    project = folder / "project.toml"
    project.write_text(
        f'[project]\ncrs = "EPSG:25832"\n[[scans]]\npath = "{source}/registered/scan_4cm.laz"\n'
        f'stations = "{source}/registered/scan_4cm.laz.stations.json"\n'
        f'[model]\npath = "{source}/lod2/lod2.city.json"\n'
    )
    out = folder / "out"
    subprocess.run(
        [sys.executable, "-m", "frontage", "run", str(project), "-o", str(out), "--quiet"], check=True
    )
    return out


def _matching(store: Store, truth: TrueFacade) -> Facade | None:
    """The facade of the run that looks the same way from the same place as a true one."""
    middle = truth.xyz.reshape(-1, 3).mean(0)
    normal = np.cross(truth.table["e_u"], truth.table["e_v"])
    for name in store.facade_ids():
        facade = store.facade(name)
        local = facade.frame.inverse.apply(facade.world.to_local(middle[None]))[0]
        x0, z0, x1, z1 = facade.extent
        inside = x0 < local[0] < x1 and z0 < local[2] < z1 and abs(local[1]) < 1.0
        if inside and abs(facade.frame.R[:, 1] @ normal) > 0.95:
            return facade
    return None


def _rows(store: Store, facade: Facade, truth: TrueFacade) -> list[list[str]]:
    photos = read_photos(
        PhotoSource(path=str(SCENE / PHOTOS["path"]), cameras=str(SCENE / PHOTOS["cameras"]), offset=OFFSET),
        facade.world,
    )
    cloud, street = store.working_cloud(facade.building), store.surroundings()
    seen = _seen(photos, facade, truth) & _above_ground(cloud, facade, truth)
    rows = []
    for method, options in METHODS.items():
        ortho = make_ortho(facade, cloud, photos.photos, photos.image, surroundings=street, options=options)
        assert isinstance(ortho, OrthoImage), ortho
        rows.append([facade.id, method, *_figures(ortho, truth, seen)])
    return rows


def _seen(photos: PhotoSet, facade: Facade, truth: TrueFacade) -> Bool:
    """Where (h, w) a photo shows the wall: it correlates with the true ortho-image."""
    xyz, grey = facade.world.to_local(truth.xyz.reshape(-1, 3)), _grey(truth.band("file"))
    best = np.full(grey.shape, -1.0, np.float32)
    for photo in photos.photos:
        at = np.nan_to_num(photo.project(xyz).reshape(*grey.shape, 2), nan=-9.0).astype(np.float32) - 0.5
        shown = cv2.cvtColor(photos.image(photo.id), cv2.COLOR_RGB2GRAY)
        own = cv2.remap(shown, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderValue=0).astype(np.float32)
        a, b = own - _mean(own), grey - _mean(grey)
        best = np.maximum(best, _mean(a * b) / np.sqrt(_mean(a * a) * _mean(b * b) + 4.0))
    return np.asarray(best > SAME)


def _above_ground(cloud: Scan, facade: Facade, truth: TrueFacade) -> Bool:
    """Where (h, w) the wall stands above the pavement: the true ortho-image goes on below it."""
    x, y, z = facade.frame.inverse.apply(cloud.xyz).T
    before = (y > -FOOT_M[1]) & (y < -FOOT_M[0])
    first = np.floor(x[before].min() / COLUMN_M)
    column = np.floor(x[before] / COLUMN_M - first).astype(int)
    low = np.array([_pavement(z[before][column == n]) for n in range(int(column.max()) + 1)])
    low[np.isnan(low)] = np.nanmedian(low)
    at = facade.frame.inverse.apply(facade.world.to_local(truth.xyz.reshape(-1, 3)))
    mine = np.clip(np.floor(at[:, 0] / COLUMN_M - first).astype(int), 0, len(low) - 1)
    return np.asarray((at[:, 2] > low[mine]).reshape(truth.xyz.shape[:2]))


def _pavement(z: Float) -> float:
    """Height m of the pavement in points (n,) before a wall, the middle of its lowest; NaN without any."""
    return float(np.median(z[z < z.min() + PAVED_M])) if len(z) else float("nan")


def _figures(ortho: OrthoImage, truth: TrueFacade, seen: Bool) -> list[str]:
    """PSNR, SSIM, and the shares painted of wall that a photo sees, of other wall, and of visible glass."""
    pixel, _ = ortho.world_to_pixel(truth.xyz.reshape(-1, 3))
    u, v = (c.reshape(seen.shape).astype(np.float32) - 0.5 for c in pixel.T)
    bgra = np.ascontiguousarray(ortho.pixels[..., [2, 1, 0, 3]])
    shown = cv2.remap(bgra, u, v, cv2.INTER_LINEAR, borderValue=0)
    known, wall = shown[..., 3] > 250, truth.band("wallmask") > 0
    true = truth.band("file")
    mine = _same_light(shown[..., :3], true, known & wall)
    blocks = _blocks(seen.shape, truth.table["ortho"]["px"])
    error = ((mine - true) ** 2).mean(-1)
    likeness = _ssim(_grey(mine), _grey(true))
    inner = cv2.erode((known & wall).astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
    return [
        figure(_over_blocks(error, known & wall, blocks, lambda e: 10 * np.log10(255**2 / e)), "dB"),
        figure(_over_blocks(likeness, inner, blocks)),
        figure(_over_blocks(100.0 * known, wall & seen, blocks), "%", 4),
        figure(_over_blocks(100.0 * known, wall & ~seen, blocks), "%"),
        _glass(known, truth),
    ]


def _glass(known: Bool, truth: TrueFacade) -> str:
    """The share painted of the glass that a photo sees; an interval over the openings."""
    ids, shares = truth.band("ids"), []
    for opening in truth.table["openings"]:
        mine = ids == opening["image_id"]
        visible = opening["visible_photo"] * float(mine.sum())
        if visible > 0:
            shares.append((min(float(known[mine].sum()), visible), visible))
    values = np.array(shares).reshape(-1, 2)
    numbers = np.arange(len(values))
    share = bootstrap(numbers, lambda n: float(100.0 * np.divide(*values[n.astype(int)].sum(0))))
    return figure(share, "%", 4)


def _same_light(shown: Array, true: Array, where: Bool) -> Array:
    """The picture (h, w, 3) after one gain per channel in linear light, as codes float64."""
    mine, other = ((p.astype(np.float64) / 255.0) ** GAMMA for p in (shown, true))
    gain = np.median(other[where], axis=0) / np.median(mine[where], axis=0)
    return np.asarray(255.0 * np.clip(mine * gain, 0.0, 1.0) ** (1.0 / GAMMA))


def _ssim(a: Array, b: Array) -> Array:
    """Structural similarity (h, w) of two grey pictures (Wang et al. 2004, a Gaussian of 1.5 px)."""

    def mean(p: Array) -> Array:
        return np.asarray(cv2.GaussianBlur(p, (0, 0), 1.5))

    ma, mb = mean(a), mean(b)
    va, vb, c = mean(a * a) - ma**2, mean(b * b) - mb**2, mean(a * b) - ma * mb
    return ((2 * ma * mb + 6.5) * (2 * c + 58.5)) / ((ma**2 + mb**2 + 6.5) * (va + vb + 58.5))


def _blocks(shape: tuple[int, int], px: float) -> Array:
    """The number (h, w) of the block of `BLOCK_M` that a pixel lies in."""
    r, c = (np.arange(n) // max(1, round(BLOCK_M / px)) for n in shape)
    return np.asarray(r[:, None] * (int(c[-1]) + 1) + c)


def _over_blocks(
    value: Array, where: Bool, blocks: Array, last: Any = lambda mean: mean
) -> tuple[float, float, float]:
    """The mean of values (h, w), passed through `last`, with its interval over blocks."""
    number = np.bincount(blocks[where], minlength=int(blocks.max()) + 1)
    total = np.bincount(blocks[where], value[where], len(number))
    used = np.flatnonzero(number)
    if not len(used):
        return (float("nan"),) * 3

    def mean(n: Array) -> float:
        k = used[n.astype(int)]
        return float(last(total[k].sum() / number[k].sum()))

    return bootstrap(np.arange(len(used)), mean)


def _grey(bgr: Array) -> Array:
    return np.asarray(cv2.cvtColor(bgr.astype(np.float32), cv2.COLOR_BGR2GRAY))


def _mean(values: Array) -> Array:
    return np.asarray(cv2.GaussianBlur(values, (0, 0), ALIKE_PX))
