"""The picture of the evidence shows what the layout was found from."""

from dataclasses import replace

import numpy as np

from frontage.model import Failed
from frontage.openings import OpeningOptions
from frontage.openings.observe import observe_wall
from frontage.pipeline.pictures import evidence_pictures
from fronts import WINDOW, scan_wall


def test_panels_are_drawn_as_the_wall_that_they_are() -> None:
    facade, scan = scan_wall([WINDOW], returned=0.2)
    x, _, z = scan.xyz.T
    recessed = (x > 1.0) & (x < 2.2) & (z > 0.9) & (z < 1.8)
    panelled = replace(scan, xyz=scan.xyz + np.outer(recessed * 0.06, [0.0, 1.0, 0.0]))
    seen = observe_wall(facade, panelled, OpeningOptions())
    assert not isinstance(seen, Failed)
    (picture,) = evidence_pictures(seen)
    image = picture.image
    x0, z0, x1, z1 = picture.extent
    h, w = image.shape[:2]

    def blue(bx0: float, bz0: float, bx1: float, bz1: float) -> float:
        rows = slice(int((z1 - bz1) / (z1 - z0) * h), int((z1 - bz0) / (z1 - z0) * h))
        part = image[rows, int((bx0 - x0) / (x1 - x0) * w) : int((bx1 - x0) / (x1 - x0) * w)]
        return float((part[..., 0] > part[..., 2]).mean())

    assert (
        blue(1.2, 1.1, 2.0, 1.6) > 0.95
        and blue(1.2, 2.2, 2.0, 3.4) < 0.05
        and blue(3.0, 1.0, 5.0, 4.0) > 0.95
    )
