"""Pictures of the evidence: every cell in the colour of what was seen there, the right way up."""

from types import SimpleNamespace

import numpy as np

from frontage.openings.paper.find import decompose
from frontage.openings.wall.raster import WallRaster
from frontage.report.evidence import Picture, beam_picture, cell_pictures


def hue(bgra: np.ndarray) -> str:
    b, g, r, alpha = (int(v) for v in bgra)
    if alpha == 0:
        return "outside"
    if max(r, g, b) - min(r, g, b) < 10:
        return "dark grey" if r < 200 else "light grey"
    return "blue" if b > r else "yellow" if g > 170 else "orange"


def test_cells_have_the_colour_of_what_their_beams_say() -> None:
    raster = WallRaster((-1.0, 2.0), 0.1, (3, 4))
    llr, opened, inside = np.zeros((3, 4)), np.zeros((3, 4)), np.ones((3, 4), bool)
    llr[0] = [-6.0, -1.0, 6.0, 6.0]  # the lowest row: wall, hardly wall, through, no return
    opened[0, 2] = 3
    inside[2, 0] = False
    evidence = SimpleNamespace(raster=raster, llr=llr, open=opened, inside=inside)
    beams = SimpleNamespace(blocked=np.array([[-0.95, 2.15]]))
    picture = beam_picture(beams, evidence)
    times = picture.image.shape[0] // 3
    small = picture.image[times // 2 :: times, times // 2 :: times]
    np.testing.assert_allclose(picture.extent, (-1.0, 2.0, -0.6, 2.3))
    assert [hue(c) for c in small[2]] == ["blue", "blue", "orange", "yellow"]
    assert small[2, 0, 2] < small[2, 1, 2]  # the surer, the stronger
    assert [hue(c) for c in small[1]] == ["dark grey"] + ["light grey"] * 3
    assert hue(small[0, 0]) == "outside" and hue(small[0, 3]) == "light grey"


def test_the_paper_s_pictures_show_the_window_white_where_it_is() -> None:
    x, z = np.meshgrid(np.arange(0.0, 4.0, 0.02), np.arange(0.0, 3.0, 0.02))
    xz = np.column_stack([x.ravel(), z.ravel()])
    hole = (xz > [2.01, 1.01]).all(1) & (xz < [2.99, 2.49]).all(1)
    outline = np.array([[0.0, 0.0], [3.95, 0.0], [3.95, 2.95], [0.0, 2.95]])
    edges, before, after = cell_pictures(decompose(xz[~hole], outline, 0.02, (0.3, 0.3)))
    assert [p.name for p in (edges, before, after)] == ["evidence", "cells_before", "cells"]

    def at(picture: Picture, x: float, z: float) -> tuple[int, ...]:
        x0, z0, x1, z1 = picture.extent
        h, w = picture.image.shape[:2]
        row, column = int((z1 - z) / (z1 - z0) * h), int((x - x0) / (x1 - x0) * w)
        return tuple(picture.image[row, column, :3].tolist())

    for picture in (edges, before, after):
        assert at(picture, 2.5, 1.7) == (255, 255, 255), picture.name
        assert at(picture, 1.0, 0.5)[0] < 200 and at(picture, 2.5, 0.4)[0] < 200, picture.name
    red = (edges.image[..., 2] > 150) & (edges.image[..., 1] < 100)
    blue = (edges.image[..., 0] > 150) & (edges.image[..., 2] < 100)
    assert red.any() and blue.any()
