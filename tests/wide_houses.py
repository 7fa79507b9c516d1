"""One wide house whose front is not flat, drawn and scanned by `frontage.simulate`: what must not be cut.

The house is drawn as three pieces of one style, side by side. A street of the simulator cannot ask for
that, since houses with a style in common stand in one line there; so the pieces are placed here.
"""

from typing import Any, Literal

import numpy as np
import shapely

from frontage.geometry.rigid import Rigid3
from frontage.model import WorldRef
from frontage.simulate.houses.draft import draft_house
from frontage.simulate.houses.house import build_house
from frontage.simulate.houses.housespec import HouseSpec
from frontage.simulate.meshing import MeshBuilder, Pen
from frontage.simulate.scene import Scene
from frontage.simulate.street.ground import StreetProfile, draw_ground
from scanned_streets import ScannedStreet, scan_scene

Kind = Literal["plain", "risalit", "attic", "recess", "oriel"]
KINDS: tuple[Kind, ...] = ("plain", "risalit", "attic", "recess", "oriel")
_FORWARD_M = {"risalit": 0.5, "attic": 0.5, "recess": -0.4}  # of the middle, towards the street
_WING_M, _MIDDLE_M, _FLOORS = 10.0, 8.0, 3
_STREET = StreetProfile(width=14.0, pavement=2.5, slope=0.0)
_BEYOND_M = 30.0  # of street before and after the house


def wide_house(kind: Kind, seed: int, spacing: float = 0.08) -> ScannedStreet:
    """Scans a house 28 m wide: wings of 10 m beside a middle of 8 m. A `risalit` (avant-corps) stands 0.5 m
    forward, an `attic` is a risalit one storey higher, a `recess` lies 0.4 m back, an `oriel` hangs on the
    upper storeys of a flat front.
    """
    wing = {
        "lean": 0.0,
        "floors": _FLOORS,
        "roof": "gable",
        "balconies": False,
        "oriel": False,
        "shop": False,
    }
    middle: dict[str, Any] = wing | {"oriel": kind == "oriel", "floors": _FLOORS + (kind == "attic")}
    builder, houses, plots, s = MeshBuilder(), [], [], 0.0
    for k, (table, width) in enumerate(((wing, _WING_M), (middle, _MIDDLE_M), (wing, _WING_M))):
        d = -_FORWARD_M.get(kind, 0.0) if k == 1 else 0.0
        draft = draft_house(HouseSpec.model_validate(table), (seed,), 0.0, False, width)
        pen = Pen(builder, Rigid3("local", "house", np.eye(3), np.array([s, d, 0.0])), f"P{k}", house=k)
        houses.append(build_house(pen, draft, f"P{k}", address="1 Long Street", side=0, twin_of=None)[0])
        plots.append(shapely.box(s, d, s + width, d + draft.depth))
        s += width
    ground, rng = Pen(builder, Rigid3.identity("local", "street")), np.random.default_rng(seed)
    draw_ground(ground, _STREET, (-_BEYOND_M, s + _BEYOND_M), plots, rng)
    scene = Scene(
        kind, seed, WorldRef(np.zeros(3, np.int64)), Rigid3.identity("local", "street"), builder.mesh(),
        tuple(builder.surfaces), tuple(builder.materials), tuple(houses), _STREET.centre_line(0.0, s),
    )  # fmt: skip
    return scan_scene(scene, spacing)
