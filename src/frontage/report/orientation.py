"""The section on photos: what orienting them found, as a map, plots of residuals, and tables."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from frontage.report.cameramap import CameraMap, camera_map
from frontage.report.data import ReportData
from frontage.report.numbers import Fact
from frontage.report.residuals import ResidualPlots, residual_plots

VERDICTS = {
    "confirmed": "confirmed by the scan",
    "tied": "held by other photos only",
    "carried": "held by the other cameras of their rig",
    "plain": "not confirmed, too little of the scan in view",
}
"""The verdicts on poses in plain words."""

_SOURCES = {
    "intensity": "the intensity of the scan",
    "colour": "the colours of the scan",
    "geometry": "the shape of the scan",
}
_UNKNOWN = "not known"
_NONE = "–"


@dataclass(frozen=True)
class PhotoRow:
    """A line of the table of photos, as text."""

    photo: str
    position: str
    sigma_position: str
    sigma_angles: str
    control: str
    ties: str
    check: str
    detectable: str
    verdict: str
    css: str
    rival: str


@dataclass(frozen=True)
class OrientationSection:
    """The section: facts, map, verdicts that occur (css class, words), rows, plots, photos without a pose."""

    facts: list[Fact]
    map: CameraMap | None
    verdicts: list[tuple[str, str]]
    rows: list[PhotoRow]
    plots: ResidualPlots
    unoriented: list[dict[str, str]]


def orientation_section(data: ReportData) -> OrientationSection | None:
    """What the page says of the photos; None where none was to be oriented."""
    if data.orientation is None:
        return None
    record = data.orientation.record
    photos, unoriented = record["photos"], record["unoriented"]
    if not photos and not unoriented:
        return None
    found = {p["verdict"] for p in photos}
    return OrientationSection(
        orientation_facts(record),
        camera_map(data),
        [(name, words) for name, words in VERDICTS.items() if name in found],
        [_row(p) for p in photos],
        residual_plots(photos),
        unoriented,
    )


def orientation_facts(record: dict[str, Any]) -> list[Fact]:
    """What holds for all photos together; the lines of the adjustment only if there was one."""
    photos = record["photos"]
    verdicts = Counter(p["verdict"] for p in photos)
    words = "; ".join(f"{verdicts[name]} {text}" for name, text in VERDICTS.items() if verdicts[name])
    facts = [
        Fact("Oriented", f"{len(photos)} of {len(photos) + len(record['unoriented'])} photos", words),
        Fact("Compared with", _SOURCES.get(record["source"], record["source"])),
    ]
    if not photos:
        return facts
    facts += [_rig_fact(rig) for rig in record.get("rigs", ())]
    sigma = record["sigma_points"]
    spread = "" if sigma is None else f"median σ east, north, up: {lengths(sigma)}"
    factors = ", ".join(f"{name} {value:.2f}" for name, value in record["factors"].items())
    unit = _UNKNOWN if record["sigma0"] is None else f"{record['sigma0']:.3f}"
    return [
        *facts,
        Fact("Tie points", f"{record['points']:,}", spread),
        Fact("Variance factors", factors or _NONE, "square roots: σ found / σ assumed, per group"),
        Fact("σ0", unit, "standard deviation of unit weight with these factors"),
        Fact("Redundancy", f"{record['redundancy']:,}", "observations more than unknowns"),
        Fact("Rejected", f"{record['rejected']:,}", "measurements in photos, as gross errors"),
    ]


def _rig_fact(rig: dict[str, Any]) -> Fact:
    """The cameras and exposures of a rig, and its relative poses where they were estimated."""
    cameras, exposures = rig["cameras"], rig["exposures"]
    most = max(len(e["photos"]) for e in exposures)
    times = "1 exposure" if len(exposures) == 1 else f"{len(exposures)} exposures"
    size = f"{times} of up to {most} photos by {len(cameras)} cameras"
    estimated = [
        f"{c['camera']} at {lengths([row[3] for row in c['body_from_camera']])} "
        f"(σ {lengths(c['sigma_position'])}; {_angles(c['sigma_angles'])})"
        for c in cameras
        if c["estimated"]
    ]
    return Fact(f"Rig: {rig['rig']}", size, "; ".join(estimated) or "relative poses held fixed")


def _row(photo: dict[str, Any]) -> PhotoRow:
    rival, detectable, check = photo["rival"], photo["detectable"], photo["check_rmse"]
    rig = photo.get("rig")
    return PhotoRow(
        f"{photo['photo']} ({rig}, {photo['exposure']})" if rig else photo["photo"],
        ", ".join(f"{v:.3f}" for v in photo["center"]),
        lengths(photo["sigma_center"]),
        _angles(photo["sigma_angles"]),
        _points(photo["control_points"], photo["control_rms"]),
        _points(photo["tie_points"], photo["tie_rms"]),
        _NONE if check is None else lengths([check]),
        _NONE if detectable is None else f"{detectable:.1f} px",
        VERDICTS.get(photo["verdict"], photo["verdict"]),
        photo["verdict"],
        "" if rival is None or rival <= 0 else f"best other place: {rival:.0%}",
    )


def _points(number: int, rms: float | None) -> str:
    return f"{number:,}" if not number or rms is None else f"{number:,} ({rms:.2f} px)"


def lengths(metres: Sequence[float | None]) -> str:
    """Lengths in m as text with one unit that suits the largest: mm, cm or m."""
    values = np.array(metres, np.float64)  # None becomes NaN
    if not np.isfinite(values).all():
        return _UNKNOWN
    largest = float(np.abs(values).max())
    factor, digits, unit = (1, 2, "m")
    if largest < 0.0995:
        factor, digits, unit = (1000, 1 if largest < 0.00995 else 0, "mm")
    elif largest < 9.95:
        factor, digits, unit = (100, 1, "cm")
    return ", ".join(f"{factor * v:.{digits}f}" for v in values) + f" {unit}"


def _angles(degrees: Sequence[float | None]) -> str:
    values = np.array(degrees, np.float64)
    if not np.isfinite(values).all():
        return _UNKNOWN
    digits = 4 if values.max() < 0.1 else 2
    return ", ".join(f"{v:.{digits}f}" for v in values) + "°"
