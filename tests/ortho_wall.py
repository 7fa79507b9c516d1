"""A textured wall whose true ortho-image is known in every pixel, with its facade, cloud and photographs.

The renderer follows photo pixel -> ray -> wall -> texture; the code under test follows facade pixel -> photo
pixel. They share only the camera model, which is tested against OpenCV. This analytic toy stays beside
`frontage.simulate` because the tests of ortho-images measure small fractions of a pixel, for which the
texture must be a plain array without light, lens blur or noise.
"""

import cv2
import numpy as np

from frontage.geometry.arrays import Array, Float
from frontage.geometry.rigid import Rigid3
from frontage.model import Camera, Estimate, Facade, Photo, Scan, WorldRef

WORLD = WorldRef(np.array([678000, 5403000, 400]), "EPSG:25832")
GSD = 0.01


def texture(width: float, height: float, seed: int = 0) -> Array:
    """Returns blurred noise (h, w, 3) uint8 at 1 cm, with structure at every scale that a photo resolves and
    none below."""
    rng = np.random.default_rng(seed)
    h, w = round(height / GSD), round(width / GSD)
    total = np.zeros((h, w, 3), np.float32)
    for sigma in (1.5, 4.0, 12.0):
        layer = cv2.GaussianBlur(rng.normal(size=(h, w, 3)).astype(np.float32), (0, 0), sigma)
        total += layer / layer.std()
    return np.clip(128 + 28 * total, 0, 255).astype(np.uint8)


def facade(
    width: float, height: float, azimuth: float = 0.4, spacing: float = 0.02, roughness: float = 0.003
):
    """Returns a vertical facade of width x height m, centred in its frame; the street lies at y < 0."""
    x = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    z = np.array([0.0, 0.0, 1.0])
    R = np.column_stack([x, np.cross(z, x), z])
    pose = Rigid3("local", "facade", R, np.array([60.0, 40.0, 8.0]))
    w, h = width / 2, height / 2
    ring = np.array([[-w, -h], [w, -h], [w, h], [-w, h]])
    none = np.empty(0, np.int64)
    estimate = Estimate(pose, np.eye(6) * 1e-8, 100.0)
    return Facade("B01/F1", "B01", estimate, WORLD, ring, (), none, none, roughness, spacing, 1.0, "rays")


def camera(width: int = 1200, height: int = 900, distorted: bool = True, focal: float = 0.75) -> Camera:
    """Returns a wide-angle camera: OPENCV with one per cent of distortion, or PINHOLE."""
    f = focal * width
    centre = (width / 2 + 7.3, height / 2 - 4.1)
    if distorted:
        return Camera("OPENCV", width, height, np.array([f, 1.001 * f, *centre, -0.09, 0.03, 4e-4, -3e-4]))
    return Camera("PINHOLE", width, height, np.array([f, 1.001 * f, *centre]))


def photo(
    facade: Facade, camera: Camera, position: tuple[float, float, float], target=(0.0, 0.0, 0.0), name="a.jpg"
):
    """Returns an upright photo from `position` towards `target`, both (x, y, z) m in the facade frame."""
    eye, aim = np.array(position, float), np.array(target, float)
    forward = (aim - eye) / np.linalg.norm(aim - eye)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    facade_from_camera = Rigid3(
        "facade", "camera", np.column_stack([right, np.cross(forward, right), forward]), eye
    )
    pose = Estimate(facade.frame @ facade_from_camera, np.zeros((6, 6)), np.inf)
    return Photo(name, camera, pose)


def render(photo: Photo, facade: Facade, picture: Array, depth=None, oversample: int = 1) -> Array:
    """Returns the image (h, w, 3) that the camera takes of `picture`, which hangs on the facade at
    depth(x, z) m (default 0)."""
    w, h, s = photo.camera.width, photo.camera.height, oversample
    u, v = np.meshgrid((np.arange(w * s) + 0.5) / s, (np.arange(h * s) + 0.5) / s)
    origin, ray = photo.ray(np.column_stack([u.ravel(), v.ravel()]))
    to = facade.frame.inverse
    origin, ray = to.apply(origin[None])[0], to.rotate(ray)
    y = np.zeros(len(ray))
    for _ in range(1 if depth is None else 2):
        point = origin + ray * ((y - origin[1]) / ray[:, 1])[:, None]
        y = y if depth is None else depth(point[:, 0], point[:, 2])
    rows, columns = picture.shape[:2]
    at_c = point[:, 0] / GSD + columns / 2 - 0.5
    at_r = rows / 2 - point[:, 2] / GSD - 0.5
    shape = (h * s, w * s)
    seen = cv2.remap(
        picture,
        np.nan_to_num(at_c, nan=-9.0).reshape(shape).astype(np.float32),
        np.nan_to_num(at_r, nan=-9.0).reshape(shape).astype(np.float32),
        cv2.INTER_LINEAR,
        borderValue=(90, 90, 90),
    )
    return cv2.resize(seen, (w, h), interpolation=cv2.INTER_AREA)


def wall_cloud(
    facade: Facade, spacing: float = 0.02, depth=None, noise: float = 0.003, holes=(), seed: int = 1
) -> Scan:
    """Returns a scan of the wall on a jittered lattice, coloured by place, without points in `holes`
    (x0, z0, x1, z1)."""
    rng = np.random.default_rng(seed)
    x0, z0, x1, z1 = facade.extent
    x, z = np.meshgrid(np.arange(x0, x1, spacing), np.arange(z0, z1, spacing))
    x, z = (g.ravel() + rng.uniform(-0.3, 0.3, g.size) * spacing for g in (x, z))
    y = (np.zeros_like(x) if depth is None else depth(x, z)) + rng.normal(0, noise, len(x))
    keep = np.ones(len(x), bool)
    for a0, b0, a1, b1 in holes:
        keep &= ~((x > a0) & (x < a1) & (z > b0) & (z < b1))
    xyz = np.column_stack([x, y, z])[keep]
    rgb = np.where((x[keep] < 0)[:, None], [200, 60, 40], [40, 80, 200]).astype(np.uint8)
    grey = np.where(z[keep] > 0, 0.8, 0.2).astype(np.float32)
    return Scan("wall", facade.frame.apply(xyz), WORLD, rgb=rgb, intensity=grey)


def grid(x, y, z, step: float = 0.03) -> Float:
    """Returns points (n, 3) on a lattice over ranges; a number is a range of one."""
    axes = [np.array([a]) if np.isscalar(a) else np.arange(*a, step) for a in (x, y, z)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)


def displacement(found: Array, truth: Array, tile: int = 96) -> Float:
    """Returns the shifts (n, 2) px between the tiles of two pictures of one size, by phase correlation."""
    grey = [
        cv2.cvtColor(np.ascontiguousarray(p[..., :3]), cv2.COLOR_RGB2GRAY).astype(np.float32)
        for p in (found, truth)
    ]
    window = cv2.createHanningWindow((tile, tile), cv2.CV_32F)
    shifts = []
    for r in range(tile // 2, grey[0].shape[0] - 3 * tile // 2 + 1, tile):
        for c in range(tile // 2, grey[0].shape[1] - 3 * tile // 2 + 1, tile):
            a, b = (g[r : r + tile, c : c + tile] for g in grey)
            shifts.append(cv2.phaseCorrelate(b, a, window)[0])
    return np.array(shifts)


def scanned_window(
    facade: Facade, ring, reveal: float, eye, spacing: float, noise: float = 0.003, seed: int = 0
) -> Scan:
    """Returns the scan from `eye` of a wall with one recess (x0, z0, x1, z1) that is `reveal` m deep."""
    rng = np.random.default_rng(seed)
    x0, z0, x1, z1 = facade.extent
    x, z = np.meshgrid(np.arange(x0, x1, spacing), np.arange(z0, z1, spacing))
    x, z = (g.ravel() + rng.uniform(-0.2, 0.2, g.size) * spacing for g in (x, z))
    eye = np.array(eye, float)
    beam = np.column_stack([x, np.zeros_like(x), z]) - eye
    inside = (x > ring[0]) & (x < ring[2]) & (z > ring[1]) & (z < ring[3])
    back = (reveal - eye[1]) / -eye[1]
    with np.errstate(divide="ignore"):
        side_x = np.where(beam[:, 0] > 0, ring[2] - eye[0], ring[0] - eye[0]) / beam[:, 0]
        side_z = np.where(beam[:, 2] > 0, ring[3] - eye[2], ring[1] - eye[2]) / beam[:, 2]
    reach = np.where(inside, np.minimum(np.minimum(side_x, side_z), back), 1.0)
    xyz = eye + beam * reach[:, None] + rng.normal(0.0, noise, beam.shape) * [0.0, 1.0, 0.0]
    return Scan("window", facade.frame.apply(xyz), WORLD)
