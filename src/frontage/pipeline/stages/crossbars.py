"""The stage `crossbars`: which photos show every opening, and the bars of its windows (paper B, section 3.3).

It writes `openings.json`, what users script against: what the stage `openings` found with everything that the
photos add to it. A facade on which a step fails keeps what the steps before it found.
"""

from collections import defaultdict
from dataclasses import dataclass

from frontage.catalog.sightlines import ScannedSurfaces, name_photos, scanned_surfaces
from frontage.crossbars import FoundBars
from frontage.crossbars.find import find_bars
from frontage.errors import FrontageError
from frontage.geometry.arrays import Array
from frontage.io.photos.photoset import PhotoSet
from frontage.model import Elements, Facade, Failed, Photo, Scan
from frontage.pipeline.notes import listed, shared_notes
from frontage.pipeline.stage import After, Job, Stage, attempt, per_building, warned
from frontage.pipeline.store.results import CrossbarsItemResult, StageResult, StageWarning, WindowPicture
from frontage.report.windows import WindowTile, window_tile

_REASONS = 4  # for windows that were not resolved, which a note tells


@dataclass(frozen=True, kw_only=True)
class CrossbarsResult(StageResult):
    """What was found in the whole run; `items` counts windows whose layout was decided.

    windows  that were looked at
    bars     in the windows whose layout was decided
    """

    windows: int
    bars: int


@dataclass(frozen=True, eq=False)
class Photos:
    """The photos of a run, or why they could not be read."""

    found: PhotoSet | None = None
    note: str = ""

    @property
    def oriented(self) -> tuple[Photo, ...]:
        """The photos that have a pose."""
        photos = self.found.photos if self.found else ()
        return tuple(photo for photo in photos if photo.local_from_camera is not None)

    def image(self, name: str) -> Array:
        """Decode a photo. Raises FileError."""
        assert self.found is not None  # openings name photos of this set only
        return self.found.image(name)


@dataclass(frozen=True, eq=False)
class JudgedBuilding:
    """The judged facades of a building, its points, and the surfaces that may hide it from the photos."""

    facades: tuple[tuple[Facade, Elements], ...]
    scan: Scan | None
    scanned: ScannedSurfaces | None


@dataclass(frozen=True, eq=False)
class BarredFacade:
    """A facade with all that is known of its openings, pictures of its windows, and what went wrong."""

    facade: Facade
    elements: Elements
    tiles: tuple[WindowTile, ...] = ()
    notes: tuple[str, ...] = ()
    failed: Failed | None = None


def tasks(job: Job) -> dict[str, Photos]:
    """Return every building with the photos of the run."""
    source, photos = job.project.photos, Photos()
    if source is not None:
        try:
            photos = Photos(job.store.photos_of(source))
        except FrontageError as error:
            photos = Photos(note=f"the photos could not be read, openings and bars are without them: {error}")
    return dict.fromkeys(per_building(job), photos)


def load(job: Job) -> JudgedBuilding:
    """Read what was found on the facades of a building, its points, and what may hide it from the photos."""
    store, photos = job.store, job.payload
    names = store.facades_of(job.item, "openings")
    facades = tuple((store.facade(name), store.found_elements(name)) for name in names)
    if not any(elements.openings for _, elements in facades):
        return JudgedBuilding(facades, None, None)
    surroundings = store.surroundings() if photos.oriented else None
    scanned = None if surroundings is None else scanned_surfaces(surroundings.xyz)
    return JudgedBuilding(facades, store.working_cloud(job.item), scanned)


def work(job: Job, judged: JudgedBuilding) -> list[BarredFacade]:
    """Find the bars facade by facade; draw at once what they were found from, so that it need not be kept."""
    return [_barred(job, judged, facade, elements) for facade, elements in judged.facades]


def save(job: Job, barred: list[BarredFacade]) -> CrossbarsItemResult:
    """Write `openings.json` and the pictures of the windows."""
    warnings, pictures = list[StageWarning](), dict[str, tuple[WindowPicture, ...]]()
    unresolved: dict[str, list[str]] = defaultdict(list)
    for one in barred:
        name, folder = one.facade.id, job.store.facade_folder(one.facade.id)
        job.store.save_elements(one.facade, one.elements)
        warnings += warned(name, one.failed)
        for tile in one.tiles:
            job.store.put(folder / tile.file, tile.jpeg)
        pictures[name] = tuple(WindowPicture(tile.opening, tile.file, tile.panels) for tile in one.tiles)
        for o in one.elements.openings:
            if o.glazing is not None and not o.glazing.resolved:
                unresolved[o.glazing.note].append(o.id)
    openings = [o for one in barred for o in one.elements.openings]
    return CrossbarsItemResult(
        facades=tuple(one.facade.id for one in barred),
        warnings=tuple(warnings),
        notes={one.facade.id: one.notes for one in barred if one.notes},
        resolved=tuple(o.id for o in openings if o.glazing is not None and o.glazing.resolved),
        bars=sum(len(o.bars) for o in openings),
        unresolved={reason: tuple(ids) for reason, ids in unresolved.items()},
        pictures=pictures,
    )


def join(job: Job, parts: list[CrossbarsItemResult]) -> CrossbarsResult:
    """Count what was found; tell what was not resolved, and why the photos could not be read."""
    unresolved: dict[str, list[str]] = defaultdict(list)
    for part in parts:
        for reason, ids in part.unresolved.items():
            unresolved[reason] += ids
    resolved = sum(len(part.resolved) for part in parts)
    windows = resolved + sum(map(len, unresolved.values()))
    unread = dict.fromkeys(photos.note for photos in job.payload.values() if photos.note)
    told = [unresolved_note(unresolved, windows)] if unresolved else []
    return CrossbarsResult(
        items=resolved,
        windows=windows,
        bars=sum(part.bars for part in parts),
        warnings=tuple(w for part in parts for w in part.warnings),
        notes=(*unread, *told, *shared_notes(parts, "window bars")),
    )


def unresolved_note(unresolved: dict[str, list[str]], windows: int) -> str:
    """Return one sentence on the windows whose layout was not decided, with the most frequent reasons."""
    ordered = sorted(unresolved.items(), key=lambda entry: -len(entry[1]))
    reasons = [f"{len(ids)} x {reason or 'no reason known'} ({listed(ids)})" for reason, ids in ordered]
    count, more = sum(map(len, unresolved.values())), len(ordered) - _REASONS
    rest = [f"{sum(len(ids) for _, ids in ordered[_REASONS:])} for other reasons"] if more > 0 else []
    told = "; ".join([*reasons[:_REASONS], *rest])
    return f"window bars: the layout of {count} of {windows} windows was not decided: {told}"


def _barred(job: Job, judged: JudgedBuilding, facade: Facade, elements: Elements) -> BarredFacade:
    photos: Photos = job.payload
    seen = attempt(facade.id, lambda: name_photos(facade, elements, photos.oriented, judged.scanned))
    if isinstance(seen, Failed):
        return BarredFacade(facade, elements, failed=seen)
    named = {name for o in seen.openings for name in o.photos}
    shown = [photo for photo in photos.oriented if photo.id in named]
    options, image = job.project.crossbars, photos.image
    found = attempt(facade.id, lambda: find_bars(facade, seen, shown, image, judged.scan, options))
    if isinstance(found, Failed):
        return BarredFacade(facade, seen, failed=found)
    tiles = attempt(facade.id, lambda: _tiles(found))
    if isinstance(tiles, Failed):
        return BarredFacade(facade, found.elements, notes=found.notes, failed=tiles)
    return BarredFacade(facade, found.elements, tiles, found.notes)


def _tiles(found: FoundBars) -> tuple[WindowTile, ...]:
    """Draw the windows that anything shows."""
    openings = {o.id: o for o in found.elements.openings}
    tiles = (window_tile(window, openings[window.opening].ring) for window in found.windows)
    return tuple(tile for tile in tiles if tile is not None)


STAGE = Stage(
    name="crossbars",
    after=("facades", "openings", After("orient")),
    tasks=tasks,
    load=load,
    work=work,
    save=save,
    join=join,
    part=CrossbarsItemResult,
    result=CrossbarsResult,
    commands=("openings",),
    rooms=("catalog", "crossbars", "report"),
    inputs=("photos",),
    options=("photos", "crossbars"),
)
