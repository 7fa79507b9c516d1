"""Simulated and scanned houses for the benchmark of openings, and what is found on them."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from frontage.catalog import number_facade
from frontage.evaluation.result import FoundOpening
from frontage.evaluation.truth import Truth, read_truth
from frontage.facades import find_facades
from frontage.geometry.ring import box_sigmas
from frontage.model import Building, Elements, Facade, Failed, Opening, Provenance, Scan
from frontage.model.scan import merge_scans
from frontage.openings import OpeningOptions, find_openings
from frontage.openings.duplicates import without_duplicates
from frontage.simulate.optics.rays import Tracer
from frontage.simulate.scene import Scene
from frontage.simulate.sensors.instrument import ScannerSpec
from frontage.simulate.sensors.terrestrial import scan_stations
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from frontage.simulate.truth.tables import scene_table
from frontage.simulate.truth.visibility import ScannerView, visibility


@dataclass(frozen=True)
class Case:
    """A house and how it is scanned."""

    seed: int
    spacing: float
    stations: int
    occluded: bool


def case_of(number: int, spacing: float | None = None) -> Case:
    """Return the case of a number: 1, 2 or 4 cm; one to three stations; every third pair behind obstacles.

    `spacing` (m) replaces its spacing; house, stations and obstacles stay the same.
    """
    own = (0.02, 0.04, 0.01, 0.02, 0.04)[number % 5]
    stations = 1 + (number // 5) % 2 if own == 0.01 else (2, 1, 1, 3, 2)[number % 5]
    return Case(number, spacing or own, stations, (number // 2) % 3 == 1)


def scanned(case: Case) -> tuple[Scan, Scene, Truth, Any]:
    """Scan a house without colour and photos: its cloud, scene, truth, and the house of every point."""
    things = (2, 3, 4) if case.occluded else (0, 0, 0)
    spec = SceneSpec.model_validate(
        {"seed": case.seed, "houses": 1, "opposite": False, "setting": "terrace", "lamps": 0, "hedges": False}
        | dict(zip(("trees", "cars", "people"), things, strict=True))
    )
    scanner = ScannerSpec.model_validate(
        {"stations": case.stations, "spacing": case.spacing, "field": 170, "lowest": -20, "highest": 60}
        | {"subrays": 7, "colour": False}
    )
    scene = build_street(spec)
    stations = scan_stations(scene, scanner, case.seed)
    angles = np.radians([scanner.field, scanner.lowest, scanner.highest])
    eyes = [ScannerView(s.true.t, scene.local_from_street.R[:, 1], *map(float, angles)) for s in stations]
    seen = visibility(scene, Tracer(scene.mesh), eyes, np.empty((0, 3)), [])
    empty: dict[str, Any] = {"stations": [], "photos": [], "points": [], "drive": None}
    truth = read_truth(scene_table(scene, seen, {}) | empty)
    owner = np.array([s.house for s in scene.surfaces])
    surface = np.concatenate([s.surface for s in stations])
    house = np.where(surface >= 0, owner[surface], -1)
    return merge_scans([s.scan for s in stations]), scene, truth, house


def facades_of(scan: Scan, house: Any, scene: Scene) -> list[Facade]:
    """Find the street facades in the points of each house, as a run does."""
    out: list[Facade] = []
    for number, plan in enumerate(scene.houses):
        index = np.flatnonzero(house == number)
        found = find_facades(scan, Building(plan.id, index, plan.ground_z))
        out += [f for f in found if isinstance(f, Facade)]
    return out


def claim(facade: Facade, opening: Opening) -> FoundOpening:
    """Convert an opening to the form that the scorer reads."""
    ring = np.column_stack([opening.ring[:, 0], np.zeros(len(opening.ring)), opening.ring[:, 1]])
    sides = box_sigmas(opening.ring, opening.ring_covariance)
    errors = dict(zip(("left", "bottom", "right", "top"), sides, strict=True))
    depth = opening.depth
    if depth is not None:
        errors["depth"] = float(depth.sigma[0])
    return FoundOpening(
        opening.id,
        opening.kind,
        facade.frame.apply(ring),
        None if depth is None else float(depth.value),
        opening.shape,
        sigma=errors,
    )


def openings_of(
    facades: Sequence[tuple[Facade, float]], scan: Scan, method: str
) -> tuple[list[FoundOpening], list[str], int, float]:
    """All openings of the facades with their grounds' heights, the ids of the inferred ones, the number of
    facades that failed, and the processor seconds per million facade points.
    """
    found: list[FoundOpening] = []
    inferred: list[str] = []
    failed = 0
    judged: list[tuple[Facade, Elements]] = []
    start = time.process_time()
    for facade, ground in facades:
        foot = facade.frame.inverse.apply(np.array([[*facade.frame.t[:2], ground]]))
        options = OpeningOptions.model_validate({"method": method, "ground_z": float(foot[0, 2])})
        result = find_openings(facade, scan, options)
        failed += isinstance(result, Failed)
        judged += [] if isinstance(result, Failed) else [(facade, result.elements)]
    if method == "evidence":
        judged = without_duplicates(judged, scan)
    seconds = time.process_time() - start
    for facade, plain in judged:
        elements = replace(plain, openings=number_facade(facade.id, plain.openings))
        found += [claim(facade, o) for o in elements.openings]
        inferred += [o.id for o in elements.openings if o.provenance is Provenance.INFERRED]
    points = sum(len(f.support) for f, _ in facades)
    return found, inferred, failed, seconds / max(points, 1) * 1e6
