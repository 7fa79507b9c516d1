"""A simulated street as files: LAZ with stations, JPEGs, a COLMAP text model, truth.json, project.toml."""

import dataclasses
import json
from pathlib import Path

import cv2
import laspy
import numpy as np
import pyproj

from frontage.geometry.arrays import Float
from frontage.geometry.rigid import Rigid3, quaternion_from_rotation
from frontage.model import Camera, Scan
from scenes import Scene, render_photo

PROJECT = """[project]
crs = "{crs}"
seed = 0

[[scans]]
path = "scan.laz"

[photos]
path = "photos/*.jpg"
cameras = "colmap"
offset = [{0}.0, {1}.0, {2}.0]

[ortho]
gsd = {gsd}
"""


def write(folder: Path, scene: Scene, photos: int = 4, width: int = 1500, gsd: float = 0.01) -> Path:
    """Write the scene and `photos` pictures of `width` pixels spread along it. Returns the project file."""
    (folder / "photos").mkdir(parents=True, exist_ok=True)
    (folder / "colmap").mkdir(exist_ok=True)
    write_laz(folder / "scan.laz", scene.scan)
    camera = default_camera(width)
    poses = {f"photo_{k + 1}.jpg": pose for k, pose in enumerate(default_poses(scene, photos))}
    for name, pose in poses.items():
        image = render_photo(scene, camera, pose)
        cv2.imwrite(str(folder / "photos" / name), image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 92])
    write_colmap(folder / "colmap", camera, poses)
    (folder / "truth.json").write_text(json.dumps(truth(scene), indent=1) + "\n")
    project = folder / "project.toml"
    project.write_text(PROJECT.format(*scene.world.origin.tolist(), crs=scene.world.crs, gsd=gsd))
    return project


def default_camera(width: int = 1500) -> Camera:
    """A wide lens with a realistic distortion (COLMAP's OPENCV model), held upright, 3:4."""
    height, f = width * 4 // 3, 0.7 * width
    return Camera(
        "OPENCV", width, height, np.array([f, f, width / 2 + 3.2, height / 2 - 2.1, -0.06, 0.02, 4e-4, -3e-4])
    )


def default_poses(scene: Scene, count: int = 4) -> list[Rigid3]:
    """local_from_camera of hand-held photos from across the street, looking up and not quite square."""
    rng = np.random.default_rng(17)
    out = []
    for s in (np.arange(count) + 0.5) / count * scene.length:
        eye = np.array([s + rng.uniform(-0.5, 0.5), -12.0, scene.slope * s + 1.6])
        target = np.array([s + rng.uniform(-1.5, 1.5), 0.0, scene.slope * s + 5.5])
        out.append(scene.local_from_street @ look_at(eye, target))
    return out


def look_at(eye: Float, target: Float, to: str = "street") -> Rigid3:
    """to_from_camera: x right, y down, z towards the target."""
    z = (target - eye) / np.linalg.norm(target - eye)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return Rigid3(to, "camera", np.column_stack([x, np.cross(z, x), z]), np.asarray(eye, float))


def write_laz(path: Path, scan: Scan) -> None:
    """LAS 1.4 point format 7, CRS as WKT, point_source_id = station, stations beside it."""
    header = laspy.LasHeader(point_format=7, version="1.4")
    header.scales, header.offsets = np.full(3, 1e-4), scan.world.origin.astype(float)
    if scan.world.crs is not None:
        header.add_crs(pyproj.CRS.from_user_input(scan.world.crs))
    las = laspy.LasData(header)
    las.xyz = scan.world.to_world(scan.xyz)
    las.intensity = (scan.intensity * 65535).astype(np.uint16)
    las.point_source_id = (scan.origin_index + 1).astype(np.uint16)
    if scan.rgb is not None:
        las.red, las.green, las.blue = (scan.rgb.astype(np.uint16) * 257).T
    las.write(str(path))
    rows = [
        {"station": i + 1, "position": p} for i, p in enumerate(scan.world.to_world(scan.origins).tolist())
    ]
    Path(f"{path}.stations.json").write_text(json.dumps(rows, indent=1) + "\n")


def write_colmap(folder: Path, camera: Camera, poses: dict[str, Rigid3]) -> None:
    """COLMAP text model in local coordinates (the project file holds the offset)."""
    params = " ".join(repr(float(p)) for p in camera.params)
    (folder / "cameras.txt").write_text(f"1 {camera.model} {camera.width} {camera.height} {params}\n")
    lines = []
    for i, (name, pose) in enumerate(poses.items()):
        camera_from_local = pose.inverse
        numbers = (*quaternion_from_rotation(camera_from_local.R), *camera_from_local.t)
        lines.append(f"{i + 1} {' '.join(repr(float(v)) for v in numbers)} 1 {name}\n\n")
    (folder / "images.txt").write_text("".join(lines))
    (folder / "points3D.txt").write_text("")


def truth(scene: Scene) -> dict[str, object]:
    """Houses in world coordinates, for people and scripts."""
    houses = []
    for h in scene.houses:
        frame = h.local_from_facade
        ends = frame.apply(np.array([[0.0, 0, 0], [h.width, 0, 0]]))
        houses.append(
            {
                "id": h.id, "width": h.width, "height": h.height, "offset": h.offset,
                "foot": scene.world.to_world(ends).tolist(),
                "frame": {"origin": scene.world.to_world(frame.t).tolist(), "x": frame.R[:, 0].tolist(),
                          "y": frame.R[:, 1].tolist(), "z": frame.R[:, 2].tolist()},
                "openings": [dataclasses.asdict(o) for o in h.openings],
            }
        )  # fmt: skip
    return {"crs": scene.world.crs, "houses": houses}
