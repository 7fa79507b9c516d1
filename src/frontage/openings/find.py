"""Openings and protrusions of a facade."""

from frontage.model.estimate import Failed
from frontage.model.facade import Facade
from frontage.model.opening import Elements
from frontage.model.scan import Scan
from frontage.openings.detect import find_by_evidence
from frontage.openings.options import OpeningOptions
from frontage.openings.paper import find_by_paper


def find_openings(facade: Facade, scan: Scan, options: OpeningOptions | None = None) -> Elements | Failed:
    """What the facade holds.

    `scan` is the facade's working cloud: `facade.support` indexes it, its origins are the sensor's places.
    Rings are in the facade frame (x right, z up as seen from the street; depth positive = recess).
    """
    options = options or OpeningOptions()
    find = find_by_paper if options.method == "paper" else find_by_evidence
    return find(facade, scan, options)
