"""An ortho-image: pixels on the plane of a facade, each with its position in the world."""

import io
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, readonly
from frontage.model.facade import Facade
from frontage.model.occluder import Occluder

NOT_SEEN = 65535
"""The source of pixels on the facade that no photo and no scan shows."""
INFERRED = 65534
"""The source of pixels on the facade that nothing shows and that symmetry filled."""
_SHOWN_PX = 800  # longest side of the picture in a notebook


@dataclass(frozen=True)
class PhotoOffset:
    """How far behind the surface that the scan measured the photos see the facade.

    value, sigma  m along y of the facade frame, and its standard error
    patches       number of places on the facade that it was measured at
    applied       whether the picture was drawn on the surface moved by it
    """

    value: float
    sigma: float
    patches: int
    applied: bool


@dataclass(frozen=True)
class PhotoRemark:
    """What was found about the photos of an ortho-image.

    code     one of `frontage.errors.CODES`
    message  what was found, and what was done about it
    hint     what the user can do
    """

    code: str
    message: str
    hint: str = ""


@dataclass(frozen=True, eq=False)
class OrthoImage:
    """A facade ortho-image.

    pixels         (h, w, 4) uint8 RGBA, alpha 0 = nodata
    gsd            m per pixel
    corner         (x, z) m facade: outer upper left corner of pixel (0, 0)
    facade         the facade whose plane carries it
    depth          (h, w) float32 m, y of the surface; NaN = not measured, the plane is used
    source         (h, w) uint16: 1 + index into `sources`, 0 = outside, `NOT_SEEN` = on the facade, not
                   seen, `INFERRED` = not seen, filled by symmetry
    sources        names of the photos (or of the scan) that the pixels come from
    gsd_effective  (h, w) float32 m per source pixel (photos) or point spacing (scan)
    intensity      (h, w) float32 0..1 of the scan, NaN = none; or None
    photo_offset   the depth that the photos show; None without photos that overlap
    photos         number of photos among the sources; they come first
    remarks        photos that were left out or turned, and why no photo was used
    occluders      what stood free before the facade
    light          by photo: (3, 3) logarithms by which it is brighter than the picture, per channel: in the
                   middle, and factors of r^2 and r^4 with r = 1 in its corners; for other facades
    """

    pixels: Array
    gsd: float
    corner: tuple[float, float]
    facade: Facade
    depth: Array
    source: Array
    sources: tuple[str, ...]
    gsd_effective: Array
    intensity: Array | None = None
    photo_offset: PhotoOffset | None = None
    photos: int = 0
    remarks: tuple[PhotoRemark, ...] = ()
    occluders: tuple[Occluder, ...] = ()
    light: Mapping[str, Array] = field(default_factory=dict)

    def __post_init__(self) -> None:
        h, w = self.pixels.shape[:2]
        object.__setattr__(self, "pixels", readonly(self.pixels, (h, w, 4), np.uint8, "pixels"))
        object.__setattr__(self, "source", readonly(self.source, (h, w), np.uint16, "source"))
        for name in ("depth", "gsd_effective", "intensity"):
            band = getattr(self, name)
            if band is not None and not _is_one_value(band, (h, w)):
                object.__setattr__(self, name, readonly(band, (h, w), np.float32, name))

    def __repr__(self) -> str:
        """Say which facade it shows, its size and its sources."""
        (w, h), drawn = self.size, ", ".join(self.sources[:3]) + (", ..." if len(self.sources) > 3 else "")
        return f"<OrthoImage {self.facade.id}: {w} x {h} px at {self.gsd:g} m, from {drawn or 'nothing'}>"

    def _repr_png_(self) -> bytes:
        """Show the picture in a notebook, at most 800 px long."""
        from PIL import Image

        step = max(1, -(-max(self.size) // _SHOWN_PX))
        file = io.BytesIO()
        Image.fromarray(np.ascontiguousarray(self.pixels[::step, ::step])).save(file, "PNG")
        return file.getvalue()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self.pixels.shape[1], self.pixels.shape[0]

    def local_from_pixel(self, column_row: Float, relief: bool = True) -> tuple[Float, Bool]:
        """Converts pixels (n, 2), first centre at 0.5, to local points (n, 3) m.

        Also returns where the relief was used, (n,) bool; elsewhere the points lie on the plane.
        """
        cr = np.atleast_2d(np.asarray(column_row, np.float64))
        y, used = self._relief_at(cr) if relief else (np.zeros(len(cr)), np.zeros(len(cr), bool))
        xyz = np.column_stack([self.corner[0] + cr[:, 0] * self.gsd, y, self.corner[1] - cr[:, 1] * self.gsd])
        return self.facade.frame.apply(xyz), used

    def pixel_from_local(self, xyz_local: Float) -> tuple[Float, Float]:
        """Converts local points (n, 3) m to pixels (n, 2) and their depth y (n,) m behind the plane."""
        xyz = self.facade.frame.inverse.apply(np.atleast_2d(xyz_local))
        return np.column_stack(
            [(xyz[:, 0] - self.corner[0]) / self.gsd, (self.corner[1] - xyz[:, 2]) / self.gsd]
        ), xyz[:, 1]

    def pixel_to_world(self, column_row: Float, relief: bool = True) -> tuple[Float, Bool]:
        """Converts pixels (n, 2) to world points (n, 3) m, as `local_from_pixel` does."""
        xyz, used = self.local_from_pixel(column_row, relief)
        return self.facade.world.to_world(xyz), used

    def world_to_pixel(self, xyz_world: Float) -> tuple[Float, Float]:
        """Converts world points (n, 3) m to pixels (n, 2) and their depth y (n,) m behind the plane."""
        return self.pixel_from_local(self.facade.world.to_local(np.atleast_2d(xyz_world)))

    def _relief_at(self, column_row: Float) -> tuple[Float, Bool]:
        """Returns depth y (n,) m at pixels (n, 2), 0 where it was not measured, and where it was."""
        w, h = self.size
        c, r = np.floor(column_row).astype(np.int64).T
        inside = (c >= 0) & (c < w) & (r >= 0) & (r < h)
        y = np.where(inside, self.depth[np.clip(r, 0, h - 1), np.clip(c, 0, w - 1)], np.nan).astype(
            np.float64
        )
        used = np.isfinite(y)
        return np.where(used, y, 0.0), used


def _is_one_value(band: Array, shape: tuple[int, int]) -> bool:
    """Whether a band is one broadcast float32, which a copy would inflate to the size of the picture."""
    return band.shape == shape and band.dtype == np.float32 and not any(band.strides)
