"""The ortho-image of one facade, in the order of paper A's section 3."""

from collections.abc import Callable, Sequence

import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.model import Facade, Failed, OrthoImage, Photo, PhotoOffset, Scan
from frontage.ortho.bands import TILE, Bands, cut_out, fill, missed_by_photos
from frontage.ortho.consistency import photo_offset
from frontage.ortho.gaps import Gaps, local_gaps
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import OrthoRaster, facade_raster
from frontage.ortho.recess import DEEPEST_REVEAL
from frontage.ortho.relief import ReliefMap, measure_relief
from frontage.ortho.render import paint_photos
from frontage.ortho.scan_image import intensity_band, paint_scan, picture_kind
from frontage.ortho.views import OccluderCloud, ViewPlan, plan_views
from frontage.raster.tiles import tiles
from frontage.raster.zbuffer import local_spacing

_LONELY = 3  # points of one cube of the cloud below which they are noise and hide nothing


def make_ortho(
    facade: Facade,
    scan: Scan,
    photos: Sequence[Photo] = (),
    image_of: Callable[[str], Array] | None = None,
    surroundings: Scan | None = None,
    options: OrthoOptions | None = None,
) -> OrthoImage | Failed:
    """Make the ortho-image of `facade` from oriented photos, or where none sees it from the scan itself.

    `scan` is the cloud that `facade.support` indexes; `surroundings` is what else may hide the facade from a
    photo. `image_of(photo id)` gives the picture (h, w, 3) uint8. Photos without a pose are left out.

    Returns Failed when neither a photo nor a point shows the facade. Raises OptionError for a raster that is
    too large to store.
    """
    options = options or OrthoOptions()
    raster = facade_raster(facade, options)
    xyz_facade = facade.frame.inverse.apply(scan.xyz)
    near = _near(xyz_facade, raster, options)
    if not near.any() and not photos:
        return Failed("F301", f"facade {facade.id}: no point lies on it", "check the outline and the scan")
    gaps = _wall_gaps(xyz_facade[near], facade, raster)
    relief = measure_relief(xyz_facade[near], facade.spacing, raster, options, gaps)
    shown = relief if options.relief and options.projection == "full" else None
    bands = Bands(raster, relief=shown is not None)
    _fill_depth(bands.depth, raster, shown)
    points = _surface(xyz_facade, near, relief)
    intensity = intensity_band(scan, xyz_facade, points, raster, gaps)
    oriented = [p for p in photos if p.local_from_camera is not None]
    names: tuple[str, ...] = ()
    offset = None
    if oriented and image_of is not None:
        cloud = _cloud(scan, surroundings, facade, raster, options)
        plan = plan_views(facade, raster, shown, cloud, oriented, options)
        names, offset = _from_photos(bands, shown, facade, raster, plan, image_of, options)
    seen = len(names)
    if points.any():
        names += _from_scan(bands, scan, xyz_facade, points, raster, facade, gaps, seen)
    elif not names:
        return Failed("F302", f"facade {facade.id}: no photo and no point shows it", "check the poses")
    cut_out(bands, intensity, facade, raster, options)
    return OrthoImage(
        bands.pixels,
        raster.gsd,
        raster.corner,
        facade,
        bands.depth,
        bands.source,
        names,
        bands.gsd,
        intensity,
        offset,
        seen,
    )


def _from_photos(
    bands: Bands,
    relief: ReliefMap | None,
    facade: Facade,
    raster: OrthoRaster,
    plan: ViewPlan | None,
    image_of: Callable[[str], Array],
    options: OrthoOptions,
) -> tuple[tuple[str, ...], PhotoOffset | None]:
    """Paint every pixel from the photo planned for it, note what a photo pixel covers there.

    The photos' names, and where they see the facade off the scan's surface.
    """
    if plan is None:
        return (), None
    full = options.projection == "full"
    offset = photo_offset(facade, raster, relief, plan, image_of) if full else None
    deeper = offset.value if offset is not None and offset.applied else 0.0
    paint_photos(bands.pixels, bands.source, relief, facade, raster, plan, image_of, options, deeper)
    for tile in tiles(raster.height, raster.width, TILE):
        bands.gsd[tile.window] = plan.window(plan.gsd, tile)
    return tuple(p.id for p in plan.photos), offset


def _from_scan(
    bands: Bands,
    scan: Scan,
    xyz_facade: Float,
    points: Array,
    raster: OrthoRaster,
    facade: Facade,
    gaps: Gaps,
    photos: int,
) -> tuple[str, ...]:
    """Paint from the scan: all of it without photos, else what they miss if that is much; its name."""
    if photos == 0:
        return paint_scan(bands, scan, xyz_facade, points, raster, gaps)
    if not missed_by_photos(bands, facade, raster) or picture_kind(scan) == "depth":
        return ()
    own = Bands(raster)
    names = paint_scan(own, scan, xyz_facade, points, raster, gaps)
    return names if fill(bands, own, photos + 1, raster) else ()


def _near(xyz_facade: Float, raster: OrthoRaster, options: OrthoOptions) -> Array:
    """Which points (n,) lie within the raster and the facade's depth range."""
    at, y = raster.pixel(xyz_facade), xyz_facade[:, 1]
    inside = (at >= 0).all(1) & (at[:, 0] < raster.width) & (at[:, 1] < raster.height)
    return inside & (y >= -options.front) & (y <= options.back)


def _wall_gaps(near: Float, facade: Facade, raster: OrthoRaster) -> Gaps:
    """Gaps between the points (n, 3) m that are neither in a room nor far in front."""
    wall = near[np.abs(near[:, 1]) <= DEEPEST_REVEAL]
    return local_gaps(raster.pixel(wall), raster, facade.spacing / raster.gsd)


def _surface(xyz_facade: Float, near: Array, relief: ReliefMap | None) -> Array:
    """Which points (n,) are near and not behind the surface of their cell: no rooms behind windows."""
    if relief is None:
        return near
    return near & relief.in_front(xyz_facade)


def _fill_depth(depth: Array, raster: OrthoRaster, relief: ReliefMap | None) -> None:
    """Write the depth band; it stays NaN when there is no relief or it is not wanted."""
    if relief is None:
        return
    for tile in tiles(raster.height, raster.width, TILE):
        depth[tile.window] = relief.at(raster, tile)


def _cloud(
    scan: Scan, surroundings: Scan | None, facade: Facade, raster: OrthoRaster, options: OrthoOptions
) -> OccluderCloud:
    """Everything on the street side of the facade, with its local spacing; lonely points hide nothing."""
    clouds = [scan.xyz] if surroundings is None else [scan.xyz, surroundings.xyz]
    xyz, spacing = [], []
    for points in clouds:
        y = facade.frame.inverse.apply(points)[:, 1]
        ahead = points[y < options.back]
        s, k = local_spacing(ahead)
        surface = k >= _LONELY
        xyz.append(ahead[surface])
        spacing.append(s[surface])
    return OccluderCloud(np.concatenate(xyz), np.concatenate(spacing))
