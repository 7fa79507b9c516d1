"""The points of a scan in the frame of a facade."""

from frontage.geometry.arrays import Float, by_axis
from frontage.model import Facade, Scan


def in_facade_frame(scan: Scan, facade: Facade) -> Float:
    """Returns the points (n, 3) m of a scan in the frame of a facade, axis by axis in memory."""
    return by_axis(facade.frame.inverse.apply(scan.xyz))
