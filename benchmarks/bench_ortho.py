"""Ortho-images: geometric error in pixels, and the time of one 12 MP photo on a 30 x 15 m facade at 1 cm.

Beside ours: the paper's own method (homography from four point pairs, bilinear interpolation, distortion and
relief neglected) and, for the time, `cv2.warpPerspective` of the same size.
"""

import time

import cv2
import numpy as np

from _common import bootstrap, figure, table

# isort: split
import ortho_wall as wall  # _common has put tests/ on the path
from frontage.geometry.homography import apply_homography, homography_from_pairs
from frontage.ortho import OrthoOptions, make_ortho
from frontage.ortho.orthoraster import facade_raster
from frontage.ortho.project import full_projection, map_tile, plane_homography
from frontage.raster.resample import resample
from frontage.raster.tiles import tiles

OPTIONS = OrthoOptions(margin=0.0)
VIEWS = [(-4.0, -9.0, -2.0), (0.0, -9.0, -2.5), (5.0, -9.0, -1.0), (-2.0, -12.0, 1.0), (3.0, -7.5, -2.0)]


def papers(photo, facade, image, raster):
    """Paper A: four corners of the facade and their places in the photo give H; bilinear."""
    corners = np.array([[0, 0], [raster.width, 0], [raster.width, raster.height], [0, raster.height]], float)
    places = full_projection(photo, facade, raster)(corners[:, 0], corners[:, 1], 0.0)
    H = homography_from_pairs(corners, places)
    half = np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, 1.0]])  # OpenCV puts pixel centres at whole numbers
    M = np.linalg.inv(half) @ H @ half
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpPerspective(image, M, (raster.width, raster.height), flags=flags)


def accuracy():
    relief = lambda x, z: 0.2 * ((np.abs(x % 2.0 - 1.0) < 0.6) & (np.abs(z % 2.0 - 1.0) < 0.7))  # noqa: E731
    rows = []
    for name, depth in (("plane", None), ("windows 20 cm deep", relief)):
        found: dict[str, list[float]] = {"ours": [], "ours, on the plane": [], "paper A": []}
        for seed, eye in enumerate(VIEWS):
            facade, picture = wall.facade(8.0, 6.0), wall.texture(8.0, 6.0, seed)
            photo = wall.photo(facade, wall.camera(2000, 1500, focal=0.8), eye)
            image = wall.render(photo, facade, picture, depth)
            cloud = wall.wall_cloud(facade, depth=depth, seed=seed)
            flat = OrthoOptions(margin=0.0, relief=False)
            image_of = {photo.id: image}.__getitem__
            results = {
                "ours": make_ortho(facade, cloud, [photo], image_of, options=OPTIONS).pixels,
                "ours, on the plane": make_ortho(facade, cloud, [photo], image_of, options=flat).pixels,
                "paper A": papers(photo, facade, image, facade_raster(facade, OPTIONS)),
            }
            for method, pixels in results.items():
                shift = np.linalg.norm(wall.displacement(pixels, picture, 64), axis=1)
                found[method].append(float(np.median(shift)))
        rows += [[name, method, figure(bootstrap(v), "px")] for method, v in found.items()]
    table(
        "Geometric error at 1 cm, true poses, 1 % distortion: median over tiles",
        ["scene", "method", "error"],
        rows,
    )


def agreement():
    facade = wall.facade(30.0, 15.0)
    raster = facade_raster(facade, OPTIONS)
    photo = wall.photo(facade, wall.camera(4032, 3024, distorted=False), (-6.0, -18.0, -5.0))
    c, r = (g.ravel() for g in np.meshgrid(np.linspace(0, 3000, 200), np.linspace(0, 1500, 100)))
    H = plane_homography(photo, facade, raster)
    by_plane = apply_homography(H, np.column_stack([c, r]))
    apart = np.abs(by_plane - full_projection(photo, facade, raster)(c, r, 0.0))
    print(f"\nhomography and full projection, undistorted camera: {apart.max():.1e} px apart at most")


def processor_ratio(ours, peer, repeat=9):
    """Median ratio of processor seconds (all threads) with its interval, the two alternating."""

    def seconds(work):
        start = time.process_time()
        work()
        return time.process_time() - start

    ours(), peer()
    return bootstrap([seconds(ours) / seconds(peer) for _ in range(repeat)])


def speed():
    cv2.setNumThreads(1)  # as in the worker processes; ours calls OpenCV more often, the peer once
    facade = wall.facade(30.0, 15.0)
    raster = facade_raster(facade, OPTIONS)
    image = np.random.default_rng(0).integers(0, 256, (3024, 4032, 3)).astype(np.uint8)
    size = (raster.width, raster.height)
    rows = []
    for name, eye in (
        ("facade fills the photo", (0.0, -17.0, -5.0)),
        ("oblique", (-10.0, -17.0, -5.0)),
        ("same pixels", (0.0, -22.0, -5.0)),
        ("from afar", (0.0, -30.0, -5.0)),
    ):
        photo = wall.photo(facade, wall.camera(4032, 3024, focal=0.58), eye, (0.0, 0.0, 0.0))
        H, to_photo = plane_homography(photo, facade, raster), full_projection(photo, facade, raster)

        def ours(method):
            out = np.empty((raster.height, raster.width, 4), np.uint8)
            for tile in tiles(raster.height, raster.width, 512):
                resample(image, map_tile(to_photo, tile, None), method, out[tile.window])  # noqa: B023
            return out

        def peer(flag):
            return cv2.warpPerspective(image, H, size, flags=flag | cv2.WARP_INVERSE_MAP)  # noqa: B023

        for method in ("adaptive", "bilinear"):
            ratios = [
                processor_ratio(lambda: ours(method), lambda: peer(flag))  # noqa: B023
                for flag in (cv2.INTER_LINEAR, cv2.INTER_CUBIC)
            ]
            rows.append([name, method, *(figure(r) for r in ratios)])
    title = "One 12 MP photo to 30 x 15 m at 1 cm, with distortion, one core: ratio of processor time"
    table(title, ["view", "ours", "to warpPerspective, bilinear", "to warpPerspective, cubic"], rows)


if __name__ == "__main__":
    accuracy()
    agreement()
    speed()
