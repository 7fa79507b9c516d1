"""Filling a COLMAP database with photos, key points and verified pairs."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from frontage.geometry.arrays import Int
from frontage.model import Camera, Photo
from frontage.orientation.nouns import KeyPoints, PairMatches
from frontage.orientation.ties import colmap as door


def fill(
    colmap: Any,
    path: Path,
    photos: Sequence[Photo],
    keypoints: Sequence[KeyPoints],
    pairs: Iterable[PairMatches],
) -> None:
    """Writes a new database; image k + 1 is photo k, and photos share a camera when theirs are equal."""
    database = colmap.Database.open(path)
    try:
        cameras: dict[tuple[object, ...], int] = {}
        for k, (photo, points) in enumerate(zip(photos, keypoints, strict=True)):
            camera = _camera_number(colmap, database, cameras, photo.camera)
            _write_image(colmap, database, k + 1, camera, photo, points)
        for pair in pairs:
            _write_pair(colmap, database, pair, photos)
    finally:
        database.close()


def _camera_number(colmap: Any, database: Any, cameras: dict[tuple[object, ...], int], camera: Camera) -> int:
    """Number of the camera, with a rig of its own, written when it is new."""
    key = (camera.model, camera.width, camera.height, camera.params.tobytes())
    if key not in cameras:
        cameras[key] = number = len(cameras) + 1
        ours = door.camera_to_colmap(colmap, camera, number)
        database.write_camera(ours, use_camera_id=True)
        rig = colmap.Rig(rig_id=number)
        rig.add_ref_sensor(ours.sensor_id)
        database.write_rig(rig, use_rig_id=True)
    return cameras[key]


def _write_image(
    colmap: Any, database: Any, number: int, camera: int, photo: Photo, points: KeyPoints
) -> None:
    image = colmap.Image(name=f"{number:06d}", camera_id=camera, image_id=number)
    database.write_image(image, use_image_id=True)
    frame = colmap.Frame(frame_id=number, rig_id=camera)
    frame.add_data_id(image.data_id)
    database.write_frame(frame, use_frame_id=True)
    database.write_keypoints(number, np.ascontiguousarray(points.pixels, np.float32))


def _write_pair(colmap: Any, database: Any, pair: PairMatches, photos: Sequence[Photo]) -> None:
    geometry = colmap.TwoViewGeometry()
    geometry.config = int(colmap.TwoViewGeometryConfiguration.CALIBRATED)
    geometry.inlier_matches = _uint32(pair.rows)
    geometry.cam2_from_cam1 = colmap.Rigid3d(colmap.Rotation3d(pair.rotation), pair.direction)
    geometry.E = colmap.essential_matrix_from_pose(geometry.cam2_from_cam1)
    geometry.tri_angle = pair.angle
    database.write_matches(pair.first + 1, pair.second + 1, _uint32(pair.rows))
    database.write_two_view_geometry(pair.first + 1, pair.second + 1, geometry)


def _uint32(rows: Int) -> Any:
    return np.ascontiguousarray(rows, np.uint32)
