"""Ground plans of the buildings of a run: where an address that is given as a place belongs."""

import numpy as np
import shapely

from frontage.pipeline.store.store import Store


def ground_plans(store: Store) -> dict[str, shapely.Geometry]:
    """Return the ground plan of every building in world coordinates: footprint and feet of its facades."""
    facades: dict[str, list[shapely.Geometry]] = {}
    for name in store.facade_ids():
        facade = store.facade(name)
        (x0, z0, x1, _) = facade.extent
        feet = facade.frame.apply(np.array([[x0, 0.0, z0], [x1, 0.0, z0]]))
        line = shapely.LineString(facade.world.to_world(feet)[:, :2])
        facades.setdefault(facade.building, []).append(line)
    origin = store.world().origin.astype(np.float64)[:2]
    plans: dict[str, shapely.Geometry] = {}
    for record in store.building_records():
        parts = list(facades.get(record.id, []))
        if record.footprint is not None:
            parts.append(shapely.Polygon(record.footprint + origin))
        if parts:
            plans[record.id] = shapely.union_all(parts)
    return plans
