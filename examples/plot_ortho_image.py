"""An ortho-image of a simulated facade from photographs, and how far its windows are from the truth.

Takes two photos of a street with a distorting lens, makes the ortho-image of one house at 1 cm and measures
the edges of its window panes in it. With a file name it writes the picture:
``python examples/plot_ortho_image.py out.png``.
"""

import sys
from pathlib import Path

import cv2
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from scene_files import default_camera, default_poses
from scenes import FACADE, OpeningTruth, Scene, render_photo, street_scene

from frontage.facades import find_facades
from frontage.model import Building, Estimate, OrthoImage, Photo
from frontage.ortho import OrthoOptions, make_ortho


def make(scene: Scene, number: int) -> OrthoImage:
    """The ortho-image of house `number` from two photos."""
    own = np.flatnonzero((scene.house == number) & (scene.label == FACADE))
    facade = find_facades(scene.scan, Building("B01", own, ground_z=0.0))[0]
    if not facade:
        raise SystemExit(facade.message)
    camera = default_camera(1200)
    poses = [Estimate(pose, np.zeros((6, 6)), 1.0) for pose in default_poses(scene, 2)]
    photos = [Photo(f"photo {k}", camera, pose) for k, pose in enumerate(poses)]
    pictures = {p.id: render_photo(scene, camera, p.pose) for p in photos}
    ortho = make_ortho(facade, scene.scan, photos, pictures.__getitem__, options=OrthoOptions(gsd=0.01))
    if not ortho:
        raise SystemExit(ortho.message)
    return ortho


def edge_errors(scene: Scene, number: int, ortho: OrthoImage, opening: OpeningTruth) -> list[float]:
    """Metres from the true left and right edge of a window's glass to the steepest grey step in the image."""
    house = scene.houses[number]
    z = opening.z0 + 0.25
    x = np.array([opening.x0, opening.x1]) + np.array([0.06, -0.06])  # the frame is 6 cm wide
    glass = house.local_from_facade.apply(np.column_stack([x, np.full(2, opening.depth), np.full(2, z)]))
    (left, right), _ = ortho.pixel_from_local(glass)
    grey = ortho.pixels[int(left[1]), :, :3].astype(float).mean(1)
    errors = []
    for column, sign in ((left[0], 1), (right[0], -1)):
        window = slice(round(column) - 5, round(column) + 5)
        step = np.maximum(-np.diff(grey)[window] * sign, 0)  # from the white frame to the dark glass
        if step.sum() > 60:
            found = (np.arange(window.start, window.stop) + 1) @ step / step.sum()
            errors.append((found - column) * ortho.gsd)
    return errors


def main() -> None:
    scene = street_scene(houses=2, spacing=0.015, trees=False, cars=False)
    ortho = make(scene, 1)
    windows = [o for o in scene.houses[1].openings if o.kind == "window"]
    errors = np.array([e for o in windows for e in edge_errors(scene, 1, ortho, o)])
    width, height = ortho.size
    print(f"ortho-image {width} x {height} px at {ortho.gsd * 100:g} cm from {len(ortho.sources)} photos")
    print(f"{len(errors)} window edges: median error {np.median(np.abs(errors)) * 1000:.1f} mm,")
    print(f"mean {errors.mean() * 1000:+.1f} mm; a pixel is {ortho.gsd * 1000:g} mm")
    if len(sys.argv) > 1:
        cv2.imwrite(sys.argv[1], cv2.cvtColor(ortho.pixels, cv2.COLOR_RGBA2BGRA))


if __name__ == "__main__":
    main()
