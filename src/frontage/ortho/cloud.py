"""The points of a scan in the frame of a facade."""

import numpy as np

from frontage.geometry.arrays import Array
from frontage.model import Facade, Scan


def in_facade_frame(scan: Scan, facade: Facade) -> Array:
    """Returns the points (n, 3) float32 m of a scan in the frame of a facade, axis by axis in memory.

    The origin of that frame lies on the facade: 100 m from it, single precision is good to 4 micrometres.
    """
    return np.asarray(facade.frame.inverse.apply(scan.xyz), np.float32, order="F")
