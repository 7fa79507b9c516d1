"""The sidecar `ortho.json` of an ortho-image: its one typed reader and writer.

The sidecar is the contract with other programs: the keys `building`, `facade`, `crs`, `gsd`, `width`,
`height`, `raster_to_world`, `frame`, `sigma_plane` and `sources` stay as they are; further keys may be added.
"""

import json
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Array, Float, freeze
from frontage.geometry.rigid import Rigid3
from frontage.io.facadefile import facade_facts, facade_from_facts
from frontage.io.files import MALFORMED, whole_file
from frontage.model import NOT_SEEN, Facade, OrthoImage, PhotoOffset, WorldRef

NAME = "ortho.json"
SCHEMA = 1
_STRIP_ROWS = 1024  # rows of a band that are examined at a time
_AGAIN = "run `frontage ortho` again"


@dataclass(frozen=True, eq=False)
class OrthoSidecar:
    """Everything that `ortho.json` says about an ortho-image.

    facade           the facade whose plane carries the image, without its point indices
    gsd              m per pixel
    size             width and height in pixels
    raster_to_world  (4, 4): takes (column, row, y, 1) to world metres; the first pixel's centre is at
                     (0.5, 0.5), y is the depth in m behind the facade plane
    corner           (x, z) m in the facade frame: outer upper left corner of pixel (0, 0)
    sources          names of the photos or scans that the pixels come from
    photos           how many of the sources, the first ones, are photos
    photo_offset     what the photos say about the depth of the surface; None without such a measurement
    relief           whether depth.tif holds measured depths
    nodata_share     share of the pixels without a source, 0..1
    light            by photo, see `OrthoImage.light`
    """

    facade: Facade
    gsd: float
    size: tuple[int, int]
    raster_to_world: Float
    corner: tuple[float, float]
    sources: tuple[str, ...]
    photos: int
    photo_offset: PhotoOffset | None
    relief: bool
    nodata_share: float
    light: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        freeze(self, raster_to_world=((4, 4), np.float64))

    @classmethod
    def of(cls, ortho: OrthoImage) -> "OrthoSidecar":
        """The sidecar of an ortho-image."""
        nodata = sum(int(np.isin(part, (0, NOT_SEEN)).sum()) for part in _strips(ortho.source))
        return cls(
            facade=ortho.facade,
            gsd=ortho.gsd,
            size=ortho.size,
            raster_to_world=_raster_to_world(ortho),
            corner=ortho.corner,
            sources=ortho.sources,
            photos=ortho.photos,
            photo_offset=ortho.photo_offset,
            relief=any(np.isfinite(part).any() for part in _strips(ortho.depth)),
            nodata_share=round(nodata / ortho.source.size, 6),
            light=ortho.light,
        )

    @property
    def crs(self) -> str | None:
        """The CRS of the world coordinates; None when the data has none."""
        return self.facade.world.crs

    @property
    def frame(self) -> Rigid3:
        """The facade frame: local from facade."""
        return self.facade.frame

    @property
    def size_m(self) -> tuple[float, float]:
        """Width and height of the image in m."""
        return self.gsd * self.size[0], self.gsd * self.size[1]

    def corner_in(self, facade: Facade) -> tuple[float, float]:
        """Outer upper left corner (x, z) m of pixel (0, 0) in the frame of `facade`, by `raster_to_world`.

        This is `corner`, up to rounding, when `facade` is the one that the image was made with.
        """
        corner = facade.world.to_local(self.raster_to_world[None, :3, 3])
        x, _, z = facade.frame.inverse.apply(corner)[0]
        return float(x), float(z)

    def to_json(self) -> dict[str, Any]:
        """The contents of `ortho.json`, in the order in which they are written."""
        facade, frame, about = self.facade, self.facade.frame, facade_facts(self.facade)
        return {
            "schema": SCHEMA,
            "building": facade.building,
            "facade": facade.id,
            "crs": facade.world.crs,
            "gsd": self.gsd,
            "width": self.size[0],
            "height": self.size[1],
            "raster_to_world": self.raster_to_world.tolist(),
            "frame": {
                "origin": facade.world.to_world(frame.t).tolist(),
                "x": frame.R[:, 0].tolist(),
                "y": frame.R[:, 1].tolist(),
                "z": frame.R[:, 2].tolist(),
            },
            "sigma_plane": about["sigma_plane"],
            "sources": list(self.sources),
            "corner": list(self.corner),
            "local_origin": facade.world.origin.tolist(),
            "outline": about["outline"],
            "layers": about["layers"],
            "covariance": about["covariance"],
            "degrees_of_freedom": about["dof"],
            "provenance": about["provenance"],
            "roughness": about["roughness"],
            "spacing": about["spacing"],
            "coverage": about["coverage"],
            "oriented_by": about["oriented_by"],
            "curvature": about["curvature"],
            "notes": about["notes"],
            "relief": self.relief,
            "photo_offset": None if self.photo_offset is None else asdict(self.photo_offset),
            "photos": self.photos,
            "nodata_share": self.nodata_share,
            "light": {name: np.round(rows, 5).tolist() for name, rows in self.light.items()},
        }

    @classmethod
    def from_json(cls, record: dict[str, Any]) -> "OrthoSidecar":
        """The inverse of `to_json`.

        Raises KeyError, TypeError, IndexError or ValueError when the record is incomplete or malformed.
        """
        frame, offset = record["frame"], record.get("photo_offset")
        world = WorldRef(np.array(record["local_origin"]), record["crs"])
        R = np.column_stack([frame["x"], frame["y"], frame["z"]])
        pose = Rigid3("local", "facade", R, world.to_local(np.array(frame["origin"])))
        facts = {**record, "id": record["facade"], "dof": record["degrees_of_freedom"]}
        no_points = np.empty(0, np.int64)
        x, z = record["corner"]
        return cls(
            facade=facade_from_facts(facts, pose, world, no_points, no_points),
            gsd=float(record["gsd"]),
            size=(int(record["width"]), int(record["height"])),
            raster_to_world=np.array(record["raster_to_world"], np.float64).reshape(4, 4),
            corner=(float(x), float(z)),
            sources=tuple(str(name) for name in record["sources"]),
            photos=int(record.get("photos", 0)),
            photo_offset=None if offset is None else PhotoOffset(**offset),
            relief=bool(record["relief"]),
            nodata_share=float(record["nodata_share"]),
            light={str(k): np.array(v, np.float64).reshape(3, 3) for k, v in record.get("light", {}).items()},
        )


def write_sidecar(folder: Path, sidecar: OrthoSidecar) -> None:
    """Write `folder/ortho.json`. Raises FileError when that fails."""
    text = json.dumps(sidecar.to_json(), indent=1, allow_nan=False) + "\n"
    with whole_file(Path(folder) / NAME) as temporary:
        temporary.write_bytes(text.encode())


def read_sidecar(folder: Path) -> OrthoSidecar:
    """Read `folder/ortho.json`.

    Raises FileError when the file is missing, is not JSON, or lacks entries.
    """
    path = Path(folder) / NAME
    if not path.is_file():
        raise FileError(path, "does not exist", "run `frontage ortho` first")
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, OSError, RecursionError) as error:
        reason = "it is nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise FileError(path, f"is not valid JSON ({reason})", _AGAIN) from error
    if not isinstance(record, dict):
        raise FileError(path, "does not hold a JSON object", _AGAIN)
    try:
        return OrthoSidecar.from_json(record)
    except ValueError as error:
        raise FileError(path, f"is inconsistent ({error})", _AGAIN) from error
    except MALFORMED as error:
        raise FileError(path, f"an entry is missing or malformed ({error})", _AGAIN) from error


def _raster_to_world(ortho: OrthoImage) -> Float:
    """(4, 4): takes (column, row, y, 1) to world metres."""
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


def _strips(band: Array) -> Iterator[Array]:
    """A band (h, w) in strips of rows, so that a test of every pixel takes little memory."""
    for row in range(0, band.shape[0], _STRIP_ROWS):
        yield band[row : row + _STRIP_ROWS]
