"""A facade's ortho-image as the exports take it."""

from pathlib import Path

import numpy as np

from frontage.exports import FacadePicture
from frontage.model import Facade
from frontage.pipeline.files import read_json


def facade_picture(folder: Path, facade: Facade) -> FacadePicture:
    """The ortho-image in a facade's folder, with its place from the contract's matrix."""
    sidecar = read_json(folder / "ortho.json")
    # The outer upper left corner of pixel (0, 0).
    matrix = np.array(sidecar["raster_to_world"], np.float64).reshape(4, 4)
    corner = facade.frame.inverse.apply(facade.world.to_local(matrix[None, :3, 3]))[0]
    size = int(sidecar["width"]), int(sidecar["height"])
    jpeg = (folder / "ortho.jpg").read_bytes()
    return FacadePicture(facade, jpeg, float(sidecar["gsd"]), (float(corner[0]), float(corner[2])), size)
