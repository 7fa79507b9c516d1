"""A facade's ortho-image as the exports take it."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from frontage.exports import FacadePicture
from frontage.io.rasters.geotiff import read_geotiff
from frontage.model import Facade
from frontage.pipeline.files import read_json
from frontage.pipeline.openingpictures import ortho_corner

_QUALITY = 90  # JPEG


def facade_picture(folder: Path, facade: Facade) -> FacadePicture:
    """The ortho-image in a facade's folder."""
    sidecar = read_json(folder / "ortho.json")
    size = int(sidecar["width"]), int(sidecar["height"])
    jpeg = (folder / "ortho.jpg").read_bytes()
    return FacadePicture(facade, jpeg, float(sidecar["gsd"]), ortho_corner(sidecar, facade), size)


def wall_picture(folder: Path, facade: Facade) -> FacadePicture:
    """The same with the median colour of what was seen where nothing was: a wall has no white holes."""
    image = read_geotiff(folder / "ortho.tif")[0]
    seen = image[..., 3] > 0
    picture = facade_picture(folder, facade)
    if seen.all() or not seen.any():
        return picture
    rgb = np.ascontiguousarray(image[..., :3])
    rgb[~seen] = np.median(rgb[seen], axis=0)
    return replace(
        picture, jpeg=cv2.imencode(".jpg", rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])[1].tobytes()
    )
