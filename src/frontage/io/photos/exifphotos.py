"""Picture files without any other data: cameras and approximate poses from what the camera noted (EXIF).

The focal length comes from its equivalent on 35 mm film; without one, that of a moderate wide-angle lens is
assumed. Both are only a start for an adjustment that estimates the camera. GPS gives the position, the
compass the heading; the camera is taken to be level.
"""

from pathlib import Path

import numpy as np
from pyproj import CRS, Transformer

from frontage.errors import FileError
from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3
from frontage.io.photos.exif import Exif, read_exif
from frontage.io.photos.imagefile import image_header
from frontage.io.photos.interchange.georeference import east_north_up, to_world
from frontage.io.photos.photoset import PhotoSet, PixelSource
from frontage.io.photos.request import PhotoRequest
from frontage.model import Camera, Estimate, Photo, Provenance

_FILM_MM = 36.0
_USUAL = 1.0  # focal length over the longer side, of 35 mm-equivalent lenses of 36 mm: what many phones have
_SIGMA_STATED, _SIGMA_ASSUMED = 0.03, 0.3  # relative, of the focal length
_SIGMA_CENTRE = 0.01  # of the longer side, of the principal point
_SIGMA_RADIAL = 0.1
_SIGMA_TILT = np.radians(15.0)  # of a camera that is taken to be level
_SIGMA_HEIGHT = 10.0  # m: GPS heights may be above sea or ellipsoid
_LEVEL = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # a level camera that looks north


def read_exif_photos(request: PhotoRequest) -> PhotoSet:
    """The pictures of a request with cameras from EXIF, and approximate poses where EXIF has them.

    The ids are the file names, with their folders where a name occurs twice. The cameras are of the model
    OPENCV and only approximate: their standard errors are in `camera_sigmas`. Raises FileError.
    """
    names = _names(request.files)
    photos, pixels, sigmas = [], {}, {}
    for path, name in zip(request.files, names, strict=True):
        header, exif = image_header(path), read_exif(path)
        turned = header.orientation >= 5
        width, height = (header.height, header.width) if turned else (header.width, header.height)
        camera, sigma = _camera(width, height, exif)
        photos.append(Photo(name, camera, _pose(path, exif, request)))
        pixels[name] = PixelSource(str(path), header.orientation)
        sigmas[name] = sigma
    return PhotoSet(tuple(photos), pixels, (), sigmas)


def _names(files: tuple[Path, ...]) -> list[str]:
    """The names of the files, with as many of their folders as tell them apart."""
    for folders in range(1, 1 + max(len(f.parts) for f in files)):
        names = ["/".join(f.parts[-folders:]) for f in files]
        if len(set(names)) == len(names):
            break
    return names


def _camera(width: int, height: int, exif: Exif) -> tuple[Camera, Float]:
    """The camera and the standard errors of its parameters."""
    longer = max(width, height)
    stated = exif.focal_length_35mm > 0
    focal = longer * (exif.focal_length_35mm / _FILM_MM if stated else _USUAL)
    params = np.array([focal, focal, 0.5 * width, 0.5 * height, 0.0, 0.0, 0.0, 0.0])
    relative = _SIGMA_STATED if stated else _SIGMA_ASSUMED
    centre = _SIGMA_CENTRE * longer
    sigma = np.array(
        [relative * focal, relative * focal, centre, centre, _SIGMA_RADIAL, _SIGMA_RADIAL, 0.01, 0.01]
    )
    return Camera("OPENCV", width, height, params), sigma


def _pose(path: Path, exif: Exif, request: PhotoRequest) -> Estimate[Rigid3] | None:
    """The approximate pose in local metres; None where it is unknown or not wanted."""
    if not request.posed or exif.position is None:
        return None
    if request.world.crs is None:
        raise FileError(path, "has a GPS position, but the scans have no CRS", 'state crs, or pose = "none"')
    latitude, longitude, up = exif.position
    heading = np.radians(exif.heading or 0.0)
    c, s = np.cos(heading), np.sin(heading)
    clockwise = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    geocentric = _geocentric(latitude, longitude, up)
    enu = east_north_up(latitude, longitude, geocentric)
    level = Rigid3("enu", "camera", clockwise @ _LEVEL, np.zeros(3))
    moved = to_world(path.name, CRS.from_epsg(4978), CRS.from_epsg(4979), [enu.after(level)], request.world)
    pose = moved.poses[0]
    local = Rigid3("local", "camera", pose.R, request.world.to_local(pose.t))
    return Estimate(local, _covariance(exif, request), 0.0, Provenance.GIVEN)


def _covariance(exif: Exif, request: PhotoRequest) -> Float:
    stated = request.sigmas or (5.0,) * 3 + (float(np.radians(10.0)),) * 3
    plan = exif.position_error or stated[0]
    turn = stated[5] if exif.heading is not None else np.pi
    sigmas = [plan, plan, max(plan, _SIGMA_HEIGHT), _SIGMA_TILT, _SIGMA_TILT, turn]
    return np.diag(np.square(sigmas))


def _geocentric(latitude: float, longitude: float, up: float) -> Float:
    to_geocentric = Transformer.from_crs("EPSG:4979", "EPSG:4978", always_xy=True)
    return np.array(to_geocentric.transform(longitude, latitude, up))
