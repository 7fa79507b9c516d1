"""The files of orientation: key points and matches on the way, report.json and a COLMAP model at the end."""

from pathlib import Path
from typing import Any

import numpy as np

from frontage.errors import FileError
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.io.arrayfiles import read_arrays
from frontage.io.files import MALFORMED
from frontage.model import Camera, Estimate, MountedCamera, Photo, Provenance, Rig, WorldRef
from frontage.orientation import KeyPoints, Orientation, OrientedPhoto, PairMatches
from frontage.pipeline.store.files import read_json, write_arrays

REPORT = "report.json"
_AGAIN = "run `frontage orient` again"
_RESIDUALS = 200  # of a photo that the report keeps


def save_key_points(path: Path, points: KeyPoints) -> None:
    """Write the key points of a photo."""
    write_arrays(
        path,
        {
            "pixels": points.pixels,
            "scale": points.scale,
            "descriptors": points.descriptors,
            "sharpness": np.array(points.sharpness),
        },
    )


def load_key_points(path: Path) -> KeyPoints:
    """Return the key points of a photo. Raises FileError if they are missing or damaged."""
    arrays = read_arrays(path, _AGAIN)
    try:
        return KeyPoints(arrays["pixels"], arrays["scale"], arrays["descriptors"], float(arrays["sharpness"]))
    except (KeyError, ValueError, TypeError) as error:
        raise FileError(path, f"is damaged ({error})", _AGAIN) from None


def save_matches(path: Path, pairs: list[PairMatches]) -> None:
    """Write the matches of one photo with others."""
    width = [len(p.rows) for p in pairs]
    rows = np.concatenate([np.empty((0, 2), np.int64), *(p.rows for p in pairs)])
    numbers = np.array([(p.first, p.second) for p in pairs], np.int64).reshape(-1, 2)
    about = np.array([(p.angle, p.rival) for p in pairs], np.float64).reshape(-1, 2)
    write_arrays(
        path,
        {
            "numbers": numbers,
            "width": np.array(width, np.int64),
            "rows": rows,
            "rotation": np.array([p.rotation for p in pairs]).reshape(-1, 3, 3),
            "direction": np.array([p.direction for p in pairs]).reshape(-1, 3),
            "about": about,
        },
    )


def load_matches(path: Path) -> list[PairMatches]:
    """Return the matches of one photo with others. Raises FileError if they are missing or damaged."""
    a = read_arrays(path, _AGAIN)
    try:
        ends = np.cumsum(a["width"])[:-1]
        return [
            PairMatches(int(n[0]), int(n[1]), rows, R, d, float(about[0]), float(about[1]))
            for n, rows, R, d, about in zip(
                a["numbers"],
                np.split(a["rows"], ends),
                a["rotation"],
                a["direction"],
                a["about"],
                strict=True,
            )
        ]
    except (KeyError, ValueError, IndexError) as error:
        if "width" in a and not len(a["width"]):
            return []
        raise FileError(path, f"is damaged ({error})", _AGAIN) from None


def report_record(found: Orientation, given: tuple[Photo, ...], world: WorldRef) -> dict[str, Any]:
    """`orientation/report.json` (DESIGN section 6): poses, standard errors, what supports them."""
    by_id = {photo.id: photo for photo in given}
    taken = {name: (rig.name, e.name) for rig in found.rigs for e in rig.exposures for name in e.photos}
    return {
        "photos": [
            {**_photo_record(p, by_id[p.photo.id], world), **_taken_record(taken.get(p.photo.id))}
            for p in found.photos
        ],
        "unoriented": [{"photo": u.photo, "code": u.code, "reason": u.reason} for u in found.unoriented],
        "source": found.source,
        "points": len(found.points),
        "sigma_points": np.median(found.sigma_points, axis=0).tolist() if len(found.points) else None,
        "factors": found.factors,
        "sigma0": _finite(found.sigma0),
        "redundancy": found.redundancy,
        "rejected": found.rejected,
        "rigs": [_rig_record(rig) for rig in found.rigs],
        "notes": list(found.notes),
    }


def _taken_record(of: tuple[str, str] | None) -> dict[str, Any]:
    """The rig and the exposure of a photo, null for a photo on its own."""
    return {"rig": of and of[0], "exposure": of and of[1]}


def _rig_record(rig: Rig) -> dict[str, Any]:
    return {
        "rig": rig.name,
        "cameras": [_mount_record(camera) for camera in rig.cameras],
        "exposures": [
            {
                "exposure": e.name,
                "photos": {rig.cameras[k].name: name for name, k in zip(e.photos, e.cameras, strict=True)},
            }
            for e in rig.exposures
        ],
    }


def _mount_record(camera: MountedCamera) -> dict[str, Any]:
    """How a camera sits on the body of its rig; null where nothing is known of it."""
    mount = camera.body_from_camera
    if mount is None:
        return {"camera": camera.name, "body_from_camera": None, "estimated": False}
    return {
        "camera": camera.name,
        "body_from_camera": mount.value.matrix[:3].tolist(),
        "estimated": bool(mount.covariance.any()),
        "sigma_position": mount.sigma[:3].tolist(),
        "sigma_angles": np.degrees(mount.sigma[3:]).tolist(),
    }


def _photo_record(p: OrientedPhoto, given: Photo, world: WorldRef) -> dict[str, Any]:
    estimate = p.photo.local_from_camera
    assert estimate is not None
    pose = estimate.value
    centre = world.to_world(pose.t)
    start = given.local_from_camera
    step = max(1, -(-len(p.residual) // _RESIDUALS))
    return {
        "photo": p.photo.id,
        "camera_from_world": np.column_stack([pose.R.T, -pose.R.T @ centre]).tolist(),
        "center": centre.tolist(),
        "given": None if start is None else world.to_world(start.value.t).tolist(),
        "sigma_center": estimate.sigma[:3].tolist(),
        "sigma_angles": np.degrees(estimate.sigma[3:]).tolist(),
        "covariance": estimate.covariance.tolist(),
        "camera": _camera_record(p),
        "control_points": p.control,
        "control_rms": _finite(p.control_rms),
        "control_rms_200": _finite(p.precise_rms),
        "tie_points": p.ties,
        "tie_rms": _finite(p.tie_rms),
        "check_rmse": _finite(p.check_rms),
        "redundancy": _finite(p.redundancy),
        "detectable": _finite(p.detectable),
        "verdict": p.verdict,
        "rival": _finite(p.rival),
        "residuals": np.column_stack([p.residual_at, p.residual])[::step].round(3).tolist(),
    }


def _camera_record(p: OrientedPhoto) -> dict[str, Any]:
    camera = p.photo.camera
    return {
        "model": camera.model,
        "width": camera.width,
        "height": camera.height,
        "params": camera.params.tolist(),
        "sigma": p.camera_sigma.tolist(),
    }


def load_report(folder: Path) -> dict[str, Any]:
    """Return `report.json` of a folder. Raises FileError if it is missing or damaged."""
    path = folder / REPORT
    try:
        return dict(read_json(path))
    except (OSError, ValueError) as error:
        raise FileError(path, f"is damaged ({error})", _AGAIN) from None


def oriented_photos(folder: Path, world: WorldRef) -> dict[str, Photo]:
    """Return the oriented photos by their ids, with covariances. Raises FileError if damaged."""
    try:
        return {str(entry["photo"]): _photo(entry, world) for entry in load_report(folder)["photos"]}
    except MALFORMED as error:
        raise FileError(folder / REPORT, f"is damaged ({error})", _AGAIN) from None


def _photo(entry: dict[str, Any], world: WorldRef) -> Photo:
    about = entry["camera"]
    camera = Camera(about["model"], about["width"], about["height"], np.array(about["params"], np.float64))
    R: Float = np.array(entry["camera_from_world"], np.float64)[:, :3].T
    pose = Rigid3("local", "camera", R, world.to_local(np.array(entry["center"], np.float64)))
    covariance = np.array(entry["covariance"], np.float64)
    return Photo(entry["photo"], camera, Estimate(pose, covariance, 0.0, Provenance.MEASURED))


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
