"""The documented files of a run (DESIGN section 6) as the claims that the scorers compare with the truth."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import FileError
from frontage.evaluation.result import BORDERS, FoundBar, FoundOpening, FoundPose, FoundProtrusion
from frontage.evaluation.truth import Truth
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.io.citymodels.openings import CityOpening
from frontage.io.poses import nearest_rotation
from frontage.model import WorldRef

_ROUNDED = 1e-3  # of printed rotation matrices


def json_openings(table: Any, path: Path, frame: Rigid3, world: WorldRef) -> Iterator[FoundOpening]:
    """The openings of an openings.json; `frame` = local_from_facade of its facade. Raises FileError.

    Nothing is claimed of the bars of an opening whose `glazing` is null or not resolved; and of no opening's,
    where none has `glazing` or any bar.
    """
    entries = _entries(table, "openings", path)
    bars = [entry.get("bars") for entry in entries]
    barred = any(any(b.values()) if isinstance(b, dict) else b is not None for b in bars)
    for entry in entries:
        told = bool((entry["glazing"] or {}).get("resolved")) if "glazing" in entry else barred
        try:
            yield _opening(entry if told else entry | {"bars": None}, frame, world)
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise _lacking(path, entry.get("id", "an opening"), error) from None


def _opening(o: dict[str, Any], frame: Rigid3, world: WorldRef) -> FoundOpening:
    ring = world.to_local(np.array(o["outline_world"], np.float64))
    bars = o.get("bars")
    return FoundOpening(
        str(o["id"]),
        str(o["kind"]),
        ring,
        _plain(o.get("depth")),
        o.get("shape"),
        None if bars is None else tuple(_bars(bars, frame)),
        sigma=_sigma(o.get("sigma") or {}),
    )


def json_protrusions(table: Any, path: Path, world: WorldRef) -> Iterator[FoundProtrusion]:
    """The protrusions of a protrusions.json. Raises FileError."""
    for entry in _entries(table, "protrusions", path):
        try:
            ring = world.to_local(np.array(entry["outline_world"], np.float64))
            sigma = entry.get("sigma") or {}
            yield FoundProtrusion(
                str(entry["id"]),
                str(entry["kind"]),
                ring,
                _plain(sigma.get("border")),
                _plain(sigma.get("front")),
            )
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise _lacking(path, entry.get("id", "a protrusion"), error) from None


def _plain(value: Any) -> float | None:
    return None if value is None else float(value)


def _bars(bars: dict[str, Any], frame: Rigid3) -> Iterator[FoundBar]:
    """Bars `{"position": x or z, "extent": [from, to]}` as lines on the facade's plane."""
    for axis in ("vertical", "horizontal"):
        for b in bars.get(axis, ()):
            across, along = np.full(2, float(b["position"])), np.array(b["extent"], np.float64)
            x, z = (across, along) if axis == "vertical" else (along, across)
            yield FoundBar(axis, frame.apply(np.column_stack([x, np.zeros(2), z])))


def _sigma(sigma: dict[str, Any]) -> dict[str, float]:
    """Standard errors by border, one for all of them ("border") counting for those not named, and depth."""
    named = {name: sigma.get(name, sigma.get("border")) for name in BORDERS} | {"depth": sigma.get("depth")}
    return {name: float(value) for name, value in named.items() if value is not None}


def city_opening(o: CityOpening, number: int, world: WorldRef) -> FoundOpening:
    """A Window or Door surface of the LoD3 model."""
    a = o.about
    counts = [a.get("n_vertical"), a.get("n_horizontal")]
    judged = None not in counts and a.get("bars") != "not measured"
    sigma = {"border": a.get("sigma_border"), "depth": a.get("sigma_depth")}
    return FoundOpening(
        str(a.get("id", f"{o.kind} {number}")),
        o.kind,
        world.to_local(o.ring),
        _plain(a.get("depth")),
        counts=(int(counts[0] or 0), int(counts[1] or 0)) if judged else None,
        sigma=_sigma(sigma),
        coarse=True,
    )


def photo_poses(table: Any, path: Path, world: WorldRef) -> list[FoundPose]:
    """Poses of orientation/report.json: camera_from_world (3x4) and center. Raises FileError."""
    out = []
    for entry in _entries(table, "photos", path):
        try:
            R = nearest_rotation(np.array(entry["camera_from_world"], np.float64)[:, :3], _ROUNDED)
            place = world.to_local(np.array(entry["center"], np.float64))
            out.append(
                FoundPose(
                    str(entry["photo"]),
                    Rigid3("local", "camera", R.T, place),
                    _three(entry.get("sigma_center")),
                    _three(entry.get("sigma_angles"), np.pi / 180),
                )
            )
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise _lacking(path, entry.get("photo", "a photo"), error) from None
    return out


def scan_poses(table: Any, path: Path, truth: Truth) -> list[FoundPose]:
    """Poses of registration/report.json: `matrix` takes coordinates to the world, the scanner's own where
    `from` is "scanner", else the file's as they were given.

    The covariance (m, rad) is of the scanner's place and the rotation about it. Scans that the truth does
    not know are left out. Raises FileError.
    """
    known = {pose.name.rsplit("/", 1)[-1]: pose for pose in truth.scans}
    known |= {name.rsplit(":", 1)[0]: pose for name, pose in known.items()}
    out = []
    for entry in _entries(table, "scans", path):
        try:
            scan = known.get(str(entry["scan"]).rsplit("/", 1)[-1])
            if scan is None:
                continue
            M = np.array(entry["matrix"], np.float64).reshape(4, 4)
            R, place = nearest_rotation(M[:3, :3], _ROUNDED), M[:3, 3]
            if entry.get("from") != "scanner":
                R, place = R @ scan.given.R, M[:3, :3] @ truth.world.to_world(scan.given.t) + place
            pose = Rigid3("local", "scanner", R, truth.world.to_local(place))
            sigma = np.sqrt(np.diag(np.array(entry["covariance"], np.float64)))
            out.append(FoundPose(scan.name, pose, sigma[:3], sigma[3:]))
        except (KeyError, TypeError, ValueError, IndexError) as error:
            raise _lacking(path, entry.get("scan", "a scan"), error) from None
    return out


def _three(value: Any, scale: float = 1.0) -> Float | None:
    """Three numbers, or one for all three; None where there is none."""
    return None if value is None else np.broadcast_to(np.asarray(value, np.float64), 3) * scale


def _entries(table: Any, key: str, path: Path) -> list[dict[str, Any]]:
    """A list of objects, or the one under `key`."""
    rows = table.get(key) if isinstance(table, dict) else table
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise FileError(path, f"is no list of {key}", "make it again")
    return rows


def _lacking(path: Path, item: object, error: Exception) -> FileError:
    return FileError(path, f"{item}: lacks or garbles {error}", "make it again")
