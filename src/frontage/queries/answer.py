"""What is known of one opening: its place in the world, size, standard errors, and photos that show it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from frontage.catalog.sightlines import Outline, PhotoView, ScannedSurfaces, photo_views, scanned_surfaces
from frontage.errors import FrontageError
from frontage.exports.survey import in_world
from frontage.geometry.arrays import Float
from frontage.geometry.ring import box_sigmas, ring_area, span_sigma
from frontage.io.photos.photoset import PhotoSet
from frontage.model import Bar, Elements, Facade, Opening
from frontage.pipeline.store.store import Store
from frontage.queries.pixels import FacadePixels
from frontage.report.layouts import layout_words

Point = tuple[float, float, float]
_SIDES = ("left", "bottom", "right", "top")


@dataclass(frozen=True)
class Place:
    """A facade, its building, the address that was asked for, and why this facade was chosen."""

    building: str
    address: str | None
    facade: str
    chosen: str


@dataclass(frozen=True)
class LocatedBar:
    """A window bar: the ends of its centre line in the world at the depth of the frame, m.

    sigma, sigma_width  standard errors m of position and width; None = not known
    """

    axis: str
    ends: tuple[Point, Point]
    width: float
    sigma: float | None
    sigma_width: float | None
    provenance: str


@dataclass(frozen=True)
class LocatedGlazing:
    """What divides a window.

    layout       in words: "2 mullions, 1 transom", "one pane", "not resolved"
    vertical, horizontal  numbers of bars; None = not resolved
    frame_width  m, None = not measured
    confidence   probability that the layout is the true one
    sources      photos that decided it, "scan" where scan points did
    note         why it was not resolved, or what to be careful about
    """

    layout: str
    vertical: int | None
    horizontal: int | None
    bars: tuple[LocatedBar, ...]
    frame_width: float | None
    confidence: float
    sources: tuple[str, ...]
    note: str


@dataclass(frozen=True)
class Located:
    """An opening in the world: positions in m in `crs`, corners from the lower left, seen counter-clockwise.

    id, kind, shape     "B02/F1/W3-2", "window", "rectangle"
    building, address   its building, and the address that was asked for
    facade              its facade; `chosen` says why this one
    floor, number, bay  the ground floor is 0; from the left on its floor; column over all floors
    outline, corners    on the wall; `outline_inside`, `corners_inside` at its depth, None = not measured
    center              of the box of its outline, on the wall
    width, height, area m, m, m2; depth m behind the wall, None = not measured
    sigma               standard errors m: left, right, bottom, top, width, height, depth, plane (of the wall
                        along its normal); None = not known
    glazing             its bars; None = they were not looked for
    pixels              (column0, row0, column1, row1) of its box in the ortho-image; None = there is none
    photos              those that show at least half of it, finest pixels first; `tested` says how
    """

    id: str
    kind: str
    shape: str
    building: str
    address: str | None
    facade: str
    chosen: str
    floor: int
    number: int
    bay: int
    crs: str | None
    outline: tuple[Point, ...]
    outline_inside: tuple[Point, ...] | None
    corners: tuple[Point, ...]
    corners_inside: tuple[Point, ...] | None
    center: Point
    width: float
    height: float
    area: float
    depth: float | None
    sigma: dict[str, float | None]
    provenance: str
    confidence: float
    glazing: LocatedGlazing | None
    pixels: tuple[float, float, float, float] | None
    photos: tuple[PhotoView, ...]
    tested: str
    notes: tuple[str, ...] = ()


class Witnesses:
    """What can show or hide an opening: the photos of a run, and the surfaces that were scanned.

    photos  with the way to their pixels; None = the run has none, or they cannot be read
    note    on photos that cannot be read
    """

    def __init__(self, store: Store) -> None:
        """Read the photos of a run folder, without their pixels."""
        self._store = store
        self.photos, self.note = _photos(store)

    @cached_property
    def scanned(self) -> ScannedSurfaces | None:
        """The surfaces that may hide an opening; None = unknown, or there is nothing to hide it from."""
        surroundings = self._store.surroundings() if self.photos and self.photos.photos else None
        return None if surroundings is None else scanned_surfaces(surroundings.xyz)

    def views(self, facade: Facade, outlines: Sequence[Outline]) -> list[tuple[PhotoView, ...]]:
        """Return the photos that show each outline on a facade, the finest pixels first."""
        return photo_views(facade, outlines, self.photos.photos if self.photos else (), self.scanned)

    @property
    def tested(self) -> str:
        """How the photos were selected; empty if there are none."""
        if not self.photos or not self.photos.photos:
            return ""
        seen = self.scanned is not None
        how = (
            ", at least half not hidden by what was scanned" if seen else "; what may hide it was not tested"
        )
        return f"before the wall, at least half inside the frame{how}"


def answer(store: Store, place: Place, elements: Elements, o: Opening) -> Located:
    """Return everything that is known of an opening of a facade."""
    return answers(store, place, elements, (o,), Witnesses(store))[0]


def answers(
    store: Store, place: Place, elements: Elements, openings: Sequence[Opening], witnesses: Witnesses
) -> list[Located]:
    """Return everything that is known of some openings of one facade."""
    facade = store.facade(place.facade)
    has_ortho = store.has(facade.id, "ortho")
    pixels = FacadePixels(store.facade_folder(facade.id)) if has_ortho else None
    views = witnesses.views(facade, [(o.ring, elements.wall_y(o)) for o in openings])
    return [
        _located(facade, place, o, elements.wall_y(o), pixels, own, witnesses)
        for o, own in zip(openings, views, strict=True)
    ]


def _located(
    facade: Facade,
    place: Place,
    o: Opening,
    wall_y: float,
    pixels: FacadePixels | None,
    views: tuple[PhotoView, ...],
    witnesses: Witnesses,
) -> Located:
    box = _box(o.ring)
    depth = None if o.depth is None else float(o.depth.value)
    inside = None if depth is None else wall_y + depth
    width, height = (float(v) for v in box[2] - box[0])
    return Located(
        id=o.id,
        kind=o.kind,
        shape=o.shape,
        building=place.building,
        address=place.address,
        facade=place.facade,
        chosen=place.chosen,
        floor=o.floor,
        number=o.number,
        bay=o.bay,
        crs=facade.world.crs,
        outline=_world(facade, o.ring, wall_y),
        outline_inside=None if inside is None else _world(facade, o.ring, inside),
        corners=_world(facade, box, wall_y),
        corners_inside=None if inside is None else _world(facade, box, inside),
        center=_world(facade, box.mean(0, keepdims=True), wall_y)[0],
        width=width,
        height=height,
        area=abs(ring_area(o.ring)),
        depth=depth,
        sigma=_sigmas(o, facade),
        provenance=str(o.provenance),
        confidence=float(o.confidence),
        glazing=_glazing(facade, o, wall_y),
        pixels=None if pixels is None else _pixels(pixels, facade, box, wall_y),
        photos=views,
        tested=witnesses.tested,
        notes=tuple(note for note in (_inferred(o), witnesses.note) if note),
    )


def _box(ring: Float) -> Float:
    """Return the corners (4, 2) of a ring's bounding box from the lower left, counter-clockwise."""
    (x0, z0), (x1, z1) = ring.min(0), ring.max(0)
    return np.array([[x0, z0], [x1, z0], [x1, z1], [x0, z1]])


def _world(facade: Facade, ring: Float, y: float) -> tuple[Point, ...]:
    """Return a ring (k, 2) m at depth y m in world coordinates, rounded to 0.1 mm."""
    rows = np.round(in_world(facade, ring, y), 4)
    return tuple((float(a), float(b), float(c)) for a, b, c in rows)


def _sigmas(o: Opening, facade: Facade) -> dict[str, float | None]:
    """Return the standard errors of borders, of width and height with their correlation, depth, and wall."""
    found = dict(zip(_SIDES, box_sigmas(o.ring, o.ring_covariance), strict=True))
    found |= {
        "width": span_sigma(o.ring, o.ring_covariance, 0),
        "height": span_sigma(o.ring, o.ring_covariance, 1),
    }
    found |= {"depth": np.inf if o.depth is None else o.depth.sigma[0], "plane": facade.sigma_plane}
    return {name: float(sigma) if np.isfinite(sigma) else None for name, sigma in found.items()}


def _glazing(facade: Facade, o: Opening, wall_y: float) -> LocatedGlazing | None:
    """Return what divides an opening; its bars lie at the depth of the frame, or else of the opening."""
    g = o.glazing
    if g is None:
        return None
    depth = g.depth or o.depth
    y = wall_y + (float(depth.value) if depth is not None else 0.0)
    upright, level = g.counts if g.resolved else (None, None)
    return LocatedGlazing(
        layout=layout_words(g),
        vertical=upright,
        horizontal=level,
        bars=tuple(_bar(facade, bar, y) for bar in g.bars),
        frame_width=None if g.frame_width is None else float(g.frame_width.value),
        confidence=float(g.confidence),
        sources=g.sources,
        note=g.note,
    )


def _bar(facade: Facade, bar: Bar, y: float) -> LocatedBar:
    line = np.array([(bar.position, end) for end in bar.extent])
    first, last = _world(facade, line if bar.axis == "vertical" else line[:, ::-1], y)
    sigma, width = (float(s) if np.isfinite(s) else None for s in (bar.sigma, bar.sigma_width))
    return LocatedBar(bar.axis, (first, last), float(bar.width), sigma, width, str(bar.provenance))


def _pixels(pixels: FacadePixels, facade: Facade, box: Float, y: float) -> tuple[float, float, float, float]:
    """Return the box in the ortho-image: column and row of its upper left and its lower right corner."""
    at, _ = pixels.pixels_from_world(np.array(_world(facade, box[[3, 1]], y)))
    (c0, r0), (c1, r1) = np.round(at, 2).tolist()
    return c0, r0, c1, r1


def _photos(store: Store) -> tuple[PhotoSet | None, str]:
    """Return the photos of a run, and a note if they cannot be read."""
    try:
        return store.photos(), ""
    except FrontageError as error:
        return None, f"the photos could not be read: {error}"


def _inferred(o: Opening) -> str:
    return "it was not seen: it is inferred from its neighbours" if str(o.provenance) == "inferred" else ""
