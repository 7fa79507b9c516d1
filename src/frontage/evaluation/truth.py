"""The truth of a scene as the scorers use it, in metres, local to the origin of the truth.

The file that it is read from is described in docs/reference/simulate.md, "Truth".
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from frontage.errors import InputError
from frontage.geometry.arrays import Float, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import WorldRef
from frontage.model.built import BuiltOpening, TrueBar, TrueLine

SCHEMA = 1


@dataclass(frozen=True, eq=False)
class TrueOpening(BuiltOpening):
    """A true opening; `visible` = share of it that each sensor sees, by the name of the sensor."""

    visible: Mapping[str, float]


@dataclass(frozen=True, eq=False)
class TrueProtrusion:
    """A true protrusion: ring (k, 2) m (x, z) where it meets the wall, y m of its near and far end."""

    id: str
    kind: str
    ring: Float
    y: tuple[float, float]

    def __post_init__(self) -> None:
        freeze(self, ring=((None, 2), np.float64))


@dataclass(frozen=True, eq=False)
class TrueFacade:
    """A true facade: frame (origin on the main plane), outline (k, 2) m (x, z), entry of its ortho-image."""

    id: str
    building: str
    frame: Rigid3
    outline: Float
    openings: tuple[TrueOpening, ...]
    visible: Mapping[str, float]
    ortho: Mapping[str, Any] | None
    protrusions: tuple[TrueProtrusion, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, outline=((None, 2), np.float64))


@dataclass(frozen=True, eq=False)
class TrueBuilding:
    """A true building: footprint (k, 2) m, ids of its facades, side of the street that it stands on."""

    id: str
    address: str
    side: int
    footprint: Float
    facades: tuple[str, ...]

    def __post_init__(self) -> None:
        freeze(self, footprint=((None, 2), np.float64))


@dataclass(frozen=True, eq=False)
class TruePose:
    """The pose of a sensor, true and as given; `name` of the photo, or of the scan as "file:number"."""

    name: str
    true: Rigid3
    given: Rigid3


@dataclass(frozen=True, eq=False)
class Truth:
    """The whole truth of a scene."""

    name: str
    world: WorldRef
    buildings: tuple[TrueBuilding, ...]
    facades: tuple[TrueFacade, ...]
    photos: tuple[TruePose, ...] = ()
    scans: tuple[TruePose, ...] = ()
    points: tuple[Mapping[str, Any], ...] = field(default=())

    def facade(self, number: str) -> TrueFacade:
        """Returns the facade with that id. Raises KeyError."""
        for facade in self.facades:
            if facade.id == number:
                return facade
        raise KeyError(number)


def best_share(visible: Mapping[str, float], sensors: Sequence[str] = ()) -> float:
    """Returns the largest share seen by any of `sensors`, or by any sensor of the scene if none is named.

    A truth without sensors counts everything as seen.
    """
    named = {k: v for k, v in visible.items() if not sensors or k in sensors}
    return max(named.values(), default=0.0) if visible else 1.0


def read_truth(table: Mapping[str, Any], name: str = "truth.json") -> Truth:
    """Reads the truth from the contents of a truth.json. Raises InputError when it is not one."""
    try:
        if table["schema"] != SCHEMA:
            raise InputError(f"{name}: schema {table['schema']} is not {SCHEMA}; simulate the scene again")
        world = WorldRef(np.array(table["origin"], np.int64), table["crs"])
        return Truth(
            str(table["name"]),
            world,
            tuple(_building(b, world) for b in table["buildings"]),
            tuple(_facade(f, world) for f in table["facades"]),
            tuple(_photo(p, world) for p in table["photos"]),
            tuple(_station(s, world) for s in table["stations"]),
            tuple(table["points"]),
        )
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"{name}: not the truth of a simulated scene ({type(error).__name__}: {error}); "
            f"give the folder that `frontage simulate` wrote"
        ) from None


def _building(b: Mapping[str, Any], world: WorldRef) -> TrueBuilding:
    footprint = np.array(b["footprint"], np.float64) - world.origin[:2]
    return TrueBuilding(b["id"], b["address"], int(b["side"]), footprint, tuple(b["facades"]))


def _facade(f: Mapping[str, Any], world: WorldRef) -> TrueFacade:
    axes = np.column_stack([f["frame"][axis] for axis in "xyz"])
    frame = Rigid3("local", "facade", axes, world.to_local(np.array(f["frame"]["origin"])))
    return TrueFacade(
        f["id"],
        f["building"],
        frame,
        np.array(f["outline"]),
        tuple(_opening(o) for o in f["openings"]),
        f["visible"],
        f.get("ortho"),
        tuple(_protrusion(p) for p in f.get("protrusions", ())),
    )


def _protrusion(p: Mapping[str, Any]) -> TrueProtrusion:
    near, far = (float(v) for v in p["y"])
    return TrueProtrusion(p["id"], p["kind"], np.array(p["outline"]), (near, far))


def _opening(o: Mapping[str, Any]) -> TrueOpening:
    bars = [
        TrueBar(axis, b["position"], (b["extent"][0], b["extent"][1]), b["width"], b.get("behind", 0.0))
        for axis in ("vertical", "horizontal")
        for b in o["bars"][axis]
    ]
    return TrueOpening(
        o["id"],
        o["kind"],
        o["shape"],
        np.array(o["outline"]),
        float(o["wall_y"]),
        float(o["depth"]),
        tuple(bars),
        o["shutters"],
        bool(o["glazed"]),
        o["visible"],
        glazing=o.get("glazing", "bars"),  # of scenes that were simulated before it was recorded
        lines=tuple(TrueLine(_ends(line["line"]), float(line["width"])) for line in o.get("lines", ())),
    )


def _ends(line: Sequence[Sequence[float]]) -> tuple[tuple[float, float], tuple[float, float]]:
    (xa, za), (xb, zb) = line
    return (float(xa), float(za)), (float(xb), float(zb))


def _photo(p: Mapping[str, Any], world: WorldRef) -> TruePose:
    poses = [
        Rigid3("local", "camera", np.array(p[key]["R"]).T, world.to_local(np.array(p[key]["center"])))
        for key in ("true", "given")
    ]
    return TruePose(p["name"], *poses)


def _station(s: Mapping[str, Any], world: WorldRef) -> TruePose:
    poses = [
        Rigid3("local", "scanner", np.array(s[key]["R"]), world.to_local(np.array(s[key]["position"])))
        for key in ("true", "given")
    ]
    return TruePose(f"{s['file']}:{s['number']}", *poses)
