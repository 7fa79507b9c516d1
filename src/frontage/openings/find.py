"""Openings and protrusions of a facade."""

from dataclasses import replace
from functools import partial

from frontage.model.estimate import Failed
from frontage.model.facade import Facade
from frontage.model.opening import Elements
from frontage.model.ortho import OrthoImage
from frontage.model.scan import Scan
from frontage.openings.detect import find_by_evidence
from frontage.openings.kinds import numbered, with_doors
from frontage.openings.layout.disjoint import apart
from frontage.openings.niches import find_niches
from frontage.openings.options import OpeningOptions
from frontage.openings.paper.find import find_by_paper
from frontage.openings.protrusions.borders import Crossings
from frontage.openings.protrusions.doors import with_balcony_doors
from frontage.openings.protrusions.find import find_protrusions
from frontage.openings.protrusions.find import numbered as numbered_protrusions
from frontage.openings.recursion import Fronts, openings_on_fronts


def find_openings(
    facade: Facade, scan: Scan, options: OpeningOptions | None = None, ortho: OrthoImage | None = None
) -> Elements | Failed:
    """What the facade holds.

    `scan` is the facade's working cloud: `facade.support` indexes it, its origins are the sensor's places.
    What photos saw of the facade's `ortho` tells closed openings, besides the scan.
    Rings are in the facade frame (x right, z up as seen from the street; depth positive = recess).
    """
    options = options or OpeningOptions()
    if options.method == "paper":
        return find_by_paper(facade, scan, options)
    find = partial(find_by_evidence, options=options, ortho=ortho)
    found = find(facade, scan)
    if not isinstance(found, Elements):
        return found
    crossings = Crossings.of(facade, scan)
    protrusions = find_protrusions(facade, crossings, found.openings, options.ground_z)
    fronts = Fronts(facade, scan, find)
    niches = find_niches(found.openings, protrusions, fronts)
    if niches:
        protrusions = numbered_protrusions(facade.id, [*protrusions, *niches])
    openings = openings_on_fronts(found.openings, protrusions, fronts)
    openings = apart(with_balcony_doors(openings, protrusions, crossings, facade))
    doors = with_doors(openings, facade.extent[1] if options.ground_z is None else options.ground_z)
    return replace(found, openings=numbered(facade.id, doors), protrusions=protrusions)
