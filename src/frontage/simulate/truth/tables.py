"""The truth of a simulated scene as plain tables, the content of `truth.json`.

The keys are in docs/reference/simulate.md, "Truth".

Positions are in world coordinates, angles in degrees and lengths in metres. Outlines and depths are in the
frame of their facade: origin on the main plane at the lower left corner, x right as seen from the street, y
into the building, z up.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from frontage.geometry.arrays import Array, Float, Int
from frontage.geometry.rigid import Rigid3
from frontage.model import Photo, WorldRef
from frontage.simulate.scene import FacadePlan, House, OpeningPlan, ProtrusionPlan, Scene
from frontage.simulate.sensors.recording import Drive, Echo, Recording, Station
from frontage.simulate.truth.visibility import Shares, Visibility

SCHEMA = 1
_DIGITS = 6  # decimals of lengths: micrometres

Table = dict[str, Any]


def scene_table(scene: Scene, seen: Visibility, orthos: Mapping[str, Table]) -> Table:
    """Return everything but the sensors; `orthos` has the entries of true ortho-images, by facade id."""
    return {
        "schema": SCHEMA,
        "name": scene.name,
        "seed": scene.seed,
        "crs": scene.world.crs,
        "origin": [int(v) for v in scene.world.origin],
        "road": _numbers(scene.world.to_world(scene.road)),
        "buildings": [_building(house, scene.world) for house in scene.houses],
        "facades": [
            _facade(scene, h, f, seen, orthos.get(facade.id))
            for h, house in enumerate(scene.houses)
            for f, facade in enumerate(house.facades)
        ],
        "notes": list(scene.notes),
    }


def _building(house: House, world: WorldRef) -> Table:
    return {
        "id": house.id,
        "address": house.address,
        "side": house.side,
        "footprint": _numbers(house.footprint + world.origin[:2]),
        "ground_z": _number(house.ground_z + world.origin[2]),
        "eaves_z": _number(house.eaves_z + world.origin[2]),
        "ridge_z": _number(house.ridge_z + world.origin[2]),
        "twin_of": house.twin_of,
        "facades": [facade.id for facade in house.facades],
    }


def _facade(scene: Scene, h: int, f: int, seen: Visibility, ortho: Table | None) -> Table:
    house, facade = scene.houses[h], scene.houses[h].facades[f]
    frame = facade.local_from_facade
    return {
        "id": facade.id,
        "building": house.id,
        "frame": {
            "origin": _numbers(scene.world.to_world(frame.t)),
            "x": frame.R[:, 0].tolist(),
            "y": frame.R[:, 1].tolist(),
            "z": frame.R[:, 2].tolist(),
        },
        "outline": _numbers(facade.outline),
        "roughness": facade.roughness,
        "visible": seen.facades.get((h, f), {}),
        "openings": [
            _opening(opening, facade, scene.world, seen.openings.get((h, f, o), {}))
            for o, opening in enumerate(facade.openings)
        ],
        "protrusions": [_protrusion(p) for p in facade.protrusions],
        "ortho": ortho,
    }


def _opening(opening: OpeningPlan, facade: FacadePlan, world: WorldRef, seen: Shares) -> Table:
    ring = np.column_stack(
        [opening.ring[:, 0], np.full(len(opening.ring), opening.wall_y), opening.ring[:, 1]]
    )
    bars: Table = {"vertical": [], "horizontal": []}
    for b in opening.bars:
        bars[b.axis].append(
            {
                "position": _number(b.position),
                "extent": _numbers(b.extent),
                "width": _number(b.width),
                "behind": _number(b.behind),
            }
        )
    return {
        "id": opening.id,
        "kind": opening.kind,
        "shape": opening.shape,
        "outline": _numbers(opening.ring),
        "outline_world": _numbers(world.to_world(facade.local_from_facade.apply(ring))),
        "wall_y": _number(opening.wall_y),
        "depth": _number(opening.depth),
        "glass_depth": _number(opening.glass_depth),
        "frame_width": _number(opening.frame_width),
        "bars": bars,
        "glazing": opening.glazing,
        "lines": [{"line": _numbers(line.line), "width": _number(line.width)} for line in opening.lines],
        "ajar": None if opening.ajar is None else _numbers(opening.ajar[:4]),
        "meeting": None if opening.meeting is None else _number(opening.meeting),
        "shutters": opening.shutters,
        "glazed": opening.glazed,
        "floor": opening.floor,
        "bay": opening.bay,
        "visible": seen,
    }


def _protrusion(p: ProtrusionPlan) -> Table:
    return {"id": p.id, "kind": p.kind, "outline": _numbers(p.ring), "y": _numbers(p.y_range)}


def station_table(station: Station, world: WorldRef, file: str) -> Table:
    """Return the entry of a terrestrial scan; every scan is the first (`number` = 1) in its own file."""
    return {
        "file": file,
        "number": 1,
        "true": _pose(station.true, world),
        "given": _pose(station.given, world),
        "points": len(station.scan),
        "raster": None if station.scan.grid is None else list(station.scan.grid.index.shape),
        "echoes": _echoes(station.echo),
    }


def drive_table(drive: Drive, file: str, trajectory: str, true_trajectory: str) -> Table:
    """Return the entry of a mobile recording; `drift` is the greatest distance of given and true track."""
    off = np.linalg.norm(drive.trajectory[:, 1:4] - drive.true_trajectory[:, 1:4], axis=1)
    return {
        "file": file,
        "trajectory": trajectory,
        "true_trajectory": true_trajectory,
        "points": len(drive.scan),
        "drift": _number(float(off.max(initial=0.0))),
        "echoes": _echoes(drive.echo),
    }


def photo_table(photo: Photo, given: Rigid3, world: WorldRef) -> Table:
    """Return the entry of a photograph: camera (COLMAP), true pose, and the approximate pose of its EXIF."""
    return {
        "name": photo.id,
        "camera": {
            "model": photo.camera.model,
            "width": photo.camera.width,
            "height": photo.camera.height,
            "params": photo.camera.params.tolist(),
        },
        "true": _camera_pose(photo.pose, world),
        "given": _camera_pose(given, world),
    }


def point_arrays(scene: Scene, recording: Recording, order: Int) -> dict[str, Array]:
    """Return arrays per point, in the order of the file: surface, part, house, echo and range.

    surface is an index into `surface_arrays`; order (n,) is the index into the recording's points of every
    point of the file.
    """
    surface = recording.surface[order]
    return {
        "surface": surface,
        "part": _pick(scene.parts, surface, 255),
        "house": _pick(np.array([s.house for s in scene.surfaces], np.int32), surface, -1),
        "echo": recording.echo[order],
        "range": recording.true_range[order].astype(np.float32),
    }


def surface_arrays(scene: Scene) -> dict[str, Array]:
    """Return arrays over the surfaces that points refer to: id, part (`Part`), house, facade, opening."""
    return {
        "id": np.array([s.id for s in scene.surfaces], np.str_),
        "part": scene.parts,
        **{
            name: np.array([getattr(s, name) for s in scene.surfaces], np.int32)
            for name in ("house", "facade", "opening")
        },
    }


def _pick(values: Array, index: Array, none: int) -> Array:
    """Returns values[index], or `none` where the index is negative."""
    padded = np.append(values, np.array(none, values.dtype))
    return np.asarray(padded[index])


def _pose(pose: Rigid3, world: WorldRef) -> Table:
    """Returns the world position and the rotation world_from_sensor."""
    return {"position": _numbers(world.to_world(pose.t)), "R": pose.R.tolist()}


def _camera_pose(pose: Rigid3, world: WorldRef) -> Table:
    """Returns the world centre and the rotation camera_from_world, as in COLMAP."""
    return {"center": _numbers(world.to_world(pose.t)), "R": pose.R.T.tolist()}


def _echoes(echo: Array) -> Table:
    return {kind.name.lower(): int((echo == kind).sum()) for kind in Echo}


def _number(value: float) -> float:
    return round(float(value), _DIGITS)


def _numbers(values: Float | Sequence[Any]) -> Any:
    return np.round(np.asarray(values, np.float64), _DIGITS).tolist()
