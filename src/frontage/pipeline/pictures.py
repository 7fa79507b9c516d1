"""Pictures of a facade: its ortho-image for exports and drawings, its evidence, its openings."""

from dataclasses import replace

import cv2
import numpy as np

from frontage.errors import FileError
from frontage.exports import FacadePicture, limit_texture
from frontage.geometry.arrays import Array, Float
from frontage.io.rasters.geotiff import read_geotiff
from frontage.model import Facade
from frontage.openings.observe import ObservedWall
from frontage.openings.paper.find import Decomposition
from frontage.ortho import OrthoOptions
from frontage.ortho.look import common_look
from frontage.pipeline.store.results import EvidencePicture
from frontage.pipeline.store.store import Store
from frontage.raster.light import brightened
from frontage.report.evidence import Picture, beam_picture, cell_pictures

_LONGEST_SIDE_PX = 1000  # of the ortho-image under the drawn openings
_JPEG_QUALITY = 90


def street_looks(store: Store, options: OrthoOptions) -> dict[str, Float]:
    """Return by facade by how much its picture is brightened for one look of the street, (3,) log light.

    Photos that several buildings share tell it; facades of one building have one look already. Empty when
    pictures are to stay as their photos were shot.
    """
    if options.radiometry == "as shot":
        return {}
    building: dict[str, str] = {}
    light: dict[str, dict[str, Array]] = {}
    for name in store.facade_ids("ortho"):
        if (sidecar := store.sidecar(name)) is not None:
            building[name] = sidecar.facade.building
            light.setdefault(building[name], {}).update(sidecar.light)
    looks = common_look(light)
    return {name: looks[own] for name, own in building.items()}


def facade_picture(store: Store, facade: Facade) -> FacadePicture | None:
    """Return the ortho-image of a facade as JPEG with its place on the facade, None if there is none."""
    sidecar = store.sidecar(facade.id)
    if sidecar is None:
        return None
    path = store.facade_folder(facade.id) / "ortho.jpg"
    try:
        jpeg = path.read_bytes()
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror})", "run `frontage ortho` again") from None
    return FacadePicture(facade, jpeg, sidecar.gsd, sidecar.corner_in(facade), sidecar.size)


def wall_picture(store: Store, facade: Facade, look: Float | None = None) -> FacadePicture | None:
    """Return the same, brightened by its `look` (3,), as a wall has it: without white holes.

    Pixels without data take the median colour.
    """
    picture = facade_picture(store, facade)
    if picture is None:
        return None
    image = read_geotiff(store.facade_folder(facade.id) / "ortho.tif")[0]
    seen = image[..., 3] > 0
    if (seen.all() or not seen.any()) and look is None:
        return picture
    rgb = np.ascontiguousarray(image[..., :3])
    if look is not None:
        rgb = brightened(rgb, np.broadcast_to(look.astype(np.float32), rgb.shape))
    if seen.any():
        rgb[~seen] = np.median(rgb[seen], axis=0)
    quality = [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
    return replace(picture, jpeg=cv2.imencode(".jpg", rgb[..., ::-1], quality)[1].tobytes())


def evidence_pictures(evidence: ObservedWall | Decomposition) -> tuple[Picture, ...]:
    """Draw what openings were found from: the beams of the wall, or the cells of the paper's method."""
    if isinstance(evidence, Decomposition):
        return cell_pictures(evidence)
    return (beam_picture(evidence.beams, evidence.evidence),)


def drawing_ground(store: Store, facade: Facade, evidence: tuple[EvidencePicture, ...]) -> Picture | None:
    """Return what openings are drawn on: the ortho-image, else the first picture of the evidence."""
    picture = facade_picture(store, facade)
    if picture is None:
        return _stored(store, facade, evidence[0]) if evidence else None
    jpeg = limit_texture(picture.jpeg, _LONGEST_SIDE_PX)
    image = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    (x, z), (w, h) = picture.corner, (picture.gsd * side for side in picture.size)
    return Picture("ortho", "", cv2.cvtColor(image, cv2.COLOR_BGR2BGRA), (x, z - h, x + w, z))


def save_picture(store: Store, facade: str, picture: Picture) -> EvidencePicture:
    """Write a picture to the folder of a facade."""
    store.put(store.facade_folder(facade) / f"{picture.name}.png", picture.png)
    return EvidencePicture(picture.name, picture.caption, picture.extent)


def _stored(store: Store, facade: Facade, evidence: EvidencePicture) -> Picture | None:
    path = store.facade_folder(facade.id) / f"{evidence.name}.png"
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    return None if image is None else Picture("ground", "", image, evidence.extent)
