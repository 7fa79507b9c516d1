"""One picture of a run: a photo with the facades drawn into it, their ortho-images at one scale, the models.

``python examples/picture.py RUN PROJECT.toml out.jpg``; `make demo` does it for the simulated street.
"""

import sys
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np

from frontage.geometry.arrays import Array
from frontage.io.photos.read import PhotoSource, read_photos
from frontage.model import Facade, Photo
from frontage.pipeline.project import load_project
from frontage.pipeline.store.store import Store

HEIGHT = 900  # px, of the photo and the ortho-images
WIDTH = 2000  # px, of the whole picture
INK = (40, 60, 230)


def outlined(photo: Photo, image: Array, facades: list[Facade]) -> Array:
    """The photo with each facade's outline and a metre grid on its plane."""
    picture = image[..., ::-1].copy()
    scale = HEIGHT / picture.shape[0]
    picture = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    for facade in facades:
        x0, z0, x1, z1 = facade.extent
        lines = [np.column_stack([np.full(99, x), np.linspace(z0, z1, 99)]) for x in np.arange(x0, x1, 1.0)]
        lines += [np.column_stack([np.linspace(x0, x1, 99), np.full(99, z)]) for z in np.arange(z0, z1, 1.0)]
        for line in lines:
            draw(picture, photo, facade, line, scale, (255, 255, 255), 1)
        border = np.array([[x0, z0], [x1, z0], [x1, z1], [x0, z1], [x0, z0]])
        steps = [np.linspace(a, b, 99) for a, b in pairwise(border)]
        draw(picture, photo, facade, np.concatenate(steps), scale, INK, 3)
    return picture


def draw(
    picture: Array, photo: Photo, facade: Facade, xz: Array, scale: float, colour: tuple[int, ...], width: int
) -> None:
    """A polyline (k, 2) on the plane, in one photo; parts out of the lens's sight are left out."""
    local = facade.frame.apply(np.column_stack([xz[:, 0], np.zeros(len(xz)), xz[:, 1]]))
    uv = photo.project(local) * scale
    seen = uv[np.isfinite(uv).all(1) & (np.abs(uv) < 1e4).all(1)]
    cv2.polylines(picture, [np.round(seen * 16).astype(np.int32)], False, colour, width, cv2.LINE_AA, 4)


def elevations(store: Store, facades: list[Facade], pixels_per_metre: float) -> list[Array]:
    """The ortho-images (BGR on white) at one scale, standing on one line, each with its name."""
    out = []
    for facade in facades:
        image = cv2.imread(str(store.facade_folder(facade.id) / "ortho.jpg"))
        sidecar = store.sidecar(facade.id)
        assert sidecar is not None  # `ortho.jpg` is there, too
        factor = pixels_per_metre * sidecar.gsd
        image = cv2.resize(image, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
        panel = np.full((HEIGHT, image.shape[1] + 16, 3), 255, np.uint8)
        foot = HEIGHT - 40
        top = max(0, foot - image.shape[0])
        panel[top:foot, 8:-8] = image[-(foot - top) :]
        cv2.putText(
            panel, facade.id, (8, HEIGHT - 14), cv2.FONT_HERSHEY_SIMPLEX, 0.6, (0, 0, 0), 1, cv2.LINE_AA
        )
        out.append(panel)
    return out


def models(run: Path, names: list[str], width: int) -> Array:
    """The pictures of the buildings' LoD3 models side by side, `width` px in all."""
    images = [cv2.imread(str(run / "model" / "pictures" / f"{name}.png")) for name in names]
    height = width / sum(i.shape[1] / i.shape[0] for i in images)
    row = np.hstack([cv2.resize(i, (round(height * i.shape[1] / i.shape[0]), round(height))) for i in images])
    return cv2.resize(row, (width, row.shape[0]), interpolation=cv2.INTER_AREA)


def main(run: Path, project: Path, target: Path) -> None:
    store = Store(run)
    found = [store.facade(name) for name in store.facade_ids("ortho")]
    right = max(found, key=lambda f: f.extent[2] - f.extent[0]).frame.R[:, 0]
    wide = [f for f in found if f.frame.R[:, 0] @ right > 0.9]  # the street front, no gables
    wide.sort(key=lambda f: float(f.frame.t @ right))
    source = load_project(project).photos or PhotoSource()
    photos = read_photos(source, wide[0].world)
    middle = photos.photos[len(photos.photos) // 2]
    tallest = max(f.extent[3] - f.extent[1] for f in wide)
    panels = elevations(store, wide, (HEIGHT - 60) / (tallest + 0.5))
    street = np.hstack([outlined(middle, photos.image(middle.id), wide), *panels])
    names = list(dict.fromkeys(f.building for f in wide))
    picture = np.vstack([street, models(run, names, street.shape[1])])
    factor = WIDTH / picture.shape[1]
    picture = cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
    target.parent.mkdir(parents=True, exist_ok=True)
    quality = 88
    while not cv2.imwrite(str(target), picture, [cv2.IMWRITE_JPEG_QUALITY, quality]) or (
        target.stat().st_size > 300_000 and quality > 40
    ):
        quality -= 8
    print(target)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:4]))
