"""pycolmap's incremental mapping: run it on pairs, and turn its models into blocks."""

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from frontage.geometry.rigid import Rigid3
from frontage.model import Estimate, Photo
from frontage.orientation.nouns import Block, KeyPoints, PairMatches
from frontage.orientation.ties import colmap as door
from frontage.orientation.ties.database import fill
from frontage.orientation.ties.options import TieOptions

_INIT_ANGLES_DEG = (16.0, 4.0, 1.5)  # median angle of the first pair's rays, tried in turn


def run_mapper(
    colmap: Any,
    photos: Sequence[Photo],
    keypoints: Sequence[KeyPoints],
    pairs: Sequence[PairMatches],
    options: TieOptions,
) -> Iterator[list[Any]]:
    """Yields COLMAP's models of the photos, the largest first; image k + 1 is photo k.

    Photos of one facade may meet its points at small angles only, and pairs with large angles may have many
    false matches, so the demand on the first pair is lowered step by step, as long as models are asked for.
    """
    if not pairs:
        return
    with tempfile.TemporaryDirectory(prefix="frontage-") as folder:
        path = Path(folder) / "database.db"
        fill(colmap, path, photos, keypoints, pairs)
        for angle in _INIT_ANGLES_DEG:
            output = Path(folder) / f"{angle:g}"
            output.mkdir()
            found = colmap.incremental_mapping(path, folder, output, _settings(colmap, options, angle))
            models = [found[k] for k in sorted(found)]
            yield sorted(models, key=lambda m: (-m.num_reg_images(), -m.num_points3D()))


def _settings(colmap: Any, options: TieOptions, angle: float) -> Any:
    chosen = colmap.IncrementalPipelineOptions(
        num_threads=1, random_seed=options.seed, extract_colors=False, min_model_size=2
    )
    chosen.ba_refine_focal_length = chosen.ba_refine_extra_params = options.self_calibrate
    mapper = chosen.mapper
    # The adjustments on the way only have to keep the block in shape: `polish` adjusts it in full at the end.
    chosen.ba_global_function_tolerance = chosen.ba_local_function_tolerance = 1e-5
    chosen.ba_global_max_num_iterations, chosen.ba_local_max_num_iterations = 15, 10
    chosen.ba_global_max_refinements = chosen.ba_local_max_refinements = 1
    mapper.ba_global_ignore_redundant_points3D = True
    mapper.abs_pose_refine_focal_length = mapper.abs_pose_refine_extra_params = options.self_calibrate
    mapper.num_threads, mapper.random_seed = 1, options.seed
    mapper.init_min_tri_angle = angle
    mapper.init_min_num_inliers = 60
    chosen.triangulation.random_seed = options.seed
    chosen.triangulation.ignore_two_view_tracks = False  # photos at the end of a walk have no others
    chosen.triangulation.min_angle = min(1.0, angle)
    mapper.filter_min_tri_angle = min(1.0, angle)
    return chosen


def to_block(model: Any, photos: Sequence[Photo], keypoints: Sequence[KeyPoints]) -> Block:
    """Returns COLMAP's model as a block; pixels are those of the key points, in full precision."""
    numbers = np.array(sorted(i - 1 for i in model.reg_image_ids()), np.int64)
    place = {int(n): k for k, n in enumerate(numbers)}
    ids = sorted(model.point3D_ids())
    rows = np.array(
        [
            (place[e.image_id - 1], j, e.point2D_idx)
            for j, i in enumerate(ids)
            for e in model.point3D(i).track.elements
        ],
        np.int64,
    ).reshape(-1, 3)
    rows = rows[np.lexsort([rows[:, 2], rows[:, 0], rows[:, 1]])]
    pixels, sizes = np.zeros((len(rows), 2)), np.zeros(len(rows))
    for k, n in enumerate(numbers.tolist()):
        mine = rows[:, 0] == k
        pixels[mine], sizes[mine] = keypoints[n].pixels[rows[mine, 2]], keypoints[n].scale[rows[mine, 2]]
    points = np.array([model.point3D(i).xyz for i in ids]).reshape(-1, 3)
    oriented = tuple(_oriented(model, photos[n], n + 1) for n in numbers.tolist())
    return Block(numbers, oriented, points, rows[:, 0], rows[:, 1], pixels, sizes)


def _oriented(model: Any, photo: Photo, number: int) -> Photo:
    """The photo with the pose and camera of the model; the covariance is not known here (NaN)."""
    image = model.image(number)
    pose = image.cam_from_world().inverse()
    motion = Rigid3("local", "camera", pose.rotation.matrix(), pose.translation)
    camera = door.camera_from_colmap(model.camera(image.camera_id))
    return Photo(photo.id, camera, Estimate(motion, np.full((6, 6), np.nan), 0.0), photo.time)
