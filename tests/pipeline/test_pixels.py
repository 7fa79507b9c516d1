"""Pixel <-> world from the files alone."""

from dataclasses import replace

import numpy as np
import pytest

import ortho_wall as wall
from frontage.errors import WorkspaceError
from frontage.io.rasters.ortho import write_ortho
from frontage.model import PhotoOffset
from frontage.ortho import OrthoOptions, make_ortho
from frontage.pipeline.stages.ortho import ortho_warnings
from frontage.queries import pixels as module
from frontage.queries.pixels import FacadePixels


def test_any_pixel_is_answered_from_its_own_part_of_the_relief(tmp_path, monkeypatch):
    facade = wall.facade(3.0, 2.0)
    ortho = make_ortho(facade, wall.wall_cloud(facade), options=OrthoOptions(margin=0.1))
    write_ortho(tmp_path, ortho)
    monkeypatch.setattr(module, "_TILE", 64)
    files = FacadePixels(tmp_path)
    at = np.random.default_rng(0).uniform([-5, -5], [325, 225], (400, 2))
    world, y, used = files.world_from_pixels(at)
    expected, expected_used = ortho.pixel_to_world(at)
    assert np.abs(world - expected).max() < 1e-6 and np.array_equal(used, expected_used)
    assert used.any() and not used.all() and (y[~used] == 0).all()
    back, _ = files.pixels_from_world(world)
    assert np.abs(back - at).max() < 1e-6


def test_one_pixel_reads_one_part(tmp_path, monkeypatch):
    facade = wall.facade(3.0, 2.0)
    write_ortho(tmp_path, make_ortho(facade, wall.wall_cloud(facade), options=OrthoOptions(margin=0.1)))
    asked = []
    read = module.read_geotiff
    monkeypatch.setattr(module, "_TILE", 64)
    monkeypatch.setattr(
        module, "read_geotiff", lambda path, window: asked.append(window) or read(path, window)
    )
    files = FacadePixels(tmp_path)
    assert files.pixel_to_world(100.5, 70.5).surface == "relief" and files.pixel_to_world(101.5, 71.5)
    assert [(w.r0, w.c0) for w in asked] == [(64, 64)]


def test_a_damaged_relief_is_said(tmp_path):
    facade = wall.facade(3.0, 2.0)
    write_ortho(tmp_path, make_ortho(facade, wall.wall_cloud(facade), options=OrthoOptions(margin=0.1)))
    (tmp_path / "depth.tif").write_bytes(b"II*")
    with pytest.raises(WorkspaceError, match=r"depth\.tif"):
        FacadePixels(tmp_path).pixel_to_world(100.5, 70.5)


def test_a_run_warns_where_the_photos_see_the_facade_elsewhere():
    facade = wall.facade(3.0, 2.0)
    ortho = make_ortho(facade, wall.wall_cloud(facade), options=OrthoOptions(margin=0.1))
    assert ortho_warnings("B01/F1", ortho) == []
    small = replace(ortho, photo_offset=PhotoOffset(0.0002, 0.0003, 20, applied=False))
    assert ortho_warnings("B01/F1", small) == []
    (warning,) = ortho_warnings("B01/F1", replace(ortho, photo_offset=PhotoOffset(-0.0145, 0.0003, 20, True)))
    assert (warning.item, warning.code) == ("B01/F1", "F303")
    assert "14.5 mm in front of the scan" in warning.message and warning.hint
