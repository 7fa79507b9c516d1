"""What the report shows: plain values and encoded pictures, gathered by the pipeline."""

from dataclasses import dataclass
from typing import Any

from frontage.geometry.arrays import Array, Float
from frontage.model import Elements, Facade


@dataclass(frozen=True, eq=False)
class OrthoView:
    """An ortho-image for the page: JPEG bytes (of any size), and its raster in the facade frame.

    gsd m per pixel of the full image, size (w, h) px of the full image, corner (x, z) m of its upper left
    edge, sources with the share of the picture each gave, seen = share of pixels that are not nodata.
    """

    jpeg: bytes
    gsd: float
    size: tuple[int, int]
    corner: tuple[float, float]
    sources: tuple[str, ...]
    seen: float | None = None
    relief: float | None = None

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """x0, z0, x1, z1 m of the image's edges."""
        (x, z), (w, h) = self.corner, self.size
        return x, z - h * self.gsd, x + w * self.gsd, z


@dataclass(frozen=True, eq=False)
class PictureView:
    """A picture of a facade: PNG bytes, its edges x0, z0, x1, z1 in m of the facade frame, its caption."""

    png: bytes
    extent: tuple[float, float, float, float]
    caption: str


@dataclass(frozen=True, eq=False)
class WindowView:
    """A picture of what the bars of an opening were found from.

    jpeg    its bytes; empty where the page has no room for it
    file    its name in the facade's folder
    panels  what it shows
    """

    opening: str
    jpeg: bytes
    file: str
    panels: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class FacadeView:
    """A facade, its ortho-image where there is one, its folder relative to the page, and its warnings.

    elements  its openings and protrusions, None where they were not looked for or could not be judged
    evidence  pictures of what they were found from; files: names in the folder that the page links to
    notes     on the openings
    windows   pictures of what window bars were found from
    """

    facade: Facade
    ortho: OrthoView | None
    folder: str
    warnings: tuple[dict[str, str], ...] = ()
    elements: Elements | None = None
    evidence: tuple[PictureView, ...] = ()
    files: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    windows: tuple[WindowView, ...] = ()


@dataclass(frozen=True, eq=False)
class BuildingView:
    """A building: its record, plan points (k, 2) m local, facades, warnings, PNG of its model (or empty).

    `about_model`: its entry in model/report.json.
    """

    record: dict[str, Any]
    plan: Float
    facades: tuple[FacadeView, ...]
    warnings: tuple[dict[str, str], ...] = ()
    model: bytes = b""
    about_model: dict[str, Any] | None = None


@dataclass(frozen=True, eq=False)
class RegistrationView:
    """registration/report.json and its plan, m local: walls (k, 2, 2), points (n, 2) before and after.

    origin (3,) m is the world position of the local origin.
    """

    record: dict[str, Any]
    origin: Float
    walls: Float
    before: Float
    after: Float


@dataclass(frozen=True, eq=False)
class OrientationView:
    """orientation/report.json; origin (3,) m is the world position of the local origin."""

    record: dict[str, Any]
    origin: Float


@dataclass(frozen=True, eq=False)
class ReportData:
    """The whole page: manifest, buildings, the street's plan (k, 2) m local, building number (k,) or -1.

    files  of the model, relative to the page
    """

    manifest: dict[str, Any]
    buildings: tuple[BuildingView, ...]
    street: Float
    street_building: Array
    registration: RegistrationView | None = None
    files: tuple[str, ...] = ()
    orientation: OrientationView | None = None
