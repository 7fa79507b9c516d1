"""Refusal of files whose coordinates are in degrees, because tolerances in metres do not apply to them."""

from pathlib import Path

from frontage.errors import CrsError, UnsupportedFormat
from frontage.io.crs import parse_crs


def refuse_degrees(path: Path, crs: str | None) -> None:
    """Raise UnsupportedFormat when the CRS that a file states is geographic; an unknown CRS is accepted."""
    if not crs or crs.startswith("#"):
        return
    try:
        degrees = parse_crs(crs, str(path)).is_geographic
    except CrsError:
        return
    if degrees:
        raise UnsupportedFormat(
            path, f"its coordinates are in degrees ({crs})", "transform it to a projected CRS"
        )
