"""The facades that window bars are judged on: simulated ones, and real ones where their data is present."""

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from _barscore import TrueLayout
from _windows import WindowScene
from frontage import read_photos, read_scans
from frontage.catalog.sightlines import name_photos, scanned_surfaces
from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.geometry.ring import rectangle
from frontage.model import (
    Camera,
    Elements,
    Estimate,
    Facade,
    Layer,
    Opening,
    OpeningKind,
    Photo,
    Protrusion,
    ProtrusionKind,
    Provenance,
    Scan,
)
from frontage.model.built import TrueBar
from frontage.simulate.houses.glazing import LOWER_SASH_M
from frontage.simulate.scene import OpeningPlan

_ANNOTATED_FRAME_M = 0.2  # no frame is wider
CASEMENT_M = 0.012  # from the front of a simulated frame back to its casements


@dataclass(frozen=True, eq=False)
class Case:
    """What `crossbars.find_bars` is given, and the truth by window."""

    name: str
    facade: Facade
    elements: Elements
    photos: tuple[Photo, ...]
    image_of: Callable[[str], Array]
    scan: Scan | None
    truth: dict[str, TrueLayout]


def simulated(scene: WindowScene, views: Sequence[int] | None = None, reduce: int = 1) -> Case:
    """A simulated house with all photos or some of them, reduced by a whole number of pixels."""
    photos = scene.photos if views is None else tuple(scene.photos[k] for k in views)
    truth = {
        id: TrueLayout(o.bars, o.glazing, _front(o), light=_light(o.ring, o.frame_width))
        for id, o in scene.truth.items()
    }
    return Case(
        f"house {scene.asked.seed}", scene.facade, scene.elements, tuple(_reduced(p, reduce) for p in photos),
        lambda name: _smaller(scene.image_of(name), reduce), scene.scan, truth,
    )  # fmt: skip


def _front(o: OpeningPlan) -> float:
    """Depth m behind the wall of the plane of the bars' front faces: what `Glazing.depth` means.

    Bars of a lower sash lie in a plane of their own. Posts show the edges of the casements on both sides of
    them, which stand as far behind the front of the frame as casements without any bar.
    """
    behind = np.array([b.behind if b.behind > 0 else CASEMENT_M for b in o.bars])
    length = np.array([b.extent[1] - b.extent[0] for b in o.bars]) * (behind < LOWER_SASH_M)
    return o.depth + (float(length @ behind / length.sum()) if length.any() else CASEMENT_M)


def _light(ring: Float, frame: float) -> tuple[float, float, float, float]:
    (x0, z0), (x1, z1) = ring.min(0) + frame, ring.max(0) - frame
    return float(x0), float(z0), float(x1), float(z1)


def _reduced(photo: Photo, factor: int) -> Photo:
    if factor == 1:
        return photo
    camera = photo.camera
    params = camera.params.copy()
    params[:4] /= factor
    return replace(
        photo, camera=Camera(camera.model, camera.width // factor, camera.height // factor, params)
    )


def _smaller(image: Array, factor: int) -> Array:
    h, w = image.shape[0] // factor, image.shape[1] // factor
    return cv2.resize(image[: h * factor, : w * factor], (w, h), interpolation=cv2.INTER_AREA)


def ingolstadt(data: Path, cameras: Path | None = None) -> list[Case]:
    """Real buildings' models with simulated sensors that are not ours; outlines 5 mm off, depths 1 cm.

    cameras  COLMAP folder with poses of the photos; None = the true ones
    """
    folder = data / "ingolstadt_scene"
    truth = json.loads((folder / "truth" / "truth.json").read_text())
    scan = read_scans(folder / "input" / "registered" / "scan_2cm.e57")
    true = folder / "input" / "registered" / "colmap"
    photos = read_photos(folder / "input" / "photos" / "*.jpg", scan, cameras=cameras or true)
    surfaces = scanned_surfaces(scan.xyz)
    return [
        _ingolstadt_facade(f, scan, photos, surfaces, np.random.default_rng(k))
        for k, f in enumerate(truth["facades"])
        if f.get("evaluate")
    ]


def _ingolstadt_facade(
    table: dict[str, Any], scan: Scan, photos: Any, surfaces: Any, rng: np.random.Generator
) -> Case:
    x, z, n = (np.array(table[key]) for key in ("e_u", "e_v", "normal"))
    frame = Rigid3(
        "local", "facade", np.column_stack([x, -n, z]), scan.world.to_local(np.array(table["origin"]))
    )
    w, h = table["size"]
    facade = _facade(table["id"], frame, rectangle(0, 0, w, h), scan, scan.world)
    openings, sills, truth = [], {}, {}
    for o in table["openings"]:
        if o["kind"] != "Window" or not o["glazed"] or o["ambiguous"] or o["visible_photo"] < 0.5:
            continue
        wall = -float(o["plane_offset"])
        ring = np.array(o["polygon_uv"])
        ring = ring if _area(ring) > 0 else ring[::-1]
        depth = o["depth"] + float(rng.normal(0, 0.01))
        openings.append(_opening(o["id"], _moved(ring, 0.005, rng), (depth, 0.01), 0.005, wall))
        sills[wall] = ring
        bars = tuple(_bar(*b) for b in o["bars_uv"])
        light = _light(np.array(o["rect_uv"]).reshape(2, 2), o["frame_width"])
        truth[o["id"]] = TrueLayout(bars, "bars", o["depth"], light=light)
    elements = Elements(table["id"], tuple(openings), _walls(sills))
    named = name_photos(facade, elements, photos.photos, surfaces)
    return Case(table["id"], facade, named, photos.photos, photos.image, scan, truth)


def _bar(u0: float, v0: float, u1: float, v1: float) -> TrueBar:
    if v1 - v0 > u1 - u0:
        return TrueBar("vertical", (u0 + u1) / 2, (v0, v1), u1 - u0)
    return TrueBar("horizontal", (v0 + v1) / 2, (u0, u1), v1 - v0)


# The front of castle_photos that photos 3 to 8 show. The plane was fitted to its points; outlines and bars
# were placed by hand on the photos rectified onto the plane of the frames (0.18 m deep), the windows found
# by correlation and looked at one by one. All have one layout. One with an open casement is left out.
_CASTLE_NORMAL, _CASTLE_OFFSET = (-0.08599271, 0.99629577), 22.401918
_CASTLE_CENTRES = (
    (-7.016, 10.796), (-1.056, 10.820), (3.576, 10.812), (7.472, 10.812), (11.368, 10.828), (16.016, 10.852),
    (21.944, 10.852), (-6.992, 6.076), (-1.080, 6.084), (3.560, 6.084), (11.376, 6.068), (21.920, 6.100),
    (-7.000, 0.964), (-1.056, 0.980), (3.552, 0.980), (11.368, 0.956), (15.952, 0.948), (21.912, 0.916),
)  # fmt: skip
_CASTLE_RING = (-0.66, -1.46, 0.725, 1.32)  # x0, z0, x1, z1 about the centre, 2 cm
_CASTLE_UPRIGHT = ((0.055, 0.14), (-0.296, 0.035), (0.394, 0.035))  # position, width
_CASTLE_LEVEL = ((0.400, 0.14), (0.857, 0.035), (-0.068, 0.035), (-0.473, 0.035), (-0.875, 0.035))


def castle(data: Path) -> list[Case]:
    """Real photos with metric poses; 11 mm per px on bars of 3.5 cm. Without a scan."""
    folder = data / "castle_photos"
    cloud = read_scans(folder / "colmap" / "points3D.txt")
    photos = read_photos(folder / "images", cloud, cameras=folder / "colmap")
    nx, ny = _CASTLE_NORMAL
    axes = np.column_stack([[ny, -nx, 0], [nx, ny, 0], [0, 0, 1]])
    origin = cloud.world.to_local(np.array([nx * _CASTLE_OFFSET, ny * _CASTLE_OFFSET, 0.0]))
    frame = Rigid3("local", "facade", axes, origin)
    facade = _facade("castle", frame, rectangle(-11, -2, 23, 14), None, cloud.world)
    openings, truth = [], {}
    for k, (x, z) in enumerate(_CASTLE_CENTRES):
        a, b, c, d = _CASTLE_RING
        ring = rectangle(x + a, z + b, x + c, z + d)
        openings.append(_opening(f"castle/W{k + 1}", ring, (0.18, 0.03), 0.02, 0.0))
        bars = [TrueBar("vertical", x + p, (z - 1.30, z + 1.25), w) for p, w in _CASTLE_UPRIGHT]
        bars += [TrueBar("horizontal", z + p, (x - 0.58, x + 0.68), w) for p, w in _CASTLE_LEVEL]
        light = (x - 0.58, z - 1.30, x + 0.68, z + 1.25)
        truth[f"castle/W{k + 1}"] = TrueLayout(tuple(bars), light=light)
    named = name_photos(facade, Elements("castle", tuple(openings)), photos.photos, None)
    return [Case("castle", facade, named, photos.photos, photos.image, None, truth)]


def annotated(data: Path, name: str) -> list[Case]:
    """A real scan without photos whose truth file tells bars: "brooklyn_row" or "manhattan_apartment"."""
    table = json.loads((data / "truth" / f"{name}.json").read_text())
    scan = read_scans(data / table["source"])
    axes = np.array(table["frame"]["axes_rows_XYZ"]).T
    frame = Rigid3("local", "facade", axes, scan.world.to_local(np.array(table["frame"]["origin"])))
    boxes = np.array([[o["x0"], o["z0"], o["x1"], o["z1"]] for o in table["openings"]])
    (x0, z0), (x1, z1) = boxes[:, :2].min(0) - 1, boxes[:, 2:].max(0) + 1
    facade = _facade(name, frame, rectangle(x0, z0, x1, z1), scan, scan.world)
    openings, sills, truth = [], {}, {}
    for o in table["openings"]:
        if not o.get("bars") or o["frame_depth"] is None or o["ignored_fraction"] > 0.5:
            continue
        for k, (a, b, c, d) in enumerate(o.get("panes") or [[o["x0"], o["z0"], o["x1"], o["z1"]]]):
            id, wall = f"{o['id']}.{k + 1}", float(o["wall_depth"])
            ring = rectangle(a, b, c, d)
            depth = float(o["frame_depth"]) - wall
            openings.append(_opening(id, ring, (depth, 0.03), 0.01, wall))
            sills[wall] = ring
            truth[id] = _annotation(o["bars"], (a, b, c, d))
    elements = Elements(name, tuple(openings), _walls(sills))
    return [Case(name, facade, elements, (), _no_pixels, scan, truth)]


def _annotation(table: dict[str, Any], box: tuple[float, float, float, float]) -> TrueLayout:
    """The annotated bars of a window, whose widths are not known (5 cm are assumed for counting overlaps).

    They are drawn up to the border of the opening, across a frame of unknown width.
    """
    within = table.get("complete_region")
    complete = bool(table.get("complete")) or within is not None
    bars = []
    for axis, low, high in (("vertical", box[0], box[2]), ("horizontal", box[1], box[3])):
        across = (box[1], box[3]) if axis == "vertical" else (box[0], box[2])
        for b in table[axis]:
            ends = max(b["span"][0], across[0]), min(b["span"][1], across[1])
            if b["type"] != "mullion" and low < b["pos"] < high and ends[1] > ends[0]:
                bars.append(TrueBar(axis, b["pos"], ends, 0.05))
    shown = None if within is None else (max(box[0], within[0]), max(box[1], within[1]),
                                         min(box[2], within[2]), min(box[3], within[3]))  # fmt: skip
    x, z = (min(_ANNOTATED_FRAME_M, 0.2 * side) for side in (box[2] - box[0], box[3] - box[1]))
    light = (box[0] + x, box[1] + z, box[2] - x, box[3] - z)
    return TrueLayout(tuple(bars), "bars", None, shown, complete, light)


def _no_pixels(name: str) -> Array:
    raise KeyError(name)


def _facade(id: str, frame: Rigid3, outline: Float, scan: Scan | None, world: Any) -> Facade:
    own = frame.inverse.apply(scan.xyz if scan else np.empty((0, 3)))
    (x0, z0), (x1, z1) = outline.min(0), outline.max(0)
    near = (own[:, 0] > x0) & (own[:, 0] < x1) & (own[:, 2] > z0) & (own[:, 2] < z1)
    near &= np.abs(own[:, 1]) < 1.5
    layer = Layer(0.0, 1e-3, float((x1 - x0) * (z1 - z0)), outline)
    sigma = np.array([1e-3] * 3 + [1e-4] * 3)
    return Facade(
        id, id, Estimate(frame, np.diag(sigma**2), 100.0), world, outline, (layer,), np.flatnonzero(near),
        np.flatnonzero(near & (np.abs(own[:, 1]) < 0.02)), 0.005, 0.02, 1.0, "rays",
    )  # fmt: skip


def _opening(id: str, ring: Float, depth: tuple[float, float], sigma: float, wall: float) -> Opening:
    value, error = depth
    return Opening(
        id, OpeningKind.WINDOW, ring, np.eye(2 * len(ring)) * sigma**2,
        Estimate(value, np.array([[error**2]]), 20.0), "rectangle" if len(ring) == 4 else "round",
        Provenance.MEASURED, 50.0, 0.99, 1, 1, on=_wall_name(wall),
    )  # fmt: skip


def _wall_name(y: float) -> str:
    return "" if y == 0.0 else f"wall at {y:.4f}"


def _walls(rings: dict[float, Float]) -> tuple[Protrusion, ...]:
    """The walls beside the main plane that hold windows."""
    kind, given = ProtrusionKind.AVANT_CORPS, Provenance.MEASURED
    return tuple(
        Protrusion(_wall_name(y), kind, ring, 0.01, Estimate(y, np.array([[1e-6]]), 100.0), given, 1.0)
        for y, ring in rings.items()
        if y != 0.0
    )


def _moved(ring: Float, sigma: float, rng: np.random.Generator) -> Float:
    """A ring whose borders are off by an error each."""
    low, high = ring.min(0), ring.max(0)
    share = (ring - low) / (high - low)
    return ring + (1 - share) * rng.normal(0, sigma, 2) + share * rng.normal(0, sigma, 2)


def _area(ring: Float) -> float:
    x, z = ring.T
    return float(x @ np.roll(z, -1) - z @ np.roll(x, -1)) / 2
