"""Ortho-images on disk round-trip, and other programs can read them."""

import json
from dataclasses import replace

import cv2
import numpy as np
import pytest
import tifffile

import ortho_wall as wall
from frontage.errors import FileError, InputError
from frontage.io.facadefile import facade_from_json, facade_to_json
from frontage.io.rasters import ortho as ortho_io
from frontage.io.rasters.geotiff import Georeference, read_geotiff, write_geotiff
from frontage.io.rasters.sidecar import OrthoSidecar, read_sidecar
from frontage.model import Layer, PhotoOffset
from frontage.ortho import OrthoOptions, make_ortho
from frontage.raster.tiles import Tile


@pytest.fixture(scope="module")
def ortho():
    facade = wall.facade(3.0, 2.0)
    depth = lambda x, z: np.where(np.abs(x) < 0.5, 0.2, 0.0)  # noqa: E731
    made = make_ortho(facade, wall.wall_cloud(facade, depth=depth), options=OrthoOptions(margin=0.1))
    assert made
    return made


def test_an_ortho_image_round_trips(ortho, tmp_path):
    ortho_io.write_ortho(tmp_path / "B01_F1", ortho)
    back = ortho_io.read_ortho(tmp_path / "B01_F1")
    for name in ("pixels", "depth", "source", "gsd_effective", "intensity"):
        assert np.array_equal(
            getattr(back, name), getattr(ortho, name), equal_nan=name not in ("pixels", "source")
        ), name
    assert (back.gsd, back.sources, back.facade.id) == (ortho.gsd, ortho.sources, "B01/F1")
    pixels = np.random.default_rng(0).uniform(0, 200, (500, 2))
    world, used = ortho.pixel_to_world(pixels)
    again, used_again = back.pixel_to_world(pixels)
    assert np.abs(world - again).max() < 1e-8 and np.array_equal(used, used_again)
    assert np.array_equal(back.facade.local_from_facade.covariance, ortho.facade.local_from_facade.covariance)


def test_a_window_is_an_ortho_image_of_its_own(ortho, tmp_path):
    about = PhotoOffset(0.0123456789, 0.0004, 17, True)
    ortho_io.write_ortho(tmp_path, replace(ortho, photo_offset=about))
    window = Tile(30, 170, 5, 290)
    part = ortho_io.read_ortho(tmp_path, window)
    for name in ("pixels", "depth", "source", "gsd_effective", "intensity"):
        assert getattr(part, name).tobytes() == getattr(ortho, name)[window.window].tobytes(), name
    at, whole = np.array([[3.5, 7.25], [200.0, 100.0]]), np.array([[8.5, 37.25], [205.0, 130.0]])
    assert np.allclose(part.pixel_to_world(at)[0], ortho.pixel_to_world(whole)[0], rtol=0, atol=1e-8)
    assert part.photo_offset == about
    with pytest.raises(InputError, match="320 x 220 px"):
        ortho_io.read_ortho(tmp_path, Tile(0, 221, 0, 10))


def test_tiles_at_the_edges_come_back_whole(tmp_path):
    band = np.random.default_rng(0).integers(0, 255, (300, 530, 4)).astype(np.uint8)
    write_geotiff(tmp_path / "a.tif", band, Georeference((1.0, 2.0), 0.5, "x", {}))
    assert np.array_equal(read_geotiff(tmp_path / "a.tif")[0], band)
    window = Tile(200, 300, 250, 530)
    part, corner, _ = read_geotiff(tmp_path / "a.tif", window)
    assert np.array_equal(part, band[window.window]) and corner == (126.0, -98.0)


def test_a_picture_without_relief_keeps_one_value_for_its_depth(tmp_path):
    facade = wall.facade(3.0, 2.0)
    flat = make_ortho(facade, wall.wall_cloud(facade), options=OrthoOptions(relief=False))
    assert not any(flat.depth.strides) and np.isnan(flat.depth).all()
    ortho_io.write_ortho(tmp_path, flat)
    back = ortho_io.read_ortho(tmp_path)
    assert back.depth.shape == flat.depth.shape and np.isnan(back.depth).all()


def test_the_sidecar_is_the_contract(ortho, tmp_path):
    ortho_io.write_ortho(tmp_path, ortho)
    side = json.loads((tmp_path / "ortho.json").read_text())
    keys = {
        "building",
        "facade",
        "crs",
        "gsd",
        "width",
        "height",
        "raster_to_world",
        "frame",
        "sigma_plane",
        "sources",
    }
    assert keys <= set(side)
    M, pixel = np.array(side["raster_to_world"]), np.array([120.5, 80.25])
    world, _ = ortho.pixel_to_world(pixel[None], relief=False)
    assert np.abs((M @ [*pixel, 0.0, 1.0])[:3] - world[0]).max() < 1e-8
    deep = (M @ [*pixel, 0.3, 1.0])[:3] - world[0]
    assert np.allclose(deep, 0.3 * np.array(side["frame"]["y"]), atol=1e-8)
    assert np.allclose(np.cross(side["frame"]["z"], side["frame"]["x"]), side["frame"]["y"])


def test_the_sidecar_round_trips_byte_for_byte(ortho, tmp_path):
    ortho_io.write_ortho(tmp_path, replace(ortho, photo_offset=PhotoOffset(0.01, 0.001, 5, False)))
    text = (tmp_path / "ortho.json").read_text()
    side = read_sidecar(tmp_path)
    assert json.dumps(side.to_json(), indent=1) + "\n" == text
    assert OrthoSidecar.from_json(side.to_json()).to_json() == side.to_json()
    assert (side.size, side.gsd, side.corner, side.sources) == (
        ortho.size,
        ortho.gsd,
        ortho.corner,
        ortho.sources,
    )
    assert side.corner_in(ortho.facade) == pytest.approx(ortho.corner, abs=1e-8)
    assert side.size_m == pytest.approx((ortho.size[0] * ortho.gsd, ortho.size[1] * ortho.gsd))
    assert side.relief and 0.0 < side.nodata_share < 1.0


def test_the_tiff_is_georeferenced_and_tiled_and_holds_the_matrix_to_the_world(ortho, tmp_path):
    ortho_io.write_ortho(tmp_path, ortho)
    with tifffile.TiffFile(tmp_path / "ortho.tif") as tif:
        page = tif.pages[0]
        assert page.is_tiled and page.compression.name == "ADOBE_DEFLATE" and page.shape[2] == 4
        assert page.tags[33550].value == (ortho.gsd, ortho.gsd, 0.0)
        assert page.tags[33922].value[3:5] == pytest.approx(ortho.corner)
        assert "RASTER_TO_WORLD" in page.tags[42112].value
    side = json.loads((tmp_path / "ortho.json").read_text())
    jpeg = cv2.imread(str(tmp_path / "ortho.jpg"))
    assert jpeg.shape[:2] == (side["height"], side["width"])
    assert np.isnan(tifffile.imread(tmp_path / "depth.tif")).any()
    assert tifffile.imread(tmp_path / "sources.tif").dtype == np.uint16


def test_gdal_reads_the_plane_coordinates(ortho, tmp_path):
    import rasterio  # only here: it brings its own GDAL and PROJ

    ortho_io.write_ortho(tmp_path, ortho)
    with rasterio.open(tmp_path / "ortho.tif") as tif:
        assert tif.xy(20, 10, offset="ul") == pytest.approx((ortho.corner[0] + 0.1, ortho.corner[1] - 0.2))
        assert "metre" in tif.crs.to_wkt()


def test_more_than_four_gigabytes_is_a_big_tiff(ortho, tmp_path, monkeypatch):
    monkeypatch.setattr("frontage.io.rasters.geotiff._BIG", 1000)
    write_geotiff(tmp_path / "a.tif", ortho.pixels, Georeference(ortho.corner, ortho.gsd, "x", {}))
    with tifffile.TiffFile(tmp_path / "a.tif") as tif:
        assert tif.is_bigtiff


def test_a_write_that_fails_leaves_the_earlier_file(ortho, tmp_path, monkeypatch):
    ortho_io.write_ortho(tmp_path, ortho)
    before = (tmp_path / "ortho.tif").read_bytes()

    def full_disk(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tifffile.TiffWriter, "write", full_disk)
    with pytest.raises(FileError, match="No space left"):
        ortho_io.write_ortho(tmp_path, ortho)
    assert (tmp_path / "ortho.tif").read_bytes() == before
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")]


def test_missing_damaged_and_foreign_files_are_refused(ortho, tmp_path):
    with pytest.raises(FileError, match=r"ortho\.json: does not exist"):
        ortho_io.read_ortho(tmp_path)
    ortho_io.write_ortho(tmp_path, ortho)
    side = json.loads((tmp_path / "ortho.json").read_text())
    (tmp_path / "ortho.json").write_text(json.dumps({k: v for k, v in side.items() if k != "frame"}))
    with pytest.raises(FileError, match="frame"):
        ortho_io.read_ortho(tmp_path)
    (tmp_path / "ortho.json").write_text(json.dumps(side | {"width": 7}))
    with pytest.raises(FileError, match="does not fit"):
        ortho_io.read_ortho(tmp_path)
    (tmp_path / "ortho.json").write_text("{")
    with pytest.raises(FileError, match="not valid JSON"):
        ortho_io.read_ortho(tmp_path)
    (tmp_path / "ortho.json").write_text(json.dumps(side))
    content = (tmp_path / "depth.tif").read_bytes()
    (tmp_path / "depth.tif").write_bytes(content[: len(content) // 2])
    with pytest.raises(FileError, match=r"depth\.tif"):
        ortho_io.read_ortho(tmp_path)


def test_an_output_that_is_a_file_is_refused(ortho, tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(FileError, match="out"):
        ortho_io.write_ortho(tmp_path / "out", ortho)
    assert (tmp_path / "out").read_text() == "mine"


def test_a_facade_comes_back_from_its_json(ortho):
    made = ortho.facade
    facade = replace(made, layers=(Layer(0.3, float("inf"), 2.0, np.empty((0, 2))),), notes=("bent",))
    back = facade_from_json(json.loads(json.dumps(facade_to_json(facade))), made.support, made.inliers)
    assert facade_to_json(back) == facade_to_json(facade)
    assert back.layers[0].sigma == float("inf") and back.layers[0].outline.shape == (0, 2)
    assert np.array_equal(back.frame.R, made.frame.R) and np.array_equal(back.world.origin, made.world.origin)
