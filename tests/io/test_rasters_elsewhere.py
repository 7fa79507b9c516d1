"""Ortho-images in the hands of other programs: cloud-optimised, named, placed, to scale on paper."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image

import ortho_wall as wall
from frontage.io.rasters import ortho as ortho_io
from frontage.io.rasters.geotiff import Georeference, read_geotiff, write_geotiff
from frontage.io.rasters.overviews import overviews
from frontage.io.rasters.sidecar import read_sidecar
from frontage.io.rasters.vrt import write_virtual
from frontage.model import OrthoImage
from frontage.ortho import OrthoOptions, make_ortho

ABOUT = Georeference((-3.0, 5.0), 0.01, "Facade B01/F1", {"FACADE": "B01/F1"})


@pytest.fixture(scope="module")
def ortho() -> OrthoImage:
    facade = wall.facade(3.0, 2.0)
    made = make_ortho(facade, wall.wall_cloud(facade), options=OrthoOptions(margin=0.1))
    assert made
    return made


def unordered(path: Path) -> list[str]:
    """What keeps a file from being cloud-optimised, by the rules that GDAL's own checker applies.

    They are: the first directory begins behind the header and GDAL's note, directories go from the largest
    picture to the smallest, all of them stand before all tiles, tiles from the smallest picture to the
    largest, and whatever is larger than 512 px has tiles and overviews.
    """
    with tifffile.TiffFile(path) as tif:
        pages, found = list(tif.pages), []
        header = 16 if tif.is_bigtiff else 8
        tif.filehandle.seek(header)
        note = tif.filehandle.read(43)
        size = int(note[30:36]) + 43 if note.startswith(b"GDAL_STRUCTURAL_METADATA_SIZE=") else 0
        if pages[0].offset != header + size + (header + size) % 2:
            found.append("first directory")
        sizes = [max(page.shape[:2]) for page in pages]
        if sizes != sorted(sizes, reverse=True) or any(not page.is_reduced for page in pages[1:]):
            found.append("overviews")
        if max(sizes) > 512 and not (len(pages) > 1 and all(page.is_tiled for page in pages)):
            found.append("tiles")
        starts = [page.offset for page in pages]
        if starts != sorted(starts) or max(starts) > min(min(p.dataoffsets) for p in pages):
            found.append("directories")
        data = [(min(p.dataoffsets), max(p.dataoffsets)) for p in reversed(pages)]
        if any(a[1] >= b[0] for a, b in pairwise(data)):
            found.append("tiles of overviews")
        return found


@pytest.mark.parametrize("big", [False, True])
def test_files_are_cloud_optimised(tmp_path: Path, big: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    import rasterio  # only here: it brings its own GDAL and PROJ

    if big:
        monkeypatch.setattr("frontage.io.rasters.geotiff._BIG", 1000)
    rng = np.random.default_rng(0)
    for name, band in (
        ("rgba", rng.integers(0, 255, (1100, 701, 4), np.uint8)),
        ("depth", rng.normal(size=(600, 1301)).astype(np.float32)),
        ("sources", rng.integers(0, 9, (30, 20), np.uint16)),
        ("flat", np.broadcast_to(np.float32(np.nan), (700, 300))),
    ):
        path = tmp_path / f"{name}.tif"
        write_geotiff(path, band, ABOUT, None if band.ndim == 3 else 0, names=(name,))
        assert unordered(path) == []
        np.testing.assert_array_equal(read_geotiff(path)[0], band)
        levels = list(overviews(band))
        with rasterio.open(path) as tif:
            assert tif.tags(ns="IMAGE_STRUCTURE")["LAYOUT"] == "COG"
            assert tif.overviews(1) == [2 ** (k + 1) for k in range(len(levels))]
            np.testing.assert_array_equal(tif.read(1), band if band.ndim == 2 else band[..., 0])
        for number, level in enumerate(levels):
            with rasterio.open(path, overview_level=number) as small:
                read = np.moveaxis(small.read(), 0, -1)
                np.testing.assert_array_equal(read.squeeze(), level)
                assert small.nodata == (None if band.ndim == 3 else 0)
    plain = tmp_path / "plain.tif"
    with tifffile.TiffWriter(plain) as writer:
        writer.write(band[:300], tile=(256, 256))
        writer.write(band[:150, ::2], tile=(256, 256), subfiletype=1)
    assert unordered(plain) == ["directories", "tiles of overviews"]


def test_virtual_rasters_are_named_by_facade_and_have_heights(tmp_path: Path, ortho: OrthoImage) -> None:
    import rasterio

    folder = tmp_path / "facades" / "B01_F1"
    ortho_io.write_ortho(folder, ortho)
    files = write_virtual(tmp_path / "products" / "rasters", folder, read_sidecar(folder))
    assert [file.name for file in files] == ["B01_F1.vrt", "B01_F1_depth.vrt"]
    with rasterio.open(files[0]) as tif, rasterio.open(files[1]) as depth:
        np.testing.assert_array_equal(np.moveaxis(tif.read(), 0, -1), ortho.pixels)
        np.testing.assert_array_equal(depth.read(1), ortho.depth)
        assert depth.units == ("metre",) and np.isnan(depth.nodata)
        assert tif.descriptions == ("red", "green", "blue", "alpha") and "height" in tif.crs.to_wkt()
        at = np.array([[10.0, 20.0]])
        world, _ = ortho.pixel_to_world(at, relief=False)
        assert tif.xy(20, 10, offset="ul")[1] == pytest.approx(world[0, 2], abs=1e-3)
        assert tif.tags()["WORLD_CRS"] == "EPSG:25832"


def test_gdal_reads_overviews_names_units_and_the_place_of_the_jpeg(ortho, tmp_path):
    import rasterio  # only here: it brings its own GDAL and PROJ

    ortho_io.write_ortho(tmp_path, ortho)
    with rasterio.open(tmp_path / "ortho.tif") as tif:
        assert tif.overviews(1) == [2]
        assert tif.descriptions == ("red", "green", "blue", "alpha")
        dots = float(tif.tags()["TIFFTAG_XRESOLUTION"])
        assert tif.tags()["TIFFTAG_RESOLUTIONUNIT"].startswith("3") and dots * ortho.gsd == pytest.approx(0.5)
        zero = float(tif.tags()["HEIGHT_OF_ZERO"])
    with rasterio.open(tmp_path / "depth.tif") as tif:
        assert (tif.units, tif.descriptions) == (("metre",), ("depth behind the plane of the facade",))
        half = tif.read(1, out_shape=tuple((n + 1) // 2 for n in tif.shape))
    blocks = ortho.depth.reshape(half.shape[0], 2, half.shape[1], 2)
    full = np.isfinite(blocks).all((1, 3))
    assert np.allclose(half[full], blocks.mean((1, 3))[full], atol=1e-6) and full.mean() > 0.5
    assert np.array_equal(np.isnan(half), np.isnan(blocks).all((1, 3)))
    world, _ = ortho.pixel_to_world(np.array([[10.0, 20.0]]), relief=False)
    with rasterio.open(tmp_path / "ortho.jpg") as jpeg:
        x, z = jpeg.xy(20, 10, offset="ul")
        assert (x, z) == pytest.approx((ortho.corner[0] + 0.1, ortho.corner[1] - 0.2))
        assert "metre" in jpeg.crs.to_wkt() and jpeg.tags()["FACADE"] == "B01/F1"
    assert zero + z == pytest.approx(world[0, 2], abs=1e-3)  # the wall of this test is upright
    (tmp_path / "ortho.jpg.aux.xml").unlink()
    with rasterio.open(tmp_path / "ortho.jpg") as jpeg:  # now by the world file
        assert jpeg.xy(20, 10, offset="ul") == pytest.approx((x, z))
    with Image.open(tmp_path / "ortho.jpg") as picture:
        density = picture.info["dpi"][0] / 2.54
    assert density * ortho.gsd == pytest.approx(0.5, rel=0.01)


def test_overviews_average_what_is_known():
    colours = np.zeros((515, 300, 4), np.uint8)
    colours[::2] = (200, 100, 50, 255)  # every other row has no data
    half, quarter = overviews(colours)
    assert half.shape == (258, 150, 4) and quarter.shape == (129, 75, 4)
    assert np.array_equal(half[0, 0], (200, 100, 50, 128))
    assert np.array_equal(half[-1, 0], (200, 100, 50, 255))
    names = np.arange(300 * 4, dtype=np.uint16).reshape(4, 300)
    (small,) = overviews(names)
    assert np.array_equal(small, names[::2, ::2])
    flat = np.broadcast_to(np.float32(np.nan), (400, 400))
    (small,) = overviews(flat)
    assert small.shape == (200, 200) and not any(small.strides)
