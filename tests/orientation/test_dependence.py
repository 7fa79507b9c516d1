"""What is stated of errors that no residual shows."""

from dataclasses import replace

import numpy as np

from frontage.orientation.dependence import dependence_of
from frontage.orientation.network import CONTROL
from frontage.orientation.reflectance.surface import scanned_surface
from orientation.paintedwalls import corner_of_two, scan_of


def test_steps_in_depth_are_displaced_by_more_than_paint():
    """Shape alone has no paint: its edges are displaced together by a quarter of the spacing."""
    painted = scanned_surface(scan_of(corner_of_two(), 0.04))
    shape = replace(painted, tone=None, kind="geometry")
    stated = [dependence_of([], [], surface).least[CONTROL] for surface in (painted, shape)]
    assert np.allclose(np.array(stated) / np.median(painted.spacing), (0.01, 0.25))
