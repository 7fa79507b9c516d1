"""Whether a city model and a scan are in one place: told before anything is fitted to anything."""

import numpy as np

from frontage.errors import CrsError
from frontage.geometry.arrays import Float
from frontage.model.citymodel import CityModel


def require_overlap(model: CityModel, bounds: Float, margin: float, name: str = "the city model") -> None:
    """Raise CrsError with one sentence when no building lies near the scan.

    bounds  (2, 2) or (2, 3) m local of the model's world: lowest and highest corner of the scan
    margin  m: how far apart they may lie in plan (what the poses may be off)
    name    the model's file, for the message
    """
    if not model.buildings:
        raise CrsError(f"{name}: holds no buildings; name another model", code="I105")
    box, scan = model.bounds()[:, :2], np.asarray(bounds, np.float64)[:, :2]
    apart = _gap(box, scan)
    if apart <= margin:
        return
    origin = model.world.origin[:2]
    turned = (box + origin)[:, ::-1] - origin
    if _gap(turned, scan) <= margin:
        advice = "its x and y are swapped: write it with east before north, or name its CRS"
    else:
        advice = "check the CRS of both"
    (mx, my), (sx, sy) = box.mean(0) + origin, scan.mean(0) + origin
    raise CrsError(
        f"{name}: lies {apart:.0f} m away from the scan (the model around {mx:.0f}, {my:.0f}, the scan "
        f"around {sx:.0f}, {sy:.0f}); {advice}",
        code="I206",
    )


def _gap(a: Float, b: Float) -> float:
    """The distance in m between two boxes, 0 where they meet."""
    return float(np.linalg.norm(np.maximum(0.0, np.maximum(a[0] - b[1], b[0] - a[1]))))
