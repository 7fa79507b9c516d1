"""What a caller asks of one scan file: the noun that every reader of the registry takes."""

from collections.abc import Callable
from dataclasses import dataclass

from frontage.io.placement import PlacementRequest

Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0..1."""


@dataclass(frozen=True, eq=False)
class ScanRequest:
    """What a caller asks of one scan file; readers ignore what does not apply to their format.

    placement   the coordinates: CRS, units, offset, world
    sigmas      six, m and rad (x, y, z, about x, y, z), of a pose that is only approximate; None = exact
    stations    JSON file of station positions (LAS); None: "<file>.stations.json" beside the scan, if there
    trajectory  CSV or SBET file of the vehicle (LAS): every point gets the sensor position at its gps_time
    bounds      (x0, y0, x1, y1) or (x0, y0, z0, x1, y1, z1), m world. A reader may use them to read less;
                `read_scans` crops afterwards
    resolution  m: one point per cube of this size is enough; `read_scans` thins afterwards
    progress    called with the share done
    """

    placement: PlacementRequest
    sigmas: tuple[float, ...] | None = None
    stations: str | None = None
    trajectory: str | None = None
    bounds: tuple[float, ...] | None = None
    resolution: float | None = None
    progress: Progress | None = None
