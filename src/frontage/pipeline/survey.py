"""What a run has measured, gathered from its folder for tables, drawings and questions."""

from collections.abc import Sequence

import numpy as np

from frontage.catalog.addressbook import known_addresses
from frontage.errors import FrontageError, InputError
from frontage.exports.survey import Front, Survey, SurveyedBuilding
from frontage.geometry.arrays import Float
from frontage.geometry.ring import convex_ring
from frontage.model import Photo, WorldRef
from frontage.pipeline.gaps import gaps, warnings_of
from frontage.pipeline.groundplans import ground_plans
from frontage.pipeline.store.records import BuildingRecord
from frontage.pipeline.store.store import Store

_NAMELESS = "No building has an address: the city model gives none, and the project file has no [addresses]."


def gather_survey(store: Store) -> Survey:
    """Return what a run has measured. Files that are damaged raise FileError; what is missing is told."""
    world, warned = store.world(), warnings_of(store)
    addresses = addresses_of(store)
    buildings = tuple(
        _building(store, record, world, addresses[record.id], warned) for record in store.building_records()
    )
    photos, unseen = _photos(store)
    nameless = () if any(addresses.values()) else (_NAMELESS,)
    return Survey(world, buildings, photos, _stations(store, world), (*unseen, *gaps(store), *nameless))


def gather_building(store: Store, building: str, address: str | None) -> SurveyedBuilding:
    """Return what a run has measured of one building. Raises InputError for an unknown id, FileError.

    address  its own, of `addresses_of`, which reads the whole run and is asked once for all buildings
    """
    record = next((r for r in store.building_records() if r.id == building), None)
    if record is None:
        raise InputError(f"no building {building!r} in {store.out}")
    return _building(store, record, store.world(), address, warnings_of(store))


def heights_of(world: WorldRef) -> str:
    """Say what the heights of a run refer to."""
    from frontage.io.crs import parse_crs, vertical

    upright = None if world.crs is None else vertical(parse_crs(world.crs))
    where = f"the zero of {world.crs}" if world.crs else "the zero of the scans"
    return f"above {upright.name}" if upright is not None else f"above {where}, which names no height datum"


def addresses_of(store: Store) -> dict[str, str | None]:
    """Return the first address of every building, with those that the project file gives."""
    records, book = store.building_records(), store.project().addresses
    plans = ground_plans(store) if any(entry.at for entry in book) else {}
    known, _ = known_addresses({r.id: r.address for r in records}, plans, book)
    return {r.id: next(iter(known.get(r.id, ())), None) for r in records}


def _building(
    store: Store, record: BuildingRecord, world: WorldRef, address: str | None, warned: dict[str, list[str]]
) -> SurveyedBuilding:
    fronts: tuple[Front, ...] = tuple(
        (store.facade(name), store.elements(name)) for name in store.facades_of(record.id)
    )
    ground = float(record.ground_z + world.origin[2])
    plan, source = _plan(store, record, world)
    return SurveyedBuilding(
        record.id,
        address,
        ground if np.isfinite(ground) else None,
        plan,
        source,
        fronts,
        tuple(warned.get(record.id, ())),
    )


def _plan(store: Store, record: BuildingRecord, world: WorldRef) -> tuple[Float | None, str]:
    """Return the footprint of a building in the world, else the hull of its points, and which it is."""
    origin = world.origin[:2].astype(np.float64)
    if record.footprint is not None:
        return record.footprint + origin, "footprint"
    cloud, found = store.surveyed(record.id)
    try:
        return convex_ring(cloud.xyz[found.index][:, :2]) + origin, "hull of its points"
    except ValueError:
        return None, ""


def _photos(store: Store) -> tuple[tuple[Photo, ...], list[str]]:
    """Return the oriented photos, and what is to be said of the others."""
    try:
        found = store.photos()
    except FrontageError as error:
        return (), [f"The photos could not be read and are left out: {error}"]
    if found is None:
        return (), ["The run has no photos: their layer is empty."]
    oriented = tuple(p for p in found.photos if p.local_from_camera is not None)
    lost = [p.id for p in found.photos if p.local_from_camera is None]
    return oriented, [f"Photos without a pose are left out: {_listed(lost)}."] if lost else []


def _stations(store: Store, world: WorldRef) -> Float:
    """Return where the scanner stood (s, 3) m world, of the points that the run works with."""
    scan = store.surroundings()
    if scan is None or not len(scan.origins):
        return np.empty((0, 3))
    used = np.unique(scan.origin_index[scan.origin_index >= 0])
    return np.asarray(world.to_world(scan.origins[used]), np.float64)


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names)
