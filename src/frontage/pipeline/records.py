"""Nouns to JSON and back: what a stage leaves for the next one. Numbers keep all their digits."""

from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import WorkspaceError
from frontage.geometry.rigid import Rigid3
from frontage.model import Building, Estimate, Facade, Failed, Layer, Provenance, WorldRef
from frontage.pipeline.files import read_json, write_arrays, write_json


def save_facade(folder: Path, facade: Facade) -> None:
    """`folder/facade.json` and `folder/points.npz` (int64 indices into the building's working cloud)."""
    folder.mkdir(parents=True, exist_ok=True)
    indices = {"support": facade.support, "inliers": facade.inliers}
    write_arrays(folder / "points.npz", indices)
    write_json(folder / "facade.json", facade_record(facade))


def load_facade(folder: Path) -> Facade:
    """Read what `save_facade` wrote. Raises WorkspaceError when it is not there or not readable."""
    try:
        record = read_json(folder / "facade.json")
        with np.load(folder / "points.npz", allow_pickle=False) as indices:
            return facade_from_record(record, indices["support"], indices["inliers"])
    except FileNotFoundError:
        raise WorkspaceError(
            f"{folder}: no such facade in this run folder; `frontage facades` makes it"
        ) from None
    except (OSError, ValueError, KeyError) as error:
        raise WorkspaceError(
            f"{folder}: the facade cannot be read ({error}); run `frontage facades` again"
        ) from None


def facade_record(facade: Facade) -> dict[str, Any]:
    """Everything but the point indices, JSON-able. Angles as a rotation matrix, lengths in m, frame local."""
    pose = facade.local_from_facade
    return {
        "id": facade.id,
        "building": facade.building,
        "world": world_record(facade.world),
        "local_from_facade": {
            "R": pose.value.R.tolist(),
            "t": pose.value.t.tolist(),
            "covariance": pose.covariance.tolist(),
            "dof": _number(pose.dof),
            "provenance": str(pose.provenance),
        },
        "outline": facade.outline.tolist(),
        "layers": [
            {"y": y.y, "sigma": _number(y.sigma), "area": y.area, "outline": y.outline.tolist()}
            for y in facade.layers
        ],
        "roughness": facade.roughness,
        "spacing": facade.spacing,
        "coverage": facade.coverage,
        "sigma_plane": facade.sigma_plane,
        "oriented_by": facade.oriented_by,
        "curvature": [_number(v) for v in facade.curvature],
        "notes": list(facade.notes),
    }


def facade_from_record(record: dict[str, Any], support: Any, inliers: Any) -> Facade:
    """The inverse of `facade_record`."""
    pose = record["local_from_facade"]
    return Facade(
        id=record["id"],
        building=record["building"],
        local_from_facade=Estimate(
            Rigid3("local", "facade", np.array(pose["R"]), np.array(pose["t"])),
            np.array(pose["covariance"], np.float64),
            _real(pose["dof"]),
            Provenance(pose["provenance"]),
        ),
        world=world_from_record(record["world"]),
        outline=np.array(record["outline"]),
        layers=tuple(
            Layer(v["y"], _real(v["sigma"]), v["area"], np.array(v["outline"]).reshape(-1, 2))
            for v in record["layers"]
        ),
        support=support,
        inliers=inliers,
        roughness=record["roughness"],
        spacing=record["spacing"],
        coverage=record["coverage"],
        oriented_by=record["oriented_by"],
        curvature=(_real(record["curvature"][0]), _real(record["curvature"][1])),
        notes=tuple(record["notes"]),
    )


def building_record(building: Building, points: int) -> dict[str, Any]:
    """A building without its point indices, JSON-able; footprint and cuts in local metres."""
    return {
        "id": building.id,
        "address": building.address,
        "points": points,
        "ground_z": _number(building.ground_z),
        "footprint": None if building.footprint is None else building.footprint.tolist(),
        "cuts": [{"at": [float(v) for v in at], "posterior": float(p)} for at, p in building.cuts],
        "notes": list(building.notes),
    }


def building_from_record(record: dict[str, Any], index: Any) -> Building:
    """A building whose `index` (m,) int64 points into its working cloud."""
    footprint = record["footprint"]
    return Building(
        id=record["id"],
        index=index,
        ground_z=_real(record["ground_z"]),
        address=record["address"],
        footprint=None if footprint is None else np.array(footprint),
        cuts=tuple(((c["at"][0], c["at"][1]), c["posterior"]) for c in record["cuts"]),
        notes=tuple(record["notes"]),
    )


def world_record(world: WorldRef) -> dict[str, Any]:
    """`{"crs": ..., "origin": [x, y, z]}`; world = local + origin."""
    return {"crs": world.crs, "origin": [int(v) for v in world.origin]}


def world_from_record(record: dict[str, Any]) -> WorldRef:
    """The inverse of `world_record`."""
    return WorldRef(np.array(record["origin"], np.int64), record["crs"])


def failed_record(item: str, failed: Failed) -> dict[str, str]:
    """A warning as it stands in the manifest and in the report."""
    return {"item": item, "code": failed.code, "message": failed.message, "hint": failed.hint}


def _number(value: float) -> float | None:
    """JSON has no infinity and no NaN: null stands for "not known"."""
    return float(value) if np.isfinite(value) else None


def _real(value: float | None) -> float:
    return float("inf") if value is None else float(value)
