"""GeoTIFF in a facade's own plane: x to the right, z up, metres, a local engineering CRS.

GDAL reads the true 4x4 matrix of a vertical picture as a degenerate affine, so the file carries a plain
two-dimensional one (pixel-is-area) and the matrix to the world as GDAL metadata.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np
import tifffile

from frontage.errors import FileError, InputError
from frontage.geometry.arrays import Array, Float
from frontage.io.files import whole_file
from frontage.raster.tiles import Tile, allocate, tiles

_TILE = 256
_PICTURE_LEVEL = 1  # of deflate: the noise of a photograph packs no better for four times the time
_BIG = 2**32 - 2**25  # bytes: classic TIFF ends at 4 GiB
_SCALE, _TIEPOINT, _KEYS, _ASCII = 33550, 33922, 34735, 34737
_GDAL_METADATA, _GDAL_NODATA = 42112, 42113


def write_geotiff(
    path: Path,
    band: Array,
    corner: tuple[float, float],
    gsd: float,
    crs_name: str,
    metadata: Mapping[str, str],
    nodata: float | None = None,
) -> None:
    """Write a band (h, w) or (h, w, 4) RGBA as a tiled, deflated GeoTIFF; BigTIFF when it may pass 4 GiB.

    `corner` (x, z) m is the outer upper left corner, `gsd` m per pixel. The file appears under its name only
    when it is complete.

    Raises FileError when it cannot be written.
    """
    rgba = band.ndim == 3
    options: dict[str, Any] = {
        "tile": (_TILE, _TILE),
        "compression": "adobe_deflate",
        "compressionargs": {"level": _PICTURE_LEVEL} if rgba else {},
        "photometric": "rgb" if rgba else "minisblack",
        "extratags": _tags(corner, gsd, crs_name, metadata, nodata),
        "metadata": None,
        "software": "frontage",
        "predictor": bool(band.dtype.kind == "u"),
    }
    if rgba:
        options["extrasamples"] = ["unassalpha"]
    with whole_file(path) as temporary, tifffile.TiffWriter(temporary, bigtiff=band.nbytes > _BIG) as tif:
        tif.write(_padded(band), shape=band.shape, dtype=band.dtype, **options)


def _padded(band: Array) -> Iterator[Array]:
    """The tiles of a band, row by row, those at its edges filled up: no copy of the whole is made."""
    for tile in tiles(band.shape[0], band.shape[1], _TILE):
        part = np.ascontiguousarray(band[tile.window])
        if part.shape[:2] != (_TILE, _TILE):
            whole = np.zeros((_TILE, _TILE, *band.shape[2:]), band.dtype)
            whole[: part.shape[0], : part.shape[1]] = part
            part = whole
        yield part


def read_geotiff(path: Path, window: Tile | None = None) -> tuple[Array, tuple[float, float], float]:
    """The band, the outer upper left corner (x, z) m, and the gsd m of a file that `write_geotiff` made.

    Of a `window` of pixels only its own part is read, and the corner is the window's. A whole band larger
    than memory should hold is read into a scratch file, tile by tile.

    Raises FileError when the file is missing, damaged or not georeferenced, InputError when the window lies
    outside.
    """
    if not path.is_file():
        raise FileError(path, "does not exist", "run the ortho step first")
    try:
        with tifffile.TiffFile(path) as tif:
            page = tif.pages[0]
            scale, tie = float(page.tags[_SCALE].value[0]), page.tags[_TIEPOINT].value
            band = (
                page.asarray(out=allocate(page.shape, page.dtype)) if window is None else _part(page, window)
            )
    except InputError:
        raise
    except KeyError as error:
        raise FileError(path, "is a TIFF without georeference", "run the ortho step again") from error
    except Exception as error:  # tifffile raises whatever its decoders do
        raise FileError(path, f"is damaged ({error})", "run the ortho step again") from error
    left, top = (0, 0) if window is None else (window.c0, window.r0)
    return band, (float(tie[3]) + left * scale, float(tie[4]) - top * scale), scale


def _part(page: Any, window: Tile) -> Array:
    """A window of a page, from the tiles that it touches."""
    h, w = page.shape[:2]
    if not (0 <= window.r0 < window.r1 <= h and 0 <= window.c0 < window.c1 <= w):
        raise InputError(
            f"{page.parent.filehandle.name} has {w} x {h} px, not the window {window}", code="I321"
        )
    if not page.is_tiled:
        raise ValueError("it has no tiles")
    out = np.empty((*window.shape, *page.shape[2:]), page.dtype)
    file, side = page.parent.filehandle, (page.tilelength, page.tilewidth)
    across = -(-w // side[1])
    for i in range(window.r0 // side[0], -(-window.r1 // side[0])):
        for j in range(window.c0 // side[1], -(-window.c1 // side[1])):
            k = i * across + j
            file.seek(page.dataoffsets[k])
            data, _, _ = page.decode(file.read(page.databytecounts[k]), k)
            r, c = i * side[0], j * side[1]
            r0, r1 = max(r, window.r0), min(r + side[0], window.r1)
            c0, c1 = max(c, window.c0), min(c + side[1], window.c1)
            into = out[r0 - window.r0 : r1 - window.r0, c0 - window.c0 : c1 - window.c0]
            into[:] = data.reshape(-1, data.shape[-2], *page.shape[2:])[r0 - r : r1 - r, c0 - c : c1 - c]
    return out


def matrix_text(matrix: Float) -> str:
    """A matrix, row by row, with every digit it has."""
    return " ".join(repr(float(v)) for v in np.asarray(matrix).ravel())


def _tags(
    corner: tuple[float, float], gsd: float, crs_name: str, metadata: Mapping[str, str], nodata: float | None
) -> list[tuple[int, int | str, int, Any, bool]]:
    """The GeoTIFF 1.1 tags and GDAL's two private ones."""
    name = crs_name.replace("|", "/").encode("ascii", "replace").decode() + "|"
    keys = [(1024, 0, 1, 32767), (1025, 0, 1, 1), (1026, _ASCII, len(name), 0), (3076, 0, 1, 9001)]
    directory = [1, 1, 1, len(keys), *(v for key in keys for v in key)]
    items = "".join(f"  <Item name={quoteattr(k)}>{escape(v)}</Item>\n" for k, v in metadata.items())
    xml = f"<GDALMetadata>\n{items}</GDALMetadata>".encode("ascii", "xmlcharrefreplace").decode()
    tags: list[tuple[int, int | str, int, Any, bool]] = [
        (_SCALE, "d", 3, (gsd, gsd, 0.0), True),
        (_TIEPOINT, "d", 6, (0.0, 0.0, 0.0, corner[0], corner[1], 0.0), True),
        (_KEYS, "H", len(directory), tuple(directory), True),
        (_ASCII, "s", 0, name, True),
        (_GDAL_METADATA, "s", 0, xml, True),
    ]
    if nodata is not None:
        tags.append((_GDAL_NODATA, "s", 0, f"{nodata:g}", True))
    return tags
