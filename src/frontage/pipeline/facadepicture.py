"""A facade's ortho-image as the exports take it."""

from pathlib import Path

from frontage.exports import FacadePicture
from frontage.model import Facade
from frontage.pipeline.files import read_json
from frontage.pipeline.openingpictures import ortho_corner


def facade_picture(folder: Path, facade: Facade) -> FacadePicture:
    """The ortho-image in a facade's folder."""
    sidecar = read_json(folder / "ortho.json")
    size = int(sidecar["width"]), int(sidecar["height"])
    jpeg = (folder / "ortho.jpg").read_bytes()
    return FacadePicture(facade, jpeg, float(sidecar["gsd"]), ortho_corner(sidecar, facade), size)
