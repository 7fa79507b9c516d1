"""`run.json`: the district at a glance, with all that search, the list and the view in 3-D need."""

import json
from typing import Any

import numpy as np

from frontage import __version__
from frontage.errors import FrontageError
from frontage.exports.survey import in_world
from frontage.geometry.arrays import Float
from frontage.geometry.ring import at_depth, box_sigmas
from frontage.io.meshes.tileset import geocentric_from_local
from frontage.model import Elements, Facade, Opening
from frontage.pipeline.gaps import gaps, unmodelled
from frontage.pipeline.survey import heights_of
from frontage.report.layouts import layout_words
from frontage.viewer.bands import BLOCK_PX, Blocks, described
from frontage.viewer.run import Run

SCHEMA = 1


def overview_json(run: Run) -> bytes:
    """Return `run.json`. Places are local: world coordinates minus `origin`, m."""
    store = run.store
    world, (known, lost) = store.world(), run.addresses
    facades = [_facade(run, name) for name in run.facades]
    middle = np.mean([f["center"] for f in facades], axis=0)
    table = {
        "schema": SCHEMA,
        "frontage": __version__,
        "name": run.title,
        "crs": world.crs,
        "origin": [int(v) for v in world.origin],
        "heights": heights_of(world),
        "buildings": [
            {"id": r.id, "addresses": known[r.id], "facades": list(store.facades_of(r.id)),
             "ground": r.ground_z if np.isfinite(r.ground_z) else None} for r in store.building_records()
        ],
        "lost": lost,
        "facades": facades,
        "photos": [{"id": p.id, "path": run.photo_path(k), "size": [p.camera.width, p.camera.height],
                    "at": p.pose.t.tolist()} for k, p in enumerate(run.photos)],
        "blocks": BLOCK_PX,
        "bands": described(),
        "tiles": _tiles(run, middle),
        "left_out": _left_out(run),
    }  # fmt: skip
    return json.dumps(table, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


def _facade(run: Run, name: str) -> dict[str, Any]:
    facade, elements = run.plane(name), run.store.elements(name)
    sidecar = run.store.sidecar(name)
    local = facade.frame.apply(at_depth(facade.outline, 0.0))
    x0, z0, x1, z1 = facade.extent
    middle = facade.frame.apply(np.array([[(x0 + x1) / 2, 0.0, (z0 + z1) / 2]]))[0]
    ortho = None
    if sidecar is not None:
        corner, (w, h) = sidecar.corner_in(facade), sidecar.size_m
        box = np.array([[0, 0], [w, 0], [w, -h], [0, -h]]) + corner
        ortho = {
            "width": sidecar.size[0], "height": sidecar.size[1], "gsd": sidecar.gsd,
            "levels": Blocks(run.store.facade_folder(name), sidecar.size).levels,
            "corners": np.round(facade.frame.apply(at_depth(box, 0.0)), 4).tolist(),
        }  # fmt: skip
    return {
        "id": name,
        "building": facade.building,
        "path": run.facade_path(name),
        "outline": np.round(local, 4).tolist(),
        "center": np.round(middle, 4).tolist(),
        "outward": np.round(-facade.frame.R[:, 1], 6).tolist(),
        "size": [round(x1 - x0, 3), round(z1 - z0, 3)],
        "ortho": ortho,
        "openings": [_opening(facade, elements, o) for o in elements.openings] if elements else None,
    }


def _opening(facade: Facade, elements: Elements, o: Opening) -> dict[str, Any]:
    (x0, z0), (x1, z1) = o.ring.min(0), o.ring.max(0)
    sigmas = box_sigmas(o.ring, o.ring_covariance)
    centre = in_world(facade, np.array([[(x0 + x1) / 2, (z0 + z1) / 2]]), elements.wall_y(o))[0]
    return {
        "id": o.id,
        "kind": str(o.kind),
        "floor": o.floor,
        "number": o.number,
        "bay": o.bay,
        "width": round(float(x1 - x0), 4),
        "height": round(float(z1 - z0), 4),
        "sigma": round(float(np.max(sigmas)), 4) if np.isfinite(sigmas).all() else None,
        "provenance": str(o.provenance),
        "confidence": round(float(o.confidence), 3),
        "layout": layout_words(o.glazing) if o.glazing else None,
        "center": np.round(centre - facade.world.origin, 4).tolist(),
    }


def _tiles(run: Run, middle: Float) -> dict[str, Any] | None:
    """Return the tileset and the matrix (column by column) from local metres to the tiles' coordinates."""
    if not run.tile_files:
        return None
    try:
        reports = run.store.model()
    except FrontageError:
        reports = {}
    hosts = {str(about.get("host", "")) for about in reports.values()}
    matrix = geocentric_from_local(run.store.world(), middle)
    return {
        "path": "tiles/tileset.json",
        "matrix": matrix.T.ravel().tolist(),
        "before": "blocks from the point cloud" if hosts == {"cloud"} else "the city model",
    }


def _left_out(run: Run) -> list[str]:
    """Say in sentences what the viewer cannot show."""
    found = [*gaps(run.store), *unmodelled(run.store)]
    if not run.tile_files:
        found.append("The run has no model in 3-D: the district shows the pictures of its facades.")
    if run.witnesses.note:
        found.append(f"{run.witnesses.note[0].upper()}{run.witnesses.note[1:]}.")
    elif not run.photos:
        found.append("The run has no oriented photos.")
    if not any(run.addresses[0].values()):
        found.append("No building has an address: search by the ids of buildings.")
    return found
