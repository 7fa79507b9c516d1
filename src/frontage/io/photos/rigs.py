"""Joins photos with what the user states of their rigs."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from frontage.geometry.rigid import Rigid3
from frontage.io.files import reading
from frontage.io.photos.photoset import PhotoSet
from frontage.io.photos.rigfile import StatedRig, nothing_found, read_rig_file
from frontage.model import Camera, Estimate, MountedCamera


def with_stated_rigs(photos: PhotoSet, path: str, estimated: bool) -> PhotoSet:
    """The photos with the rigs of a rig file in place of those that their cameras' file states.

    estimated  whether the cameras of the photos are only a start: then calibrations of the rig file replace
               them and are exact

    Raises FileError for a file that cannot be used, or that belongs to other photos.
    """
    stated = read_rig_file(path)
    paths = {photo.id: photos.pixels[photo.id].path for photo in photos.photos}
    with reading(path, "rig", "rename the photos or correct the prefixes"):
        rigs = tuple(rig.with_photos(paths) for rig in stated)
        found = [photo for rig in rigs for exposure in rig.exposures for photo in exposure.photos]
        if len(set(found)) < len(found):
            raise ValueError("a photo belongs to two rigs")
    if not found:
        raise nothing_found(path)
    notes = list(photos.notes)
    if photos.rigs:
        notes.append(f"{path}: its rigs replace those of the file with the cameras")
    if len(found) < len(paths):
        notes.append(f"{path}: {len(paths) - len(found)} photos belong to no camera of a rig")
    calibrated = any(camera.model for rig in stated for camera in rig.cameras)
    if calibrated and not estimated:
        notes.append(f"{path}: its calibrations are not used, because [photos] cameras states others")
    joined = replace(photos, rigs=rigs, notes=tuple(notes))
    with reading(path, "rig", "correct camera_model_name and camera_params"):
        return _calibrated(joined, stated) if calibrated and estimated else joined


def _calibrated(photos: PhotoSet, stated: Sequence[StatedRig]) -> PhotoSet:
    """The photos with the stated calibrations. Raises ValueError for parameters that no camera can have."""
    of = {
        photo: listed.cameras[k]
        for rig, listed in zip(photos.rigs, stated, strict=True)
        for exposure in rig.exposures
        for photo, k in zip(exposure.photos, exposure.cameras, strict=True)
    }
    placed, sigmas = list(photos.photos), dict(photos.camera_sigmas)
    for number, photo in enumerate(photos.photos):
        known = of.get(photo.id)
        if known is not None and known.model is not None and known.params is not None:
            camera = Camera(known.model, photo.camera.width, photo.camera.height, known.params)
            placed[number] = replace(photo, camera=camera)
            sigmas[photo.id] = np.zeros(len(known.params))
    return replace(photos, photos=tuple(placed), camera_sigmas=sigmas)


def with_mount_sigmas(photos: PhotoSet, position: float, angle: float) -> PhotoSet:
    """The photos with standard errors, m and rad, of the relative poses that are stated without any.

    The camera that is the body itself stays exact: the others are relative to it.
    """
    covariance = np.diag(np.square([position] * 3 + [angle] * 3))

    def one(camera: MountedCamera) -> MountedCamera:
        mount = camera.body_from_camera
        if mount is None or mount.covariance.any() or _is_identity(mount.value):
            return camera
        return replace(camera, body_from_camera=Estimate(mount.value, covariance, 0.0, mount.provenance))

    rigs = tuple(replace(rig, cameras=tuple(one(c) for c in rig.cameras)) for rig in photos.rigs)
    return replace(photos, rigs=rigs)


def _is_identity(pose: Rigid3) -> bool:
    return bool(np.allclose(pose.matrix, np.eye(4), rtol=0, atol=1e-12))
