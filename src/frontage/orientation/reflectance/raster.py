"""Reflectance images: the picture that a scan gives by itself, with a 3-D point behind its pixels.

Paper B (Becker and Haala 2008, section 2.2.2) shows the intensities of a scan in the raster in which they
were measured and looks for key points there. `raster_reflectance` makes that picture, `panorama_reflectance`
takes its place for clouds without a raster, and `facade_reflectance` shows the scan as an elevation.

Tones are corrected for range and incidence, cut off at 1 % and 99 %, drawn by their square roots (close to
what a photo does), and equalised locally (CLAHE, Zuiderveld 1994).
"""

from dataclasses import dataclass

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Bool, Float, Int, freeze
from frontage.geometry.rigid import Rigid3
from frontage.model import Camera, Estimate, Photo, Provenance, Scan
from frontage.orientation.reflectance.render import render, spread
from frontage.orientation.reflectance.surface import ScannedSurface, point_tones, scanned_surface

_HOLE_PX = 3  # widest hole that is closed with the tones around it
_CLIP = (0.01, 0.99)  # quantiles of the tones that become black and white
_CLAHE = 2.0  # limit of the local contrast
_TILES = 8
_JUMP = 3.0  # times the usual distance of neighbours: beyond, two pixels lie on different surfaces
_SAMPLED = 400  # rows and columns that tell how the raster lies
_VIEWS = 8  # pinhole cameras that look around a station
_ACROSS, _UP, _DOWN = np.radians((32.0, 62.0, 30.0))  # what each of them sees to each side, up and down
_FOCAL_PX = (150.0, 2500.0)
_THICK_M = 0.7  # before and behind a facade that is drawn on it
_STATIONS = 64  # more origins are a trajectory


@dataclass(frozen=True, eq=False)
class ReflectanceImage:
    """A picture of a scan.

    pixels  (h, w) uint8; 0 where the scan shows nothing
    xyz     (h, w, 3) float64 m local, the point that a pixel shows; NaN where nothing was measured
    known   (h, w) bool, pixels with a tone: those with a point, and holes of up to 3 px that were closed
    """

    pixels: Array
    xyz: Float
    known: Bool

    def __post_init__(self) -> None:
        h, w = self.pixels.shape
        freeze(self, pixels=((h, w), np.uint8), xyz=((h, w, 3), np.float64), known=((h, w), np.bool_))

    def points(self, at: Float) -> Float:
        """Returns the 3-D points (n, 3) m local at positions (n, 2) px, column and row, first centre at 0.5.

        Between four pixels of one surface points are interpolated; elsewhere the point of the nearest pixel
        counts. NaN where that has none.
        """
        h, w = self.pixels.shape
        here = np.asarray(at, np.float64) - 0.5
        corner = np.clip(np.floor(here), 0, (w - 2, h - 2)).astype(np.int64)
        share = np.clip(here - corner, 0.0, 1.0)
        column, row = corner.T
        four = np.stack([self.xyz[row + r, column + c] for r in (0, 1) for c in (0, 1)], axis=1)
        across, down = share[:, :1], share[:, 1:]
        weight = np.concatenate(
            [(1 - down) * (1 - across), (1 - down) * across, down * (1 - across), down * across], axis=1
        )
        nearest = four[np.arange(len(four)), weight.argmax(1)]
        mixed = np.einsum("nk,nkd->nd", weight, four)
        return np.asarray(np.where(_one_surface(four)[:, None], mixed, nearest))


def reflectance_images(
    scan: Scan, source: str = "auto", *, eye: Float | None = None, seed: int = 0
) -> tuple[ReflectanceImage, ...]:
    """Returns the pictures of a scan: its raster, or views around every station where it has none.

    source  "intensity", "colour", or "auto": the first of these that the scan has
    eye     (3,) m local, where to look around from in a cloud without a raster; None: its stations

    Raises ValueError for a scan without intensity and colour, and for a cloud whose stations are not known
    when no `eye` is given.
    """
    if scan.grid is not None and len(scan.origins):
        return (raster_reflectance(scan, source, seed=seed),)
    stations = scan.origins if eye is None else np.asarray(eye, np.float64).reshape(1, 3)
    if not 0 < len(stations) <= _STATIONS:
        raise ValueError(f"{scan.name} has no stations; name a place to look from")
    surface = scanned_surface(scan, source, seed)
    if surface.tone is None:
        raise ValueError(f"{scan.name} has neither intensity nor colour")
    return tuple(image for place in stations for image in panorama_reflectance(surface, place))


def raster_reflectance(scan: Scan, source: str = "auto", *, seed: int = 0) -> ReflectanceImage:
    """Returns a structured scan in its own raster, as somebody who stands at the scanner sees it.

    Raises ValueError for a scan without a raster, without the place of its scanner, or without tones.
    """
    if scan.grid is None or not len(scan.origins):
        raise ValueError(f"{scan.name} has no raster, or the place of its scanner is not known")
    index = _as_seen(scan.xyz - scan.origins[0], scan.grid.index)
    measured = index >= 0
    tone = np.where(measured, point_tones(scan, source, seed)[index], 0.0)
    xyz = np.where(measured[..., None], scan.xyz[index], np.nan)
    return _image(tone, xyz, measured)


def panorama_reflectance(
    surface: ScannedSurface, eye: Float, focal: float | None = None
) -> tuple[ReflectanceImage, ...]:
    """Returns up to eight overlapping central projections of a cloud, from one place in all directions.

    eye    (3,) m local, where the level pinhole cameras stand
    focal  px; None: so that neighbouring points fall on neighbouring pixels

    Directions that show nothing are left out. Raises ValueError for a surface without tones.
    """
    if surface.tone is None:
        raise ValueError("the surface has neither intensity nor colour")
    focal = focal or _focal_around(surface, eye)
    tangents = np.tan((_ACROSS, _UP, _DOWN))
    half, up, down = np.maximum(np.round(focal * tangents), 8).astype(np.int64).tolist()
    camera = Camera("PINHOLE", 2 * half, up + down, np.array([focal, focal, half, up]))
    images = []
    for heading in np.arange(_VIEWS) * (2.0 * np.pi / _VIEWS):
        photo = _level_photo(camera, np.asarray(eye, np.float64), float(heading))
        drawn = render(photo, surface, 1.0)
        if not drawn.known.any():
            continue
        row, column = np.indices(drawn.known.shape)
        xyz = drawn.points(np.column_stack([column.ravel(), row.ravel()])).reshape(*drawn.known.shape, 3)
        images.append(_image(drawn.tone, np.where(drawn.known[..., None], xyz, np.nan), drawn.known))
    return tuple(images)


def facade_reflectance(
    surface: ScannedSurface,
    local_from_facade: Rigid3,
    extent: tuple[float, float, float, float],
    pixel: float,
) -> ReflectanceImage:
    """Returns the scan drawn on the plane of a facade, row 0 at the top.

    local_from_facade  X to the right as seen from the street, Y into the building, Z up
    extent             x0, z0, x1, z1 m in that frame
    pixel              m

    What lies up to 0.7 m before or behind the plane is drawn; the points of pixels lie on the relief. Raises
    ValueError for a surface without tones.
    """
    if surface.tone is None:
        raise ValueError("the surface has neither intensity nor colour")
    x0, z0, x1, z1 = extent
    at = local_from_facade.inverse.apply(surface.xyz)
    inside = (at[:, 0] > x0) & (at[:, 0] < x1) & (at[:, 2] > z0) & (at[:, 2] < z1)
    near = np.flatnonzero(inside & (np.abs(at[:, 1]) < _THICK_M))
    h, w = max(8, round((z1 - z0) / pixel)), max(8, round((x1 - x0) / pixel))
    position = np.column_stack([at[near, 0] - x0, z1 - at[near, 2]]) / pixel
    join = max(1.0, 0.6 * float(np.median(surface.spacing[near])) / pixel) if len(near) else 1.0
    layers = spread(position, np.column_stack([surface.tone[near], at[near, 1]]), (h, w), join)
    row, column = np.indices((h, w)) + 0.5
    flat = np.stack([x0 + column * pixel, layers.mean[..., 1], z1 - row * pixel], axis=-1)
    xyz = local_from_facade.apply(flat.reshape(-1, 3)).reshape(h, w, 3)
    return _image(layers.mean[..., 0], np.where(layers.known[..., None], xyz, np.nan), layers.known)


def _as_seen(ray: Float, index: Int) -> Int:
    """The raster (h, w) turned so that rows run down and columns to the right of somebody at the scanner."""
    up = ray[:, 2] / np.maximum(np.linalg.norm(ray, axis=1), 1e-9)
    azimuth = np.arctan2(ray[:, 1], ray[:, 0])
    if abs(_usual_step(np.arcsin(up), index.T)) > abs(_usual_step(np.arcsin(up), index)):
        index = index.T
    if _usual_step(np.arcsin(up), index) > 0:
        index = index[::-1]
    if _usual_step(azimuth, index.T) > 0:
        index = index[:, ::-1]
    return np.ascontiguousarray(index)


def _usual_step(angle: Float, index: Int) -> float:
    """Median difference (rad) of the angle (n,) between neighbouring rows of a raster; 0 without any."""
    some = index[:, :: -(-index.shape[1] // _SAMPLED)]
    both = (some[1:] >= 0) & (some[:-1] >= 0)
    step = angle[some[1:][both]] - angle[some[:-1][both]]
    return float(np.median((step + np.pi) % (2 * np.pi) - np.pi)) if both.any() else 0.0


def _image(tone: Array, xyz: Float, measured: Bool) -> ReflectanceImage:
    """The picture of log tones (h, w) where they were measured (h, w)."""
    known = measured | _small_holes(~measured)
    if not measured.any():
        return ReflectanceImage(np.zeros(tone.shape, np.uint8), xyz, known & False)
    root = np.exp(0.5 * np.where(measured, tone, 0.0))
    low, high = np.quantile(root[measured], _CLIP)
    level = np.clip((root - low) / max(float(high - low), 1e-9), 0.0, 1.0)
    whole = pull_push(level.astype(np.float32), measured)
    grey = np.clip(np.rint(255.0 * whole), 1, 255).astype(np.uint8)
    equal = cv2.createCLAHE(_CLAHE, (_TILES, _TILES)).apply(grey)
    return ReflectanceImage(np.where(known, np.maximum(equal, 1), 0).astype(np.uint8), xyz, known)


def pull_push(values: Array, known: Bool) -> Array:
    """Fills a picture (h, w) float32 where it is not known, smoothly, from coarser and coarser versions.

    After Gortler et al. (1996, The Lumigraph, section 3.4). A picture without any known pixel becomes 0.
    """
    weight = known.astype(np.float32)
    if known.all() or min(values.shape) <= 2:
        mean = float((values * weight).sum() / max(float(weight.sum()), 1e-9))
        return np.where(known, values, np.float32(mean))
    size = ((values.shape[1] + 1) // 2, (values.shape[0] + 1) // 2)
    share = cv2.resize(weight, size, interpolation=cv2.INTER_AREA)
    total = cv2.resize(values * weight, size, interpolation=cv2.INTER_AREA)
    there = share > 0
    coarse = pull_push(np.where(there, total / np.where(there, share, 1.0), 0.0).astype(np.float32), there)
    fine = cv2.resize(coarse, values.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.where(known, values, fine)


def _small_holes(empty: Bool) -> Bool:
    """Where no square one pixel wider than a small hole fits into what is empty; the border is empty too."""
    side = _HOLE_PX + 1
    square, padded = np.ones((side, side), np.uint8), np.pad(empty, side, constant_values=True)
    fits = cv2.erode(padded.astype(np.uint8), square, anchor=(0, 0), borderValue=1)
    wide = cv2.dilate(fits, square, anchor=(side - 1, side - 1), borderValue=0) > 0
    return np.asarray(empty & ~wide[side:-side, side:-side])


def _one_surface(four: Float) -> Bool:
    """Whether four neighbours (n, 4, 3) have no jump among them: their sides are alike."""
    sides = np.linalg.norm(four[:, [0, 2, 0, 1]] - four[:, [1, 3, 2, 3]], axis=2)
    with np.errstate(invalid="ignore"):
        longest, shortest = sides.max(1), np.maximum(sides.min(1), 1e-9)
        twist = np.linalg.norm(four[:, 0] - four[:, 1] - four[:, 2] + four[:, 3], axis=1)
        return np.asarray((longest < _JUMP * shortest) & (twist < longest))


def _level_photo(camera: Camera, eye: Float, heading: float) -> Photo:
    """A level photo that looks along (sin, cos) of its heading, rad from the y axis."""
    s, c = np.sin(heading), np.cos(heading)
    R = np.array([[c, 0.0, s], [-s, 0.0, c], [0.0, -1.0, 0.0]])
    pose = Estimate(Rigid3("local", "camera", R, eye), np.zeros((6, 6)), 0.0, Provenance.GIVEN)
    return Photo(f"view {np.degrees(heading):.0f}", camera, pose)


def _focal_around(surface: ScannedSurface, eye: Float) -> float:
    """The focal length (px) at which the median of neighbouring points is one pixel apart."""
    step = max(1, len(surface) // 20_000)
    distance = np.linalg.norm(surface.xyz[::step] - eye, axis=1)
    return float(np.clip(np.median(distance / surface.spacing[::step]), *_FOCAL_PX))
