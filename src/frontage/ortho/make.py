"""The entry function of the room: the ortho-image of one facade, in the order of paper A, section 3."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from frontage.geometry.arrays import Array
from frontage.model import Facade, Failed, OrthoImage, Photo, Scan
from frontage.ortho.bands import Bands, clear_outside
from frontage.ortho.checks.agreement import Turn, check_photos
from frontage.ortho.checks.excluded import why_no_photo
from frontage.ortho.cloud import in_facade_frame
from frontage.ortho.consistency import photo_offset
from frontage.ortho.corners import find_corners
from frontage.ortho.decoded import DecodedPhotos
from frontage.ortho.mosaic.compose import compose_mosaic
from frontage.ortho.occluders import find_occluders
from frontage.ortho.options import OrthoOptions
from frontage.ortho.orthoraster import facade_raster
from frontage.ortho.photo_image import paint_photos
from frontage.ortho.points import facade_points
from frontage.ortho.rectified import CellPhotos
from frontage.ortho.relief import measure_relief
from frontage.ortho.scan_image import intensity_band, paint_missing_from_scan
from frontage.ortho.standing.find import find_standing
from frontage.ortho.surface import ImageOf
from frontage.ortho.symmetry import fill_by_symmetry
from frontage.ortho.views import plan_views


def make_ortho(
    facade: Facade,
    scan: Scan,
    photos: Sequence[Photo] = (),
    image_of: ImageOf | None = None,
    *,
    surroundings: Scan | None = None,
    options: OrthoOptions | None = None,
    turns: Mapping[str, Turn] | None = None,
    light: Mapping[str, Array] | None = None,
) -> OrthoImage | Failed:
    """Makes the ortho-image of `facade` from oriented photos, and from the scan where no photo shows it.

    `scan` is the cloud that `facade.support` refers to; `surroundings` holds what else may hide the facade
    from a photo. `image_of(photo id)` returns the picture (h, w, 3) uint8. Photos without a pose are ignored,
    and so are all photos without `image_of`. `turns` names the photos whose EXIF orientation the cameras may
    or may not mean, each with the function that turns its pixels; `check_photos` decides. `light` is that
    of other ortho-images, whose look this one takes where they share photos.

    Returns Failed (F301, F302) when neither a photo nor a scan point shows the facade. Raises OptionError
    (I320) when the raster would be too large to store.
    """
    options, given = options or OrthoOptions(), () if image_of is None else photos
    image_of = DecodedPhotos(image_of or _no_picture)
    photos_used = [p for p in given if p.local_from_camera is not None]

    # Section 3: a raster with a fixed ratio of pixels to metres, and the points that lie on it.
    raster, xyz = facade_raster(facade, options), in_facade_frame(scan, facade)
    points = facade_points(scan, facade, raster, standing := find_standing(facade, scan, xyz), options, xyz)
    if not points.used.any() and not photos:
        return Failed("F301", f"facade {facade.id}: no scan point lies on it", "check outline and scan")

    # The paper neglects balconies and sculptures; here the pixels lie on the measured relief.
    relief = measure_relief(points.xyz_used, facade, raster, options, points.gaps)
    points = points.on_surface(relief)
    bands, intensity = Bands(raster, relief if options.draws_relief else None), intensity_band(points, raster)
    surface = bands.surface(facade, raster)

    # Section 3.2, several photos: how well each shows every part that it does not hide.
    hides = find_occluders(facade, points.xyz, standing, surroundings, options, scan) if photos_used else None
    plan = plan_views(surface, hides, photos_used, options)
    cells = CellPhotos.of(surface, plan, image_of)
    check = check_photos(plan, points, cells, turns or {})
    plan, image_of = check.kept(plan), check.images(image_of, turns or {})
    offset = photo_offset(surface, plan, image_of, options)

    # One photo for every part, in one light; then, as in sections 3.1 and 3.2, project and resample.
    surface = surface.moved_by(offset)
    cells = cells and cells.again(surface, options.projection, image_of, check.turned)
    mosaic = compose_mosaic(surface, plan, cells, options, light or {})
    painted = paint_photos(bands, surface, mosaic, image_of, options)
    names = painted + paint_missing_from_scan(bands, points, surface, len(painted))
    if not names:
        return Failed("F302", f"facade {facade.id}: no photo and no scan point shows it", "check the poses")
    clear_outside(bands, intensity, surface, find_corners(points.xyz, relief), options)
    fill_by_symmetry(bands, raster, options)
    ortho = bands.as_ortho_image(
        facade, raster, names, intensity=intensity, photo_offset=offset, photos=len(painted)
    )
    remarks = check.remarks + why_no_photo(surface, given, plan, check.left_out)
    told = replace(ortho, remarks=remarks, occluders=standing.occluders)
    return told if mosaic is None else replace(told, light=mosaic.light)


def _no_picture(photo: str) -> Array:
    raise KeyError(photo)
