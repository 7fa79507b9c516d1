"""The folder OUT/orientation: key points and matches of photos, their poses, a COLMAP model."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from frontage.io.colmapwrite import Tracks, write_colmap
from frontage.io.photos.photoset import PhotoSet
from frontage.model import WorldRef
from frontage.orientation import Drawing, KeyPoints, Orientation, PairMatches
from frontage.pipeline.store import orientation
from frontage.pipeline.store.files import write_array, write_json
from frontage.pipeline.store.folder import Folder


class OrientationFolder(Folder):
    """A run folder, as far as it concerns the orientation of photos."""

    def with_oriented_poses(self, photos: PhotoSet, world: WorldRef) -> PhotoSet:
        """Return the photos with the poses and cameras that orienting them found.

        Photos that could not be oriented have no pose. Raises FileError if the report is missing or damaged.
        """
        found = orientation.oriented_photos(self.orientation_folder, world)
        placed = tuple(found.get(p.id, replace(p, local_from_camera=None)) for p in photos.photos)
        return replace(photos, photos=placed)

    def save_orientation(self, found: Orientation, given: PhotoSet, world: WorldRef) -> None:
        """Write `orientation/report.json` and the oriented photos as a COLMAP text model."""
        folder = self.orientation_folder
        write_json(folder / orientation.REPORT, orientation.report_record(found, given.photos, world))
        photos = [p.photo for p in found.photos]
        tracks = Tracks(found.point, found.photo, found.pixels)
        model = write_colmap(folder / "colmap", photos, world.origin.astype(np.float64), found.points, tracks)
        self.wrote(folder / orientation.REPORT, *sorted(model.iterdir()))
        for drawing in found.drawings:
            self._save_drawing(drawing)

    def _save_drawing(self, drawing: Drawing) -> None:
        """Write `reflectance/IMG_0001.png`, and the points behind its pixels as `IMG_0001.npy`."""
        stem = self.orientation_folder / "reflectance" / drawing.photo.replace("\\", "/").replace("/", "_")
        picture, points = stem.with_suffix(".png"), stem.with_suffix(".npy")
        self.put(picture, cv2.imencode(".png", drawing.pixels)[1].tobytes())
        write_array(points, drawing.xyz)
        self.wrote(points)

    def save_key_points(self, number: int, points: KeyPoints) -> None:
        """Write the key points of a photo, which has this number among the given ones."""
        path = self._ties_path("keypoints", number)
        orientation.save_key_points(path, points)
        self.wrote(path)

    def key_points(self, number: int) -> KeyPoints:
        """Return the key points of a photo. Raises FileError."""
        return orientation.load_key_points(self._ties_path("keypoints", number))

    def save_matches(self, number: int, pairs: list[PairMatches]) -> None:
        """Write the matches of a photo with later ones."""
        path = self._ties_path("matches", number)
        orientation.save_matches(path, pairs)
        self.wrote(path)

    def matches(self, number: int) -> list[PairMatches]:
        """Return the matches of a photo with later ones. Raises FileError."""
        return orientation.load_matches(self._ties_path("matches", number))

    def _ties_path(self, kind: str, number: int) -> Path:
        return self.orientation_folder / "ties" / f"{kind}_{number:04d}.npz"
