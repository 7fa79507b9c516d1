"""A facade's plane from a wall of which 60 % of the points are clutter, beside the truth.

Prints offset and angle from the true plane next to the standard errors that Frontage reports, then the same
with the paper's 3-point RANSAC. Run it with ``python examples/plot_facade_plane.py``.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from scenes import Scene, wall_scene

from frontage.facades import FacadeOptions, find_facades
from frontage.model import Building, Facade


def find_wall(scene: Scene, method: str) -> Facade:
    whole = Building("B01", np.arange(len(scene.scan)), ground_z=0.0)
    facade = find_facades(scene.scan, whole, FacadeOptions(method=method))[0]
    if not facade:
        raise SystemExit(facade.message)
    return facade


def main() -> None:
    scene = wall_scene(seed=1, spacing=0.04, noise=0.005, clutter=0.6)
    true = scene.houses[0].local_from_facade
    print(f"{len(scene.scan)} points, 60 % of them clutter, 5 mm noise; wall 20 x 12 m")
    print(f"{'method':10}{'offset':>12}{'its sigma':>12}{'angle':>14}{'its sigma':>12}")
    for method in ("lo-msac", "paper"):
        facade = find_wall(scene, method)
        offset = true.inverse.apply(facade.frame.t[None])[0, 1]  # the barycentre's distance to the true plane
        turn = np.linalg.norm(np.cross(facade.frame.R[:, 1], true.R[:, 1]))
        sigma = facade.local_from_facade.sigma
        angles = f"{np.degrees(turn):>10.4f} deg{np.degrees(np.hypot(sigma[3], sigma[5])):>8.4f} deg"
        print(f"{method:10}{offset * 1000:>9.2f} mm{sigma[1] * 1000:>9.2f} mm{angles}")


if __name__ == "__main__":
    main()
