"""Glass: frames are planes, curtains behind them are not the facade, and one photo shows a whole window."""

from dataclasses import replace

import numpy as np
import pytest

import ortho_wall as wall
from frontage.geometry.arrays import Array
from frontage.ortho import OrthoOptions, make_ortho
from frontage.ortho.glazing import fill_openings
from frontage.ortho.orthoraster import facade_raster
from frontage.ortho.outline import inside_outline
from frontage.raster.tiles import Tile

CELL, STEP = 0.03, 0.03
WINDOW = (slice(30, 80), slice(40, 90))  # rows, columns of cells: 1.5 m x 1.5 m
FRAME, CURTAIN = 0.16, 0.30


def window_relief() -> tuple[Array, Array]:
    """A wall with a window of four panes, some of which show patches of a curtain, and a gap in the wall."""
    y = np.zeros((120, 160), np.float32)
    y[WINDOW] = np.nan
    rows, columns = WINDOW
    for r in (rows.start, 54, rows.stop - 2):
        y[r : r + 2, columns] = FRAME
    for c in (columns.start, 64, columns.stop - 2):
        y[rows, c : c + 2] = FRAME
    y[35:43, 45:58] = CURTAIN
    y[20:50, 120:140] = np.nan
    return y, np.isfinite(y)


def filled(y: Array, known: Array):
    cell = np.flatnonzero(known)
    points = (np.repeat(cell, 3), np.repeat(y.ravel()[cell].astype(np.float64), 3))
    return fill_openings(y, known, np.ones(y.shape, bool), points, size=CELL, step=STEP)


def test_panes_lie_on_the_plane_of_their_frame():
    found = filled(*window_relief())
    assert np.allclose(found.y[WINDOW], FRAME, atol=0.002), "frame, bars, panes and what hangs behind them"
    assert (found.opening[WINDOW] > 0).all()
    assert len(np.unique(found.opening[WINDOW])) == 1
    assert not found.known[35:43, 45:58].any(), "a curtain is not the surface of the facade"
    assert found.known[30:32, 40:90].all()


def test_bars_that_were_measured_a_little_off_lie_on_the_plane_of_their_frame():
    y, known = window_relief()
    y[54:56, 44:60] = FRAME + 0.02
    y[60:76, 64:66] = FRAME - 0.015
    found = filled(y, known)
    assert np.ptp(found.y[WINDOW]) < 1e-6


def test_a_curtain_that_fills_a_window_is_drawn_on_the_plane_of_the_bars_before_it():
    y, known = window_relief()
    inside = np.zeros_like(known)
    inside[WINDOW] = True
    curtain = inside & ~known | (y == CURTAIN)
    y[curtain] = CURTAIN
    found = filled(y, known | curtain)
    assert np.allclose(found.y[WINDOW], FRAME, atol=0.002), "more of the curtain was seen than of the frame"
    assert not found.known[curtain].any()


def test_a_wide_surface_that_no_bar_crosses_keeps_its_depth():
    """A leaf beside a side light with bars."""
    y, _ = window_relief()
    y[32:80, 42:63] = CURTAIN
    found = filled(y, np.isfinite(y))
    assert np.allclose(found.y[36:76, 45:60], CURTAIN)
    assert np.allclose(found.y[36:76, 68:86], FRAME, atol=0.002)


def test_frames_stand_as_deep_as_a_brick_and_a_half_with_render():
    y, _ = window_relief()
    y[y == CURTAIN] = np.nan
    y[y == FRAME] = 0.385
    found = filled(y, np.isfinite(y))
    assert np.allclose(found.y[WINDOW], 0.385, atol=0.002)
    assert (found.opening[WINDOW] > 0).all()


def test_gaps_of_the_wall_are_closed_by_the_wall():
    found = filled(*window_relief())
    assert np.allclose(found.y[20:50, 120:140], 0.0)
    assert not found.known[20:50, 120:140].any()
    assert (found.opening[20:50, 120:140] == 0).all()


def test_a_door_leaf_behind_its_frame_keeps_its_depth():
    y, known = window_relief()
    y[34:76, 44:86], known[34:76, 44:86] = 0.25, True  # 1.26 m wide and whole
    found = filled(y, known)
    assert np.allclose(found.y[40:70, 50:80], 0.25)
    assert found.known[40:70, 50:80].all()


def test_a_recessed_entrance_is_part_of_the_picture_and_the_sky_is_not():
    facade = wall.facade(8.0, 6.0)
    ring = np.array(
        [[-4, -3], [1, -3], [1, -0.5], [3, -0.5], [3, -3], [4, -3], [4, 2], [0, 3], [-4, 2]], float
    )
    facade = replace(facade, outline=ring)
    raster = facade_raster(facade, OrthoOptions(margin=0.0))
    mask = inside_outline(facade, raster, Tile(0, raster.height, 0, raster.width), 0.0)
    assert mask[450, 600], "between the piers, below the wall"
    assert not mask[5, 5], "beside the gable"


@pytest.fixture(scope="module")
def mirrored():
    """A wall with a window; its glass mirrors the sky in the photo that stands best, and less in others."""
    facade = wall.facade(6.0, 4.0)
    depth = lambda x, z: np.where((np.abs(x) < 1.0) & (np.abs(z) < 1.0), FRAME, 0.0)  # noqa: E731
    cloud = wall.wall_cloud(facade, depth=depth)
    xyz = facade.frame.inverse.apply(cloud.xyz)
    pane = (np.abs(xyz[:, 0]) < 0.85) & (np.abs(xyz[:, 2]) < 0.85)
    cloud = cloud.take(np.flatnonzero(~pane))
    picture = (wall.texture(6.0, 4.0) * 0.6).astype(np.uint8)
    camera = wall.camera(1000, 800)
    photos = [wall.photo(facade, camera, (x, -7.0, 0.0), name=f"{x:g}.jpg") for x in (-2.0, 0.3, 1.2, 2.6)]
    shots = {}
    for photo, mirror in zip(photos, (40, 120, 8, 0), strict=True):
        seen = picture.copy()
        seen[115:285, 215:385] = np.minimum(picture[115:285, 215:385] // 3 + mirror, 255)
        shots[photo.id] = wall.render(photo, facade, seen, depth)
    return make_ortho(facade, cloud, photos, shots.__getitem__, options=OrthoOptions(margin=0.0))


def test_the_photo_with_the_least_reflection_shows_the_whole_window(mirrored):
    names = np.array(["", *mirrored.sources])[mirrored.source[130:270, 230:370]]
    assert np.isin(names, ["2.6.jpg", "1.2.jpg"]).mean() > 0.99
    assert np.isnan(mirrored.depth[200, 300]), "the relief of the glass is not known"
