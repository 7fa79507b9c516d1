"""A facade as JSON values: the code that `facade.json` and the sidecar `ortho.json` share.

The two files name a few things differently (`facade.json` keeps the pose in local coordinates, the sidecar in
world coordinates), but every value is converted here, once for both. Numbers keep all their digits. JSON has
no infinity and no NaN, so null stands for an unknown number.
"""

import math
from typing import Any

import numpy as np

from frontage.geometry.arrays import Int
from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Facade, Layer, Provenance, WorldRef

Json = dict[str, Any]
_FAR_M = 1e7  # no local coordinate is as large


def facade_to_json(facade: Facade) -> Json:
    """The contents of `facade.json`: everything except the point indices.

    The pose and the outline are in local coordinates (m), the rotation is a matrix, sigmas are in m.
    """
    pose, about = facade.local_from_facade, facade_facts(facade)
    return {
        "id": facade.id,
        "building": facade.building,
        "world": world_to_json(facade.world),
        "local_from_facade": {
            "R": pose.value.R.tolist(),
            "t": pose.value.t.tolist(),
            "covariance": about["covariance"],
            "dof": about["dof"],
            "provenance": about["provenance"],
        },
        "outline": about["outline"],
        "layers": about["layers"],
        "roughness": facade.roughness,
        "spacing": facade.spacing,
        "coverage": facade.coverage,
        "sigma_plane": facade.sigma_plane,
        "oriented_by": facade.oriented_by,
        "curvature": about["curvature"],
        "notes": about["notes"],
    }


def facade_from_json(record: Json, support: Int, inliers: Int) -> Facade:
    """The inverse of `facade_to_json`; `support` and `inliers` (n,) int64 index the building's scan.

    Raises KeyError, TypeError, IndexError or ValueError when the record is incomplete or malformed.
    """
    pose = record["local_from_facade"]
    return facade_from_facts(
        {**record, **{name: pose[name] for name in ("covariance", "dof", "provenance")}},
        Rigid3("local", "facade", np.array(pose["R"]), np.array(pose["t"])),
        world_from_json(record["world"]),
        support,
        inliers,
    )


def facade_facts(facade: Facade) -> Json:
    """The values that both files hold, under the keys that `facade_from_facts` reads."""
    pose = facade.local_from_facade
    return {
        "id": facade.id,
        "building": facade.building,
        "covariance": pose.covariance.tolist(),
        "dof": finite_or_none(pose.dof),
        "provenance": str(pose.provenance),
        "outline": facade.outline.tolist(),
        "layers": [layer_to_json(layer) for layer in facade.layers],
        "roughness": finite_or_none(facade.roughness),
        "spacing": finite_or_none(facade.spacing),
        "coverage": finite_or_none(facade.coverage),
        "sigma_plane": finite_or_none(facade.sigma_plane),
        "oriented_by": facade.oriented_by,
        "curvature": [finite_or_none(v) for v in facade.curvature],
        "notes": list(facade.notes),
    }


def facade_from_facts(facts: Json, pose: Rigid3, world: WorldRef, support: Int, inliers: Int) -> Facade:
    """A facade from the values of `facade_facts`, its pose (local from facade, m) and its world.

    Raises KeyError, TypeError, IndexError or ValueError when the values are incomplete or malformed.
    """
    sagitta, sigma = facts["curvature"][:2]
    outline = np.array(facts["outline"], np.float64)
    for name, values in (("pose", pose.t), ("outline", outline)):
        if not (np.abs(values) < _FAR_M).all():  # NaN is not, either
            raise ValueError(f"the {name} of the facade lies beyond {_FAR_M:g} m")
    return Facade(
        id=facts["id"],
        building=facts["building"],
        local_from_facade=Estimate(
            pose,
            np.array(facts["covariance"], np.float64),
            number_or_infinity(facts["dof"]),
            Provenance(facts["provenance"]),
        ),
        world=world,
        outline=outline,
        layers=tuple(layer_from_json(layer) for layer in facts["layers"]),
        support=support,
        inliers=inliers,
        roughness=number_or_infinity(facts["roughness"]),
        spacing=number_or_infinity(facts["spacing"]),
        coverage=number_or_infinity(facts["coverage"]),
        oriented_by=facts["oriented_by"],
        curvature=(number_or_infinity(sagitta), number_or_infinity(sigma)),
        notes=tuple(facts["notes"]),
    )


def layer_to_json(layer: Layer) -> Json:
    """A surface parallel to the facade: y and sigma in m, area in m2, outline [[x, z], ...] in m."""
    return {
        "y": layer.y,
        "sigma": finite_or_none(layer.sigma),
        "area": layer.area,
        "outline": layer.outline.tolist(),
    }


def layer_from_json(record: Json) -> Layer:
    """The inverse of `layer_to_json`."""
    outline = np.array(record["outline"]).reshape(-1, 2)
    return Layer(record["y"], number_or_infinity(record["sigma"]), record["area"], outline)


def world_to_json(world: WorldRef) -> Json:
    """`{"crs": ..., "origin": [x, y, z]}` with the origin in whole metres; world = local + origin."""
    return {"crs": world.crs, "origin": [int(v) for v in world.origin]}


def world_from_json(record: Json) -> WorldRef:
    """The inverse of `world_to_json`."""
    return WorldRef(np.array(record["origin"], np.int64), record["crs"])


def finite_or_none(value: float) -> float | None:
    """The number, or None for infinity and NaN, which JSON cannot hold."""
    return float(value) if math.isfinite(value) else None


def number_or_infinity(value: float | None) -> float:
    """The inverse of `finite_or_none`: None becomes infinity."""
    return math.inf if value is None else float(value)
