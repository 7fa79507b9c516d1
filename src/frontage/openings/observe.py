"""What the laser beams say about one wall: the first step of finding openings (paper B, section 3.2.1)."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from frontage.geometry.arrays import Bool
from frontage.model.estimate import Failed
from frontage.model.facade import Facade
from frontage.model.scan import Scan
from frontage.openings.blind import BlindNiche, find_blind_niches, without_blind_niches
from frontage.openings.layout.bands import find_posts
from frontage.openings.layout.densities import wider_cells
from frontage.openings.layout.joinery import joinery_planes
from frontage.openings.layout.posts import Post, with_posts
from frontage.openings.layout.strips import find_strips
from frontage.openings.options import OpeningOptions
from frontage.openings.wall.beams import Beams, sort_beams
from frontage.openings.wall.evidence import Evidence, weigh
from frontage.openings.wall.innerface import InnerFace, find_inner_face, with_inner_face
from frontage.openings.wall.noreturn import with_lost_beams
from frontage.openings.wall.panels import without_panels
from frontage.openings.wall.recesses import with_recesses
from frontage.openings.wall.slats import find_slats, with_slats

_FEWEST_POINTS = 200  # fewer points tell neither the density nor the noise of a wall
# sides of the cells of three rasters, as multiples of the side that the spacing asks for
_SIDES = (1.0, 1.1, 1.2)


@dataclass(frozen=True, eq=False)
class ObservedWall:
    """The evidence that the openings of a wall are found from.

    facade    the facade, whose support leaves out the inner faces of its wall
    beams     the beams, sorted into those that ended on the wall, went through it or were stopped before it
    evidence  log-likelihood ratio of open against solid for every cell of the wall
    rasters   the same on three rasters, so that the place of the cells does not decide what shows, and again
              on ever wider cells for parts of the wall that are scanned ever more sparsely
    posts     posts of joinery between the windows of a band, which count as wall, and narrow strips of wall
    ground    m, height z of the ground at the wall in the facade frame
    blind     niches that count as wall
    """

    facade: Facade
    beams: Beams
    evidence: Evidence
    rasters: Sequence[Sequence[Evidence]]
    posts: tuple[Post, ...]
    ground: float
    blind: tuple[BlindNiche, ...] = ()


def observe_wall(facade: Facade, scan: Scan, options: OpeningOptions) -> ObservedWall | Failed:
    """Sorts the beams of a facade's working cloud and weighs, cell by cell, whether the wall is open there.

    The inner faces of scanned rooms tell where masonry is. Recesses larger than any opening lie at their own
    depth. Shallow panels count as wall, and so do blind niches, and posts between the windows of a band.
    Narrow strips of wall part openings. Returns `Failed` F401 when the facade has too few points, and F402
    when hardly any of them lie on the wall.
    """
    if len(facade.support) < _FEWEST_POINTS:
        return Failed(
            "F401",
            f"facade {facade.id} has {len(facade.support)} points, too few to tell openings from gaps",
            "openings need about ten points across: scan closer or more densely",
        )
    beams = sort_beams(facade, scan)
    if len(beams.solid) < _FEWEST_POINTS // 2:
        return Failed(
            "F402",
            f"facade {facade.id} shows hardly any wall, so openings cannot be told from it",
            "check the facade's plane, or scan it from the street",
        )
    ground = ground_height(facade, options)
    evidence = _evidence(facade, beams, scan=scan, ground=ground)
    inner = find_inner_face(facade, beams, evidence)
    again = partial(_evidence, scan=scan, ground=ground, inside=evidence.inside, inner=inner)
    if inner is not None:
        facade = inner.facade
        beams = sort_beams(facade, scan)
        evidence = again(facade, beams)
    recessed = with_recesses(beams, evidence, facade)
    if recessed is not None:
        beams = sort_beams(facade, scan, recessed)
        evidence = again(facade, beams)
    blind = find_blind_niches(beams, evidence, facade, scan, ground)
    if blind:
        again = partial(again, blind=blind)
        evidence = again(facade, beams)
    first = partial(again, facade, inside=None)
    finest = [evidence, *(first(beams, scale=scale) for scale in _SIDES[1:])]
    planes = list(joinery_planes(beams, evidence))
    strips = find_strips(beams, planes, finest)
    posts = find_posts(planes, finest, ground)
    beams, finest = _with_posts_and_slats(beams, posts, finest, partial(again, facade))
    wider = [[first(beams, scale=wide * side) for side in _SIDES] for wide in wider_cells(finest[0])]
    return ObservedWall(facade, beams, finest[0], [finest, *wider], posts + strips, ground, blind)


def _with_posts_and_slats(
    beams: Beams, posts: Sequence[Post], rasters: list[Evidence], weighed: Callable[..., Evidence]
) -> tuple[Beams, list[Evidence]]:
    """Returns the beams, with posts and slats as wall, and the evidence of all rasters for these beams.

    `weighed` weighs the evidence of a raster. Slats show only when posts are wall, and the finest raster
    tells them.
    """
    first = rasters[0]
    if posts:
        beams = with_posts(beams, posts)
        first = weighed(beams)
    slats = find_slats(first)
    if slats:
        beams = with_slats(beams, slats)
        first = weighed(beams)
    if not (posts or slats):
        return beams, rasters
    others = zip(rasters[1:], _SIDES[1:], strict=True)
    return beams, [first, *(weighed(beams, inside=old.inside, scale=side) for old, side in others)]


def ground_height(facade: Facade, options: OpeningOptions) -> float:
    """Returns the height z m of the ground in the facade frame: the option, else the foot of the facade."""
    return facade.extent[1] if options.ground_z is None else options.ground_z


def _evidence(
    facade: Facade,
    beams: Beams,
    *,
    scan: Scan,
    ground: float,
    inside: Bool | None = None,
    inner: InnerFace | None = None,
    blind: Sequence[BlindNiche] = (),
    scale: float = 1.0,
) -> Evidence:
    """Weighs hits, passes, missing beams, beams without return, panels, niches and the wall's inner face.

    `inside` (h, w) are the cells within the facade's outline where they are known; cells are `scale` times as
    wide as the spacing asks for.
    """
    evidence = with_lost_beams(weigh(facade, beams, inside, scale), facade, scan, beams)
    evidence = without_blind_niches(without_panels(evidence, beams, ground), beams, blind)
    return evidence if inner is None else with_inner_face(evidence, inner.places)
