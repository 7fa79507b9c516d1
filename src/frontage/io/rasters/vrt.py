"""Ortho-images for GIS programs: GDAL's virtual rasters, named by their facade, in heights above the datum.

A virtual raster is a small file that refers to the bands in the folder of the facade. Nothing is copied.
"""

import os
from dataclasses import dataclass
from pathlib import Path
from xml.sax.saxutils import escape

from frontage.io.files import whole_file
from frontage.io.rasters.gdalxml import place_xml
from frontage.io.rasters.sidecar import OrthoSidecar

_NAN = "nan"


@dataclass(frozen=True)
class _Band:
    """A band of a virtual raster: type and meaning as GDAL names them, value without data, unit."""

    kind: str
    title: str
    colour: str
    nodata: str = ""
    unit: str = ""


_COLOURS = tuple(_Band("Byte", c.lower(), c) for c in ("Red", "Green", "Blue", "Alpha"))
_DEPTH = (_Band("Float32", "depth behind the plane of the facade", "Gray", _NAN, "metre"),)


def write_virtual(folder: Path, facade_folder: Path, sidecar: OrthoSidecar) -> list[Path]:
    """Write `B07_F1.vrt`, and `B07_F1_depth.vrt` where there is relief; returns the files.

    Their vertical axis is the height above the datum of the CRS: z of the facade frame plus the height of its
    origin, which is exact for an upright wall. Raises FileError when a file cannot be written.
    """
    stem = sidecar.facade.id.replace("/", "_")
    wanted = {f"{stem}.vrt": ("ortho.tif", _COLOURS)}
    if sidecar.relief:
        wanted[f"{stem}_depth.vrt"] = ("depth.tif", _DEPTH)
    for name, (source, bands) in wanted.items():
        path = os.path.relpath(facade_folder / source, folder).replace(os.sep, "/")
        with whole_file(folder / name) as temporary:
            temporary.write_text(_text(sidecar, path, bands), "utf-8")
    return [folder / name for name in wanted]


def _text(sidecar: OrthoSidecar, source: str, bands: tuple[_Band, ...]) -> str:
    facade, (w, h), (x, z), gsd = sidecar.facade, sidecar.size, sidecar.corner, sidecar.gsd
    about = {"FACADE": facade.id, "VERTICAL_AXIS": "height above the datum of WORLD_CRS in metres",
             "WORLD_CRS": facade.world.crs or "unknown"}  # fmt: skip
    name, corner = f"Facade {facade.id} (x right, height up)", (x, z + facade.height_of_zero)
    place = place_xml(name, "height", corner, gsd, about)
    whole = f'xOff="0" yOff="0" xSize="{w}" ySize="{h}"'
    texts = "".join(_band(k, band, source, whole) for k, band in enumerate(bands, 1))
    return f'<VRTDataset rasterXSize="{w}" rasterYSize="{h}">\n{place}{texts}</VRTDataset>\n'


def _band(number: int, band: _Band, source: str, whole: str) -> str:
    nodata = f"    <NoDataValue>{band.nodata}</NoDataValue>\n" if band.nodata else ""
    unit = f"    <UnitType>{band.unit}</UnitType>\n" if band.unit else ""
    return (
        f'  <VRTRasterBand dataType="{band.kind}" band="{number}">\n'
        f"    <Description>{band.title}</Description>\n{nodata}{unit}"
        f"    <ColorInterp>{band.colour}</ColorInterp>\n    <SimpleSource>\n"
        f'      <SourceFilename relativeToVRT="1">{escape(source)}</SourceFilename>\n'
        f"      <SourceBand>{number}</SourceBand>\n      <SrcRect {whole}/>\n      <DstRect {whole}/>\n"
        "    </SimpleSource>\n  </VRTRasterBand>\n"
    )
