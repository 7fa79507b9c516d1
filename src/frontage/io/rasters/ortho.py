"""An ortho-image on disk: five rasters and the sidecar `ortho.json`, which is the contract.

``raster_to_world`` (4 x 4, row-major) takes ``(column, row, y, 1)`` to world coordinates: columns and rows in
pixels with the centre of the first at 0.5, y in metres behind the facade plane.
"""

import json
import math
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.io.files import whole_file
from frontage.io.rasters.geotiff import matrix_text, read_geotiff, write_geotiff
from frontage.model import Estimate, Facade, Layer, OrthoImage, PhotoOffset, Provenance, WorldRef
from frontage.raster.tiles import Tile

FILES = ("ortho.json", "ortho.tif", "ortho.jpg", "depth.tif", "sources.tif", "gsd.tif", "intensity.tif")
"""What `write_ortho` leaves in a folder."""

SCHEMA = 1
_JPEG_SIDE = 16384  # px: what viewers open; the format itself ends at 65535
_JPEG_QUALITY = 90


def write_ortho(folder: Path, ortho: OrthoImage) -> None:
    """Write the rasters (intensity.tif when there is one), then ortho.jpg and ortho.json.

    Every file is complete when it appears under its name; the sidecar comes last, so that a folder with an
    ortho.json is a whole one.

    Raises FileError when the folder cannot be written.
    """
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(folder, f"cannot be a folder ({error.strerror})", "choose another output") from error
    sidecar = _sidecar(ortho)
    matrix = np.array(sidecar["raster_to_world"])
    about = {
        "FACADE": ortho.facade.id,
        "RASTER_TO_WORLD": matrix_text(matrix),
        "WORLD_CRS": ortho.facade.world.crs or "",
        "SOURCES": "; ".join(ortho.sources),
    }

    def put(name: str, band: Array, nodata: float | None = None) -> None:
        crs = f"Facade {ortho.facade.id} (x right, z up, m)"
        write_geotiff(folder / name, band, ortho.corner, ortho.gsd, crs, about, nodata)

    put("ortho.tif", ortho.pixels)
    put("depth.tif", ortho.depth, math.nan)
    put("sources.tif", ortho.source, 0)
    put("gsd.tif", ortho.gsd_effective, math.nan)
    if ortho.intensity is not None:
        put("intensity.tif", ortho.intensity, math.nan)
    else:
        (folder / "intensity.tif").unlink(missing_ok=True)
    _write_bytes(folder / "ortho.jpg", _jpeg(ortho.pixels))
    _write_bytes(folder / "ortho.json", (json.dumps(sidecar, indent=1, allow_nan=False) + "\n").encode())


def read_ortho(folder: Path, window: Tile | None = None) -> OrthoImage:
    """Read what `write_ortho` wrote; the facade comes back without its point indices.

    A `window` of pixels is an ortho-image of its own, with its own corner; nothing else is read. Bands larger
    than memory should hold are read into scratch files when there is no window.

    Raises FileError when a file is missing, damaged, or does not fit the sidecar, InputError when the window
    lies outside.
    """
    folder = Path(folder)
    path = folder / "ortho.json"
    side = read_sidecar(folder)
    pixels, corner, gsd = read_geotiff(folder / "ortho.tif", window)
    bands = {name: read_geotiff(folder / f"{name}.tif", window)[0] for name in ("depth", "sources", "gsd")}
    has_intensity = (folder / "intensity.tif").is_file()
    intensity = read_geotiff(folder / "intensity.tif", window)[0] if has_intensity else None
    try:
        facade = _facade(side)
        same_size = window is not None or pixels.shape[:2] == (side["height"], side["width"])
        if not same_size or not math.isclose(gsd, side["gsd"], rel_tol=1e-9):
            raise FileError(folder / "ortho.tif", "does not fit ortho.json", "run the ortho step again")
        if window is None:
            corner = side["corner"][0], side["corner"][1]
        return OrthoImage(
            pixels,
            side["gsd"],
            corner,
            facade,
            bands["depth"],
            bands["sources"],
            tuple(side["sources"]),
            bands["gsd"],
            intensity,
            None if side.get("photo_offset") is None else PhotoOffset(**side["photo_offset"]),
            side.get("photos", 0),
        )
    except (KeyError, TypeError, IndexError) as error:
        raise FileError(path, f"lacks or garbles {error}", "run the ortho step again") from error
    except ValueError as error:
        if isinstance(error, FileError):
            raise
        raise FileError(path, f"is inconsistent ({error})", "run the ortho step again") from error


def read_sidecar(folder: Path) -> dict[str, Any]:
    """The contents of ortho.json.

    Raises FileError when it is missing or no JSON object.
    """
    path = Path(folder) / "ortho.json"
    if not path.is_file():
        raise FileError(path, "does not exist", "run the ortho step first")
    try:
        side = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, OSError) as error:
        raise FileError(path, f"is no valid JSON ({error})", "run the ortho step again") from error
    if not isinstance(side, dict):
        raise FileError(path, "holds no JSON object", "run the ortho step again")
    return side


def raster_to_world(ortho: OrthoImage) -> Float:
    """(4, 4): ``(column, row, y, 1)`` to world metres."""
    facade_from_raster = np.array(
        [
            [ortho.gsd, 0.0, 0.0, ortho.corner[0]],
            [0.0, 0.0, 1.0, 0.0],
            [0.0, -ortho.gsd, 0.0, ortho.corner[1]],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )
    world: Float = ortho.facade.frame.matrix.copy()
    world[:3, 3] += ortho.facade.world.origin
    matrix: Float = world @ facade_from_raster
    return matrix


def _sidecar(ortho: OrthoImage) -> dict[str, Any]:
    """Everything of ortho.json; the keys of the design first."""
    facade, frame = ortho.facade, ortho.facade.frame
    width, height = ortho.size
    return {
        "schema": SCHEMA,
        "building": facade.building,
        "facade": facade.id,
        "crs": facade.world.crs,
        "gsd": ortho.gsd,
        "width": width,
        "height": height,
        "raster_to_world": raster_to_world(ortho).tolist(),
        "frame": {
            "origin": facade.world.to_world(frame.t).tolist(),
            "x": frame.R[:, 0].tolist(),
            "y": frame.R[:, 1].tolist(),
            "z": frame.R[:, 2].tolist(),
        },
        "sigma_plane": _finite(facade.sigma_plane),
        "sources": list(ortho.sources),
        "corner": list(ortho.corner),
        "local_origin": facade.world.origin.tolist(),
        "outline": facade.outline.tolist(),
        "layers": [
            {"y": v.y, "sigma": v.sigma, "area": v.area, "outline": v.outline.tolist()} for v in facade.layers
        ],
        "covariance": facade.local_from_facade.covariance.tolist(),
        "degrees_of_freedom": _finite(facade.local_from_facade.dof),
        "provenance": str(facade.local_from_facade.provenance),
        "roughness": _finite(facade.roughness),
        "spacing": _finite(facade.spacing),
        "coverage": _finite(facade.coverage),
        "oriented_by": facade.oriented_by,
        "curvature": [_finite(v) for v in facade.curvature],
        "notes": list(facade.notes),
        "relief": any(np.isfinite(part).any() for part in _strips(ortho.depth)),
        "photo_offset": None if ortho.photo_offset is None else asdict(ortho.photo_offset),
        "photos": ortho.photos,
        "nodata_share": round(sum(int((p == 0).sum()) for p in _strips(ortho.source)) / ortho.source.size, 6),
    }


def _strips(band: Array) -> Iterator[Array]:
    """A band (h, w) in strips of some rows, so that what is asked of it takes little memory."""
    for row in range(0, band.shape[0], 1024):
        yield band[row : row + 1024]


def _finite(value: float) -> float | None:
    """JSON has no infinity and no NaN: None stands for both."""
    return float(value) if math.isfinite(value) else None


def _number(value: float | None) -> float:
    return math.inf if value is None else float(value)


def _facade(side: dict[str, Any]) -> Facade:
    """The facade of a sidecar, without point indices."""
    frame = side["frame"]
    world = WorldRef(np.array(side["local_origin"]), side["crs"])
    R = np.column_stack([frame["x"], frame["y"], frame["z"]])
    pose = Rigid3("local", "facade", R, world.to_local(np.array(frame["origin"])))
    none = np.empty(0, np.int64)
    layers = tuple(Layer(v["y"], v["sigma"], v["area"], np.array(v["outline"])) for v in side["layers"])
    return Facade(
        id=side["facade"],
        building=side["building"],
        local_from_facade=Estimate(
            pose,
            np.array(side["covariance"]),
            _number(side["degrees_of_freedom"]),
            Provenance(side["provenance"]),
        ),
        world=world,
        outline=np.array(side["outline"]),
        layers=layers,
        support=none,
        inliers=none,
        roughness=_number(side["roughness"]),
        spacing=_number(side["spacing"]),
        coverage=_number(side["coverage"]),
        oriented_by=side["oriented_by"],
        curvature=(_number(side["curvature"][0]), _number(side["curvature"][1])),
        notes=tuple(side["notes"]),
    )


def _jpeg(pixels: Array) -> bytes:
    """The picture on white; larger than 16384 px it is reduced by a whole factor."""
    step = -(-max(pixels.shape[:2]) // _JPEG_SIDE)
    rows = []
    for r in range(0, pixels.shape[0], 2048 * step):
        part = np.asarray(pixels[r : r + 2048 * step])
        part = np.where(part[..., 3:] > 0, part[..., :3], 255).astype(np.uint8)
        if step > 1:
            size = (max(1, part.shape[1] // step), max(1, part.shape[0] // step))
            part = cv2.resize(part, size, interpolation=cv2.INTER_AREA)
        rows.append(part)
    picture = cv2.cvtColor(np.concatenate(rows), cv2.COLOR_RGB2BGR)
    return bytes(cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[1])


def _write_bytes(path: Path, content: bytes) -> None:
    """Write a file so that it appears whole or not at all."""
    with whole_file(path) as temporary:
        temporary.write_bytes(content)
