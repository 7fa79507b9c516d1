"""Inner corners: the wall goes on to the other wall, and what lies before hidden places is not hidden."""

import numpy as np
import pytest

import ortho_wall as wall
from frontage.model import Scan
from frontage.ortho import OrthoOptions, make_ortho
from frontage.ortho.corners import find_corners
from frontage.ortho.gaps import Gaps
from frontage.ortho.occluders import OccluderCloud
from frontage.ortho.orthoraster import OrthoRaster, facade_raster
from frontage.ortho.relief import measure_relief
from frontage.ortho.visibility import visibility

CORNER = 4.0  # m, x at which the wall meets the other one, which stands before it
LAST = 3.92  # m, x of the last points of the wall
SHORT = 3.8  # m, x at which its outline ends


def grid(x, y, z, step=0.04):
    return wall.grid(x, y, z, step)


def relief_of(facade, xyz, options):
    raster = facade_raster(facade, options)
    gaps = Gaps(raster.height + raster.width, np.full((1, 1), 0.04 / raster.gsd, np.float32))
    return measure_relief(xyz, facade, raster, options, gaps)


@pytest.fixture(scope="module")
def court():
    """A wall of 8 x 6 m whose outline ends 20 cm before its corner on the right, and the points before it."""
    facade = wall.facade(2.0 * SHORT, 6.0, spacing=0.04)
    front, other = grid((-SHORT, LAST), 0.0, (-3.0, 3.0)), grid(CORNER, (-1.4, 0.0), (-3.0, 5.0), 0.06)
    return facade, front, other


def test_the_corner_lies_where_the_other_wall_stands(court):
    facade, front, other = court
    xyz = np.concatenate([front, other])
    (corner,) = find_corners(xyz, relief_of(facade, xyz, OrthoOptions()))
    assert corner.x == pytest.approx(CORNER, abs=0.01)
    assert corner.wall == -1
    assert (corner.bottom, corner.top) == pytest.approx((-3.0, 3.0), abs=0.3), "no higher than the wall"


@pytest.mark.parametrize(
    "points",
    [
        pytest.param(grid((-SHORT, LAST), 0.0, (-3.0, 3.0)), id="no other wall"),
        pytest.param(grid(CORNER, (-1.4, 0.0), (-3.0, -2.0)), id="a box of one metre"),
        pytest.param(grid(CORNER, (-0.12, 0.0), (-3.0, 3.0)), id="a pipe"),
        pytest.param(grid(0.0, (-1.4, 0.0), (-3.0, 3.0)), id="wall on both sides"),
    ],
)
def test_nothing_else_is_a_corner(court, points):
    facade, front, _ = court
    assert find_corners(np.concatenate([front, points]), relief_of(facade, front, OrthoOptions())) == ()


def test_the_picture_of_the_wall_goes_on_to_the_corner(court):
    facade, front, other = court
    scan = Scan("court", facade.frame.apply(np.concatenate([front, other])), facade.world)
    picture = wall.texture(2.0 * SHORT + 2.0, 6.0)
    large = wall.facade(2.0 * SHORT + 2.0, 6.0, spacing=0.04)
    photos = [
        wall.photo(facade, wall.camera(1000, 800), (x, -8.0, -0.4), name=f"{x:g}.jpg") for x in (-2.0, 2.0)
    ]
    shots = {p.id: wall.render(p, large, picture) for p in photos}
    ortho = make_ortho(facade, scan, photos, shots.__getitem__, options=OrthoOptions(margin=0.3))
    column = (CORNER - ortho.corner[0]) / ortho.gsd
    painted = ortho.pixels[100:500, :, 3] > 0
    strip = painted[:, round(column) - 15 : round(column) - 1]
    assert strip.mean() > 0.99, "up to the corner"
    assert painted[:, round(column) + 2 :].mean() < 0.05, "and not beyond"


def test_a_board_is_not_hidden_because_the_wall_around_it_is():
    """A board of two cells stands 42 cm before the wall, above a gutter, seen from far below."""
    cells = OrthoRaster((0.0, 2.0), 0.04, 50, 50)
    y = np.full((50, 50), 0.05, np.float32)
    board = np.s_[20:22]
    y[board] = -0.42
    z = 2.0 - (np.arange(50) + 0.5) * 0.04
    shown = grid((0.0, 2.0), -0.42, (z[21] - 0.02, z[20] + 0.02), 0.02)
    gutter = grid((0.0, 2.0), -0.5, (z[40], z[22]), 0.02)
    xyz = np.asfortranarray(np.concatenate([shown, gutter]), dtype=np.float32)
    none = np.zeros((0, 3), np.float32, order="F"), np.zeros(0, np.float32)
    cloud = OccluderCloud((xyz, np.full(len(xyz), 0.04, np.float32)), none, none)
    centre = np.array([1.0, -14.0, z[21] - 7.5])
    x = (np.arange(50) + 0.5) * 0.04
    distance = np.sqrt((x - 1.0) ** 2 + (y + 14.0) ** 2 + (z - centre[2])[:, None] ** 2).astype(np.float32)
    factor = visibility(centre, cells, y, distance, cloud, 0.03).factor[:, 5:45]
    assert (factor[17:20] == 0.0).all()
    assert (factor[22:28] == 0.0).all(), "the wall above and below the board is hidden"
    assert (factor[board] > 0.0).all()
