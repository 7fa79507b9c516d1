"""The entry of the room: the openings and protrusions of one facade."""

from dataclasses import dataclass

from frontage.model.estimate import Failed
from frontage.model.facade import Facade
from frontage.model.opening import Elements, Opening, Protrusion
from frontage.model.ortho import OrthoImage
from frontage.model.scan import Scan
from frontage.openings.fronts import FrontSearch, openings_on_fronts
from frontage.openings.kinds import in_reading_order, with_doors
from frontage.openings.layout.overlaps import best_without_overlaps
from frontage.openings.niches import find_niches, without_leaves
from frontage.openings.observe import ObservedWall, observe_wall
from frontage.openings.onwall import find_on_wall
from frontage.openings.options import OpeningOptions
from frontage.openings.paper.find import Decomposition, find_by_paper
from frontage.openings.protrusions.beams import FacadeBeams
from frontage.openings.protrusions.doors import with_balcony_doors
from frontage.openings.protrusions.find import find_protrusions, number_protrusions
from frontage.openings.wall.smoothing import smoothed

_UNSEEN_SHARE = 0.05  # share of a facade that may stay unseen without a note


@dataclass(frozen=True, eq=False)
class FoundOpenings:
    """What was found on a facade, and the evidence that it was found from.

    elements  the openings, which have no id, floor or bay until `catalog` numbers the whole building, and the
              protrusions
    evidence  the beams and cells of the default method, or the cell decomposition of the published one
    """

    elements: Elements
    evidence: ObservedWall | Decomposition

    @property
    def openings(self) -> tuple[Opening, ...]:
        """The openings, storey by storey from the lowest and from left to right."""
        return self.elements.openings

    @property
    def protrusions(self) -> tuple[Protrusion, ...]:
        """The protrusions, from left to right."""
        return self.elements.protrusions

    @property
    def notes(self) -> tuple[str, ...]:
        """What could not be judged."""
        return self.elements.notes


def find_openings(
    facade: Facade, scan: Scan, options: OpeningOptions | None = None, ortho: OrthoImage | None = None
) -> FoundOpenings | Failed:
    """Finds the openings and protrusions of a facade (paper B, sections 3.1 and 3.2).

    `scan` is the facade's working cloud: `facade.support` indexes its points, and its origins are the places
    of the sensor. `ortho`, the facade's ortho-image, shows closed openings where photos saw them. Rings are
    in the facade frame in m (x to the right and z up as seen from the street); depths are positive behind the
    wall. Returns `Failed` F401 or F402 when the facade has too few points or hardly any wall.
    """
    options = options or OpeningOptions()
    if options.method == "paper":
        found = find_by_paper(facade, scan, options)
        return found if isinstance(found, Failed) else FoundOpenings(*found)

    facade, scan = smoothed(facade, scan)

    def search(front: Facade, cloud: Scan) -> tuple[Opening, ...]:
        """Finds the openings of the front of a protrusion or niche, which is a wall of its own."""
        seen = observe_wall(front, cloud, options)
        return () if isinstance(seen, Failed) else find_on_wall(cloud, seen, options, ortho)

    wall = observe_wall(facade, scan, options)  # 3.2.1, cell generation
    if isinstance(wall, Failed):
        return wall
    openings = find_on_wall(scan, wall, options, ortho)  # 3.2.2, classification
    beams = FacadeBeams.of(facade, scan)
    fronts = FrontSearch(facade, scan, search)
    protrusions = find_protrusions(facade, beams, openings, options.ground_z)  # 3.2.3, modelling
    protrusions = without_leaves(protrusions, openings, fronts)
    niches = find_niches(openings, protrusions, fronts)
    protrusions = number_protrusions(facade.id, [*protrusions, *niches])
    on_all_walls = openings_on_fronts(openings, protrusions, fronts)
    separate = best_without_overlaps(with_balcony_doors(on_all_walls, protrusions, beams, facade))
    openings = in_reading_order(with_doors(separate, wall.ground))
    return FoundOpenings(Elements(facade.id, openings, protrusions, _notes(wall)), wall)


def _notes(wall: ObservedWall) -> tuple[str, ...]:
    """Says what could not be judged."""
    evidence, inside = wall.evidence, wall.evidence.inside
    unknown = float((inside & (evidence.expected < 0.5) & ~evidence.seen).sum() / max(inside.sum(), 1))
    notes = []
    if not wall.beams.rays:
        notes.append("sensor positions are unknown: openings are gaps and recesses of the wall")
    if unknown > _UNSEEN_SHARE:
        notes.append(f"{unknown:.0%} of the facade was not seen; openings there are not looked for")
    return tuple(notes)
