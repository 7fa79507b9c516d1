"""A facade and its ortho-image written down by hand at UTM coordinates, for tests of later stages."""

import cv2
import numpy as np

from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Facade, Layer, OrthoImage, WorldRef

GSD = 0.02
WORLD = WorldRef(np.array([678_000, 5_403_000, 400]), "EPSG:25832")


def facade(
    name: str = "B01/F1", azimuth: float = 0.7, lean: float = 0.004, notes: tuple[str, ...] = ()
) -> Facade:
    """Returns an L-shaped facade of 10 x 6 m that faces `azimuth` (rad from east) and leans by `lean` rad."""
    c, s = np.cos(azimuth), np.sin(azimuth)
    cl, sl = np.cos(lean), np.sin(lean)
    tilt = np.array([[1, 0, 0], [0, cl, -sl], [0, sl, cl]])
    R = np.array([[s, c, 0], [-c, s, 0], [0, 0, 1.0]]) @ tilt  # columns X, Y, Z of DESIGN section 2
    pose = Estimate(Rigid3("local", "facade", R, np.array([61.5, 870.25, 15.125])), np.eye(6) * 1e-8, 500.0)
    outline = np.array([[-5.0, -3], [5, -3], [5, 1], [1, 1], [1, 3], [-5, 3]])
    wall = Layer(0.0, 0.0004, 52.0, outline)
    return Facade(
        id=name, building=name.split("/")[0], local_from_facade=pose, world=WORLD,
        outline=outline, layers=(wall,),
        support=np.arange(10), inliers=np.arange(2, 8), roughness=0.004, spacing=0.02, coverage=0.9,
        oriented_by="rays", curvature=(0.002, float("inf")),
    )  # fmt: skip


def ortho(name: str = "B01/F1") -> OrthoImage:
    """Returns an asymmetric ortho-image of 11 x 7 m at 2 cm, with a relief of 0.3 m in its left half and
    none in its right half."""
    w, h = 550, 350
    pixels = np.zeros((h, w, 4), np.uint8)
    pixels[..., 0] = np.linspace(0, 255, w).astype(np.uint8)
    pixels[..., 1] = np.linspace(255, 0, h).astype(np.uint8)[:, None]
    pixels[..., 3] = 255
    depth = np.full((h, w), np.nan, np.float32)
    depth[:, : w // 2] = 0.3
    source = np.ones((h, w), np.uint16)
    return OrthoImage(
        pixels,
        GSD,
        (-5.5, 3.5),
        facade(name),
        depth,
        source,
        ("IMG_1.jpg",),
        np.full((h, w), GSD, np.float32),
    )


def jpeg(image: OrthoImage, quality: int = 95) -> bytes:
    """Returns the picture as JPEG bytes, without its alpha channel."""
    return bytes(cv2.imencode(".jpg", image.pixels[..., 2::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])[1])
