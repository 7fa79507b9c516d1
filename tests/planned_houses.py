"""Houses of simulated streets as if they had been measured: facades and elements from their plans."""

import numpy as np
import shapely

from frontage.geometry.arrays import Float
from frontage.model import (
    Building,
    Elements,
    Estimate,
    Facade,
    Opening,
    Protrusion,
    ProtrusionKind,
    Provenance,
    WorldRef,
)
from frontage.simulate.scene import FacadePlan, House

_ROOFS = ("dormer", "chimney")  # stand on the roof, not on a facade


def building(house: House) -> Building:
    """The building of a house."""
    return Building(house.id, np.zeros(0, np.int64), house.ground_z, house.address)


def facade(plan: FacadePlan, world: WorldRef) -> Facade:
    """The facade of a plan, known to 0.1 mm."""
    pose = Estimate(plan.local_from_facade, np.eye(6) * 1e-8, 100.0)
    none = np.zeros(0, np.int64)
    return Facade(
        plan.id, plan.id.split("/")[0], pose, world, plan.outline, (), none, none, 0.0, 0.02, 1.0, ""
    )


def elements(plan: FacadePlan) -> Elements:
    """The openings and protrusions of a plan."""
    sure = np.eye(1) * 1e-6
    oriels = {p.y_range[0]: p.id for p in plan.protrusions if p.kind == "oriel"}
    openings = tuple(
        Opening(
            o.id, o.kind, o.ring, np.eye(2 * len(o.ring)) * 1e-6, Estimate(o.depth, sure, 9.0), o.shape,
            Provenance.MEASURED, 9.0, 1.0, o.floor, o.bay, on=oriels.get(o.wall_y, ""),
        )
        for o in plan.openings
    )  # fmt: skip
    protrusions = tuple(
        Protrusion(
            p.id,
            p.kind if p.kind in set(ProtrusionKind) else ProtrusionKind.OTHER,  # such as a string course
            ring,
            0.01,
            Estimate(p.y_range[0], sure, 9.0),
            Provenance.MEASURED,
            1.0,
        )
        for p in plan.protrusions
        if p.kind not in _ROOFS and len(ring := _above(p.ring, float(plan.outline[:, 1].min())))
    )
    return Elements(plan.id, openings, protrusions)


def _above(ring: Float, foot: float) -> Float:
    """A ring without what lies below the ground, as that of a plinth; empty where nothing is left."""
    rest = shapely.Polygon(ring).intersection(shapely.box(-1e4, foot, 1e4, 1e4))
    return np.asarray(rest.exterior.coords)[:-1] if rest.geom_type == "Polygon" and rest.area else ring[:0]
