"""The schedule of openings (window and door schedule), with a small picture of each from the ortho-image."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from frontage.exports.facades import FacadePicture
from frontage.exports.survey import Survey
from frontage.geometry.arrays import Array, Float
from frontage.io.tables.table import Column, Table, Value, find
from frontage.model import Elements

_MARGIN = 0.15  # of the size of an opening: how much wall its picture shows around it
_PICTURE_PX = 160  # longest side of a picture
_JPEG_QUALITY = 85
MATERIAL = Column("material", "text", "material of frame and leaf; neither scans nor photos tell")
_SHOWN = (
    "id", "address", "kind", "shape", "floor", "number", "bay", "width", "height", "sill", "head", "depth",
    "mullions", "transoms", "frame_width", "material", "sigma_width", "sigma_height", "sigma_bottom",
    "sigma_top", "sigma_depth", "provenance", "confidence",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Schedule:
    """The rows of the schedule, a picture (JPEG) per row, b"" where there is none, and what is missing."""

    columns: tuple[Column, ...]
    rows: tuple[tuple[Value, ...], ...]
    pictures: tuple[bytes, ...]
    about: tuple[str, ...]


def schedule(
    survey: Survey, tables: Sequence[Table], pictures: Mapping[str, bytes], heights: str
) -> Schedule:
    """Return the schedule of all openings.

    tables    those of `survey_tables`
    pictures  those of `opening_pictures` of all facades
    heights   what heights refer to, such as "above DHHN2016 height"
    """
    openings = find(tables, "openings")
    known = {column.name: column for column in (*openings.columns, MATERIAL)}
    values = {name: openings.values(name) for name in _SHOWN if name != MATERIAL.name}
    values[MATERIAL.name] = ["unknown"] * len(openings)
    rows = tuple(zip(*(values[name] for name in _SHOWN), strict=True))
    ids = [str(value) for value in openings.values("id")]
    return Schedule(
        columns=tuple(known[name] for name in _SHOWN),
        rows=rows,
        pictures=tuple(pictures.get(name, b"") for name in ids),
        about=(
            f"Lengths are in metres. Sill and head are heights {heights}.",
            "Width and height are clear of the wall's edges; depth is that of the frame behind the wall.",
            "Standard errors (sigma) are those of the borders on the facade; an empty cell means not known.",
            *survey.left_out,
        ),
    )


def opening_pictures(picture: FacadePicture, elements: Elements) -> dict[str, bytes]:
    """Return a small JPEG of every opening of a facade with some wall around it, by the opening's id."""
    image = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    gsd = picture.gsd * picture.size[0] / image.shape[1]  # the JPEG of a very large image is reduced
    return {o.id: _crop(image, o.ring, picture.corner, gsd) for o in elements.openings}


def _crop(image: Array, ring: Float, corner: tuple[float, float], gsd: float) -> bytes:
    low, high = ring.min(0), ring.max(0)
    margin = _MARGIN * (high - low).max()
    c0, c1 = (np.array([low[0] - margin, high[0] + margin]) - corner[0]) / gsd
    r0, r1 = (corner[1] - np.array([high[1] + margin, low[1] - margin])) / gsd
    h, w = image.shape[:2]
    rows, columns = slice(max(int(r0), 0), min(int(r1) + 1, h)), slice(max(int(c0), 0), min(int(c1) + 1, w))
    part = image[rows, columns]
    if part.size == 0:
        return b""
    scale = _PICTURE_PX / max(part.shape[:2])
    if scale < 1:
        size = tuple(max(1, round(n * scale)) for n in part.shape[1::-1])
        part = cv2.resize(part, size, interpolation=cv2.INTER_AREA)
    return bytes(cv2.imencode(".jpg", part, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[1])
