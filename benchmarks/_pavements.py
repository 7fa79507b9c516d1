"""Walkers near the wall, on narrow pavements: how much of a facade's picture is drawn on them.

The scan saw them, so nothing of them belongs to the facade. A pixel is drawn on something if the surface that
it is drawn on stands before the true one, and nothing of the facade stands out there. What does (balconies,
cornices) must stay, and so must the wall that some photo sees.
"""

from typing import Any

import cv2
import numpy as np

from _common import table
from _mosaics import SCAN_M, Street, front, seen_wall
from _mosaicscore import covered
from frontage.geometry.arrays import Array, Float
from frontage.model import NOT_SEEN, OrthoImage
from frontage.model.scan import merge_scans
from frontage.ortho import OrthoOptions, make_ortho
from frontage.simulate.sensors.cameras import CameraSpec
from frontage.simulate.sensors.instrument import ScannerSpec
from frontage.simulate.sensors.photograph import iter_photographs
from frontage.simulate.sensors.terrestrial import scan_stations
from frontage.simulate.spec import SceneSpec
from frontage.simulate.street.build import build_street
from frontage.simulate.truth.ortho import true_ortho

SEEDS = (1, 2, 3, 4, 5, 6, 7)
GSD = 0.02
BEFORE_M = 0.2  # a surface so far before the true one is another thing
BEHIND_M = 0.15  # a surface so far behind the true one misses something of the facade
STANDS_OUT_M = 0.25  # of the facade: balconies, oriels, deep cornices
NEAR_M = 1.5  # walkers nearer than this are near the wall


def narrow_street(seed: int) -> Street:
    """Scan and photograph two houses on a street 9 m wide with seven walkers, who stand still."""
    given: dict[str, Any] = {"seed": seed, "houses": 2, "opposite": False, "setting": "terrace", "lamps": 1,
                             "hedges": False, "street_width": 9, "slope": 0, "trees": 1, "cars": 1,
                             "people": 7}  # fmt: skip
    light = {"overcast": 0.6, "sun_elevation": 42, "sun_azimuth": 35}
    camera = CameraSpec.model_validate(
        {"width": 1200, "height": 1200, "focal": 22, "most": 4, "spacing": 3.0, "samples": 1,
         "pitches": (12.0,), "light": light}
    )  # fmt: skip
    scanner = ScannerSpec.model_validate(
        {"stations": 2, "spacing": SCAN_M, "field": 170, "lowest": -25, "highest": 60, "subrays": 1}
    )
    scene = build_street(SceneSpec.model_validate(given))
    scan = merge_scans([s.scan for s in scan_stations(scene, scanner, seed)])
    shots = list(iter_photographs(scene, camera, seed))
    photos, images = tuple(s.photo for s in shots), {s.photo.id: s.image for s in shots}
    return Street(scene, (scene,) * len(shots), scan, photos, images)


def walkers(quick: bool) -> None:
    """Print what is drawn on walkers, and what is missing of the facade, of every facade."""
    rows = [_row(seed, house) for seed in SEEDS[: 1 if quick else None] for house in _houses(seed)]
    head = ["street", "house", "nearest walker", "on something", "standing out, missed", "wall painted"]
    table(f"Walkers on pavements of streets 9 m wide, at {GSD * 100:g} cm", head, rows)


def _houses(seed: int) -> list[tuple[Street, int]]:
    street = narrow_street(seed)
    return [(street, house) for house in range(len(street.scene.houses))]


def _row(seed: int, of: tuple[Street, int]) -> list[str]:
    street, house = of
    facade = front(street, house)
    ortho = make_ortho(facade, street.scan, street.photos, street.images.__getitem__,
                       options=OrthoOptions(gsd=GSD))  # fmt: skip
    assert isinstance(ortho, OrthoImage), ortho
    truth, true_y = seen_wall(street, house, ortho), _true_depth(street, house, ortho)
    known = (ortho.source != 0) & (ortho.source != NOT_SEEN) & (truth.wall | truth.glass)
    y = np.nan_to_num(ortho.depth)
    out = (truth.wall | truth.glass) & (true_y < -STANDS_OUT_M)
    on_thing = known & ~out & (y < true_y - BEFORE_M) & (y < -BEFORE_M)
    missed = known & out & (y > true_y + BEHIND_M)
    people = [-float(o.centre[1]) for o in ortho.occluders if o.kind == "person"]
    near = min((away for away in people if away < NEAR_M), default=None)
    return [
        str(seed),
        str(house),
        "-" if near is None else f"{near:.2f} m",
        f"{100 * on_thing.sum() / max(known.sum(), 1):.3f} %",
        f"{100 * missed.sum() / max(out.sum(), 1):.2f} %",
        f"{100 * covered(known, truth.wall, truth):.1f} %",
    ]


def _true_depth(street: Street, house: int, ortho: OrthoImage) -> Float:
    """Return the true y (h, w) m of the facade at the pixels of an ortho-image."""
    true = true_ortho(street.scene, house, 0, ortho.gsd)
    h, w = ortho.pixels.shape[:2]
    x = ortho.corner[0] + (np.arange(w) + 0.5) * ortho.gsd
    z = ortho.corner[1] - (np.arange(h) + 0.5) * ortho.gsd
    column = ((x - true.corner[0]) / true.gsd - 0.5).astype(np.float32)
    row = ((true.corner[1] - z) / true.gsd - 0.5).astype(np.float32)
    u, v = np.meshgrid(column, row)
    depth: Array = cv2.remap(true.depth.astype(np.float32), u, v, cv2.INTER_NEAREST, borderValue=np.nan)
    return depth
