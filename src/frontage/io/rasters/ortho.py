"""An ortho-image on disk: its GeoTIFF bands, a JPEG to look at, and the sidecar `ortho.json`."""

import math
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array
from frontage.io.files import MALFORMED, whole_file
from frontage.io.rasters.geotiff import Georeference, matrix_text, read_geotiff, write_geotiff
from frontage.io.rasters.jpegplace import with_density, write_place
from frontage.io.rasters.occluders import read_occluders, write_occluders
from frontage.io.rasters.sidecar import OrthoSidecar, read_sidecar, write_sidecar
from frontage.model import OrthoImage
from frontage.raster.tiles import Tile

FILES = ("ortho.json", "ortho.tif", "ortho.jpg", "ortho.jgw", "ortho.jpg.aux.xml", "depth.tif", "sources.tif",
         "gsd.tif", "intensity.tif", "occluders.json")  # fmt: skip
"""The files that `write_ortho` may leave in a folder."""

_JPEG_SIDE_PX = 16384  # the largest picture that common viewers open; the format itself ends at 65535
_JPEG_QUALITY = 90
_JPEG_ROWS = 2048  # rows of the JPEG that are prepared at a time


def write_ortho(folder: Path, ortho: OrthoImage) -> None:
    """Write the bands of an ortho-image, `ortho.jpg` and `ortho.json`; `intensity.tif` only if it has one.

    Every file appears under its name only when it is complete. The sidecar is written last, so a folder with
    an `ortho.json` holds a complete ortho-image.

    Raises FileError when the folder cannot be written.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(
            folder, f"cannot be made a folder ({error.strerror})", "choose another output folder"
        ) from error
    sidecar = OrthoSidecar.of(ortho)
    facade = ortho.facade
    metadata = {
        "FACADE": facade.id,
        "RASTER_TO_WORLD": matrix_text(sidecar.raster_to_world),
        "WORLD_CRS": facade.world.crs or "",
        "SOURCES": "; ".join(ortho.sources),
        "HEIGHT_OF_ZERO": repr(sidecar.facade.height_of_zero),
    }
    about = Georeference(ortho.corner, ortho.gsd, f"Facade {facade.id} (x right, z up, m)", metadata)
    write_geotiff(folder / "ortho.tif", ortho.pixels, about, names=("red", "green", "blue", "alpha"))
    for name, band, nodata, title, unit in (
        ("depth.tif", ortho.depth, math.nan, "depth behind the plane of the facade", "metre"),
        ("sources.tif", ortho.source, 0, "1 + index into the sources", ""),
        ("gsd.tif", ortho.gsd_effective, math.nan, "size of a source pixel on the facade", "metre"),
        ("intensity.tif", ortho.intensity, math.nan, "intensity of the scan, 0 to 1", ""),
    ):
        if band is not None:
            write_geotiff(folder / name, band, about, nodata, names=(title,), unit=unit)
        else:
            (folder / name).unlink(missing_ok=True)
    jpeg, step = _jpeg(ortho.pixels)
    with whole_file(folder / "ortho.jpg") as temporary:
        temporary.write_bytes(with_density(jpeg, ortho.gsd * step))
    write_place(folder / "ortho.jpg", replace(about, gsd=ortho.gsd * step))
    write_occluders(folder / "occluders.json", ortho.occluders, facade)
    write_sidecar(folder, sidecar)


def read_ortho(folder: Path, window: Tile | None = None) -> OrthoImage:
    """Read what `write_ortho` wrote; the facade comes back without its point indices.

    With a `window` of pixels, only that part is read, and it is returned as an ortho-image with a corner of
    its own. Without one, bands that are too large for memory are read into scratch files.

    Raises FileError when a file is missing, damaged or does not fit the sidecar, and InputError when the
    window lies outside the image.
    """
    folder = Path(folder)
    sidecar = read_sidecar(folder)
    pixels, corner, gsd = read_geotiff(folder / "ortho.tif", window)
    depth, source, gsd_effective = (
        read_geotiff(folder / name, window)[0] for name in ("depth.tif", "sources.tif", "gsd.tif")
    )
    has_intensity = (folder / "intensity.tif").is_file()
    intensity = read_geotiff(folder / "intensity.tif", window)[0] if has_intensity else None
    if pixels.ndim != 3:
        raise FileError(folder / "ortho.tif", "does not hold colours", "run `frontage ortho` again")
    same_size = window is not None or (pixels.shape[1], pixels.shape[0]) == sidecar.size
    if not same_size or not math.isclose(gsd, sidecar.gsd, rel_tol=1e-9):
        raise FileError(folder / "ortho.tif", "does not fit ortho.json", "run `frontage ortho` again")
    try:
        return OrthoImage(
            pixels,
            sidecar.gsd,
            sidecar.corner if window is None else corner,
            sidecar.facade,
            depth,
            source,
            sidecar.sources,
            gsd_effective,
            intensity,
            sidecar.photo_offset,
            sidecar.photos,
            occluders=read_occluders(folder / "occluders.json"),
            light=sidecar.light,
        )
    except MALFORMED as error:
        raise FileError(
            folder / "ortho.json", f"does not fit the bands beside it ({error})", "run `frontage ortho` again"
        ) from error


def _jpeg(pixels: Array) -> tuple[bytes, int]:
    """The picture on white as JPEG; one of more than 16384 px is reduced by a whole factor, returned too."""
    step = -(-max(pixels.shape[:2]) // _JPEG_SIDE_PX)
    rows = []
    for r in range(0, pixels.shape[0], _JPEG_ROWS * step):
        part = np.asarray(pixels[r : r + _JPEG_ROWS * step])
        part = np.where(part[..., 3:] > 0, part[..., :3], 255).astype(np.uint8)
        if step > 1:
            size = (max(1, part.shape[1] // step), max(1, part.shape[0] // step))
            part = cv2.resize(part, size, interpolation=cv2.INTER_AREA)
        rows.append(part)
    picture = cv2.cvtColor(np.concatenate(rows), cv2.COLOR_RGB2BGR)
    return bytes(cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[1]), step
